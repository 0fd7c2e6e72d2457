#include "ductile/suspension/body.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "ductile/suspension/markers.hpp"

namespace ductile::suspension {
namespace {

// U and omega for which the sum of weight |U + omega x arm - velocity|^2 is least.
struct RigidMotion {
  Eigen::Vector3d velocity;
  Eigen::Vector3d angular_velocity;
};
RigidMotion nearest_rigid_motion(std::span<const double> weights,
                                 std::span<const Eigen::Vector3d> arms,
                                 std::span<const Eigen::Vector3d> velocities) {
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector<double, 6> momentum = Eigen::Vector<double, 6>::Zero();
  for (std::size_t m = 0; m < arms.size(); ++m) {
    Eigen::Matrix<double, 3, 6> motion;  // velocity at the arm, of U and omega
    motion.leftCols<3>().setIdentity();
    for (int a = 0; a < 3; ++a) motion.col(3 + a) = Eigen::Vector3d::Unit(a).cross(arms[m]);
    normal += weights[m] * motion.transpose() * motion;
    momentum += weights[m] * motion.transpose() * velocities[m];
  }
  const Eigen::Vector<double, 6> nearest = normal.ldlt().solve(momentum);
  return {nearest.head<3>(), nearest.tail<3>()};
}

// See Observation::marker. Of those that a mesh's symmetry makes alike the first, whatever
// round-off says.
std::size_t foremost(std::span<const double> positions, const Eigen::Vector3d& centre) {
  const auto score = [&](std::size_t n) {
    return positions[n + 2] - std::abs(positions[n + 1] - centre.y());
  };
  std::size_t best = 0;
  for (std::size_t n = 3; n < positions.size(); n += 3) {
    if (score(n) > score(best) + 1e-9) best = n;
  }
  return best;
}

class CapsuleBody final : public Body {
 public:
  CapsuleBody(const Plan& plan, const BodyPlan& body)
      : units_(plan.units),
        plan_(body),
        capsule_(make(plan, body)),
        markers_(*capsule_),
        marker_(foremost(capsule_->positions(), body.centre)) {}

  [[nodiscard]] coupling::Body& markers() override { return markers_; }
  [[nodiscard]] std::vector<double> positions() const override {
    return outside(capsule_->positions());
  }
  [[nodiscard]] std::span<const double> inner_positions() const override {
    return capsule_->positions();
  }
  [[nodiscard]] std::vector<double> velocities() const override {
    const std::span<const double> v = capsule_->velocities();
    std::vector<double> result(v.begin(), v.end());
    if (plan_.retraction() == 0) return result;
    result = positions();
    std::ranges::transform(result, former(), result.begin(), std::minus());
    return result;
  }
  [[nodiscard]] std::span<const double> forces() const override { return capsule_->forces(); }
  [[nodiscard]] Observation observe() const override {
    const membrane::Shell& shell = capsule_->shell();
    const membrane::Shape shape = shell.shape(positions());
    const Eigen::Vector3d displacement = shape.centroid - shell.shape(former()).centroid;
    Observation seen{units_,           plan_,          shape.centroid, displacement, turning(shape),
                     capsule_->slip(), capsule_.get(), shape};
    seen.marker = Eigen::Vector3d::Map(&capsule_->positions()[marker_]);
    return seen;
  }
  [[nodiscard]] membrane::SolveStatistics solver() const override { return capsule_->statistics(); }
  void save(const StateWriter& write) const override { capsule_->save(write); }
  void load(const StateReader& read) override { capsule_->load(read); }

 private:
  static std::unique_ptr<membrane::Capsule> make(const Plan& plan, const BodyPlan& body) {
    const CapsulePlan& kind = *body.capsule();
    const surface::Mesh reference = body.marker_mesh();
    surface::Mesh placed = reference;
    surface::place(placed, body.rotation, body.centre);
    membrane::CapsuleOptions options;
    options.mobility = kind.mobility;
    options.viscosity = plan.units.viscosity();
    options.integrator = membrane::make_integrator(kind.integrator, kind.integrator_options);
    const InitialFlow flow(plan);
    std::vector<Eigen::Vector3d> velocities;
    for (const Eigen::Vector3d& x : placed.vertices)
      velocities.push_back(flow.at(x.x(), x.y()).velocity);
    return std::make_unique<membrane::Capsule>(reference, placed.vertices, kind.moduli, options,
                                               velocities);
  }

  // The surface about a membrane.
  [[nodiscard]] std::vector<double> outside(std::span<const double> membrane) const {
    return surface::offset(membrane, capsule_->shell().triangles(), plan_.retraction());
  }
  // Where the surface was one step ago, by the velocities that moved the vertices since.
  [[nodiscard]] std::vector<double> former() const {
    std::vector<double> x(capsule_->positions().size());
    std::ranges::transform(capsule_->positions(), capsule_->velocities(), x.begin(), std::minus());
    return outside(x);
  }

  // Observation::angular_velocity.
  [[nodiscard]] Eigen::Vector3d turning(const membrane::Shape& shape) const {
    surface::Mesh now{{}, capsule_->shell().triangles()};
    std::vector<Eigen::Vector3d> arms;
    std::vector<Eigen::Vector3d> vertex_velocities;
    const std::vector<double> x = positions();
    const std::vector<double> v = velocities();
    for (std::size_t n = 0; n < x.size(); n += 3) {
      now.vertices.emplace_back(Eigen::Vector3d::Map(&x[n]));
      arms.emplace_back(now.vertices.back() - shape.centroid);
      vertex_velocities.emplace_back(Eigen::Vector3d::Map(&v[n]));
    }
    return nearest_rigid_motion(surface::vertex_areas(now), arms, vertex_velocities)
        .angular_velocity;
  }

  const Units& units_;
  const BodyPlan& plan_;
  std::unique_ptr<membrane::Capsule> capsule_;
  CapsuleMarkers markers_;
  std::size_t marker_;  // where its coordinates are among the positions
};

class RigidBody final : public Body {
 public:
  RigidBody(const Plan& plan, const BodyPlan& body)
      : units_(plan.units),
        plan_(body),
        body_(make(plan, body)),
        markers_(body_),
        surface_(body.mesh().vertices) {
    const InitialFlow flow(plan);
    const std::span<const double> x = body_.positions();
    for (std::size_t n = 0; n < x.size(); n += 3)
      Eigen::Vector3d::Map(&markers_.velocity()[n]) = flow.at(x[n], x[n + 1]).velocity;
  }

  [[nodiscard]] coupling::Body& markers() override { return markers_; }
  [[nodiscard]] std::vector<double> positions() const override {
    const Eigen::Matrix3d rotation = body_.state().orientation.toRotationMatrix();
    std::vector<double> x(3 * surface_.size());
    for (std::size_t v = 0; v < surface_.size(); ++v)
      Eigen::Vector3d::Map(&x[3 * v]) = body_.state().position + rotation * surface_[v];
    return x;
  }
  [[nodiscard]] std::span<const double> inner_positions() const override {
    return body_.positions().first(3 * surface_.size());
  }
  [[nodiscard]] std::vector<double> velocities() const override {
    const std::span<const double> u = std::as_const(markers_).velocity();
    const std::span<const double> x = body_.positions();
    std::vector<double> result = positions();
    for (std::size_t n = 0; n < result.size(); n += 3) {
      auto at = Eigen::Vector3d::Map(&result[n]);
      const Eigen::Vector3d out = at - Eigen::Vector3d::Map(&x[n]);
      at = Eigen::Vector3d::Map(&u[n]) + body_.state().angular_velocity.cross(out);
    }
    return result;
  }
  [[nodiscard]] std::span<const double> forces() const override { return {}; }
  [[nodiscard]] Observation observe() const override {
    const rigid::State& state = body_.state();
    Observation seen{units_,          plan_, state.position, state.velocity, state.angular_velocity,
                     body_.slip().max};
    seen.rigid = &body_;
    return seen;
  }
  [[nodiscard]] rigid::Body* rigid() override { return &body_; }
  void save(const StateWriter& write) const override {
    body_.save(write);
    write("fluid_velocity", markers_.velocity());
  }
  void load(const StateReader& read) override {
    body_.load(read);
    read("fluid_velocity", markers_.velocity());
  }

 private:
  // A body as dense as the fluid has no momentum of its own: it starts with the rigid motion that
  // the flow gives its surface, without force or torque in eqs. (13)-(14). Any other starts at
  // rest, and its first step depends on that.
  static void drift(const InitialFlow& flow, const rigid::Surface& surface, rigid::State& state) {
    std::vector<Eigen::Vector3d> arms;
    std::vector<Eigen::Vector3d> velocities;
    for (const Eigen::Vector3d& marker : surface.markers) {
      arms.emplace_back(state.orientation * marker);
      const Eigen::Vector3d x = state.position + arms.back();
      velocities.push_back(flow.at(x.x(), x.y()).velocity);
    }
    const RigidMotion start = nearest_rigid_motion(surface.areas, arms, velocities);
    state.velocity = start.velocity;
    state.angular_velocity = start.angular_velocity;
  }
  static rigid::Body make(const Plan& plan, const BodyPlan& body) {
    const RigidPlan& kind = *body.rigid();
    rigid::Options options;
    options.density_ratio = kind.density_ratio;
    options.gravity = plan.gravity;
    options.corrections = kind.corrections;
    options.memory = kind.memory;
    const rigid::Surface markers = markers_of(plan, body);
    rigid::State state;
    state.position = body.centre;
    state.orientation = Eigen::Quaterniond(body.rotation);
    if (kind.density_ratio == 1) drift(InitialFlow(plan), markers, state);
    return {markers, rigid::solid_of(*body.shape), options, state};
  }

  static rigid::Surface markers_of(const Plan& plan, const BodyPlan& body) {
    const RigidPlan& kind = *body.rigid();
    const double missed = kind.slip / plan.units.viscosity();
    return kind.interior == Interior::solid
               ? rigid::lined(*body.shape, body.frequency, kind.retraction, missed)
               : rigid::markers_of(body.marker_mesh(), missed);
  }

  const Units& units_;
  const BodyPlan& plan_;
  rigid::Body body_;
  RigidMarkers markers_;
  // In the body's frame; the markers of its vertices come before any inside the body.
  std::vector<Eigen::Vector3d> surface_;
};

}  // namespace

std::unique_ptr<Body> make_body(const Plan& plan, std::size_t index) {
  const BodyPlan& body = plan.bodies.at(index);
  if (body.capsule() != nullptr) return std::make_unique<CapsuleBody>(plan, body);
  return std::make_unique<RigidBody>(plan, body);
}

}  // namespace ductile::suspension
