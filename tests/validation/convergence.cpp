// What doc/convergence.md needs besides channel runs, as CSV: a rigid sphere in a cubic array and
// one that is driven towards a wall, the lift on one held in a channel, and a capsule in weak
// shear, on lattices of several spacings; with markers on the surface and a lattice at rest
// ("plain"), and with what makes up for both.
//
//   convergence_cases array|wall|lift|shear ...
#include <petscsys.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "ductile/coupling/coupler.hpp"
#include "ductile/suspension/felt_surface.hpp"
#include "ductile/suspension/suspension.hpp"
#include "validation/sphere_array.hpp"
#include "validation/wall.hpp"

namespace {

using namespace ductile;
using Eigen::Vector3d;
using suspension::Plan;

void row(std::string_view name, std::string_view method, double tau, double radius, double value,
         double law) {
  std::printf("%s,%s,%g,%.4f,%.5f,%.5f\n", std::string(name).c_str(), std::string(method).c_str(),
              tau, radius, value, law);
  std::fflush(stdout);
}

// Drag in the array of Zick & Homsy 1982, table 2, of a volume fraction of 0.027.
void array() {
  constexpr double ratio = 0.186105;
  constexpr double K = 2.008;
  for (const int L : {18, 22, 26, 32, 40, 48}) {
    const double a = ratio * L;
    fluid::Options fluid;  // that of drag_coefficient()
    fluid.tau = 1;
    fluid.collision = fluid::Collision::trt;
    const auto [inwards, slip] = suspension::felt_place(surface::Sphere(a), fluid);
    row("array", "plain", 1, a, test::drag_coefficient(L, a, K, 0), K);
    row("array", "corrected", 1, a,
        test::drag_coefficient(L, a, K, inwards, test::Interior::fluid, slip), K);
  }
}

// Of a sphere driven towards a wall, at gaps of a and 0.4 a; 12 radii to the next sphere and wall.
void wall() {
  constexpr double size = 12;
  for (const double a : {4.0, 4.8, 6.0, 7.2}) {
    const suspension::FeltPlace felt = suspension::felt_place(surface::Sphere(a), fluid::Options{});
    for (const auto& [name, gap, law] : {std::tuple{"wall-far", 1.0, test::wall_law_far},
                                         {"wall-near", 0.4, test::wall_law_near}}) {
      row(name, "plain", 1, a, test::wall_resistance(a, gap * a, 0, size), law);
      row(name, "corrected", 1, a,
          test::wall_resistance(a, gap * a, felt.retraction, size, felt.slip), law);
    }
  }
}

// A rigid sphere that may move along z and turn about y alone, by multi-direct forcing as that of
// rigid::Body.
class Held final : public coupling::Body {
 public:
  Held(rigid::Surface surface, const Vector3d& centre, double velocity)
      : surface_(std::move(surface)),
        centre_(centre),
        velocity_(velocity),
        positions_(3 * marker_count()),
        force_(3 * marker_count(), 0.0) {
    place();
  }

  [[nodiscard]] std::size_t marker_count() const override { return surface_.markers.size(); }
  [[nodiscard]] std::span<const double> positions() const override { return positions_; }
  [[nodiscard]] int corrections() const override { return 2; }
  void predict_force(std::span<double> force) override {
    for (std::size_t n = 0; n < force_.size(); ++n) force[n] = force_[n] *= 0.9;
  }
  void correct_force(std::span<const double> u, const coupling::Response& /*response*/,
                     std::span<double> increment) override {
    // The velocities for which force along z and torque about y vanish with this increment.
    Eigen::Matrix2d answer = Eigen::Matrix2d::Zero();
    Eigen::Vector2d drive = Eigen::Vector2d::Zero();
    for (std::size_t m = 0; m < marker_count(); ++m) {
      const auto motion = motion_of(m);
      answer += motion.transpose() * weight(m) * motion;
      drive += motion.transpose() * (weight(m) * fluid_at(u, m) - Vector3d::Map(&force_[3 * m]));
    }
    const Eigen::Vector2d found = answer.inverse() * drive;
    velocity_ = found[0];
    for (std::size_t m = 0; m < marker_count(); ++m) {
      const Vector3d force = weight(m) * (motion_of(m) * found - fluid_at(u, m));
      Vector3d::Map(&increment[3 * m]) = force;
      Vector3d::Map(&force_[3 * m]) += force;
    }
  }
  void advance(std::span<const double> /*velocity*/) override {
    lift_ = 0;
    for (std::size_t m = 0; m < marker_count(); ++m) lift_ -= force_[3 * m];
    centre_.z() += velocity_;
    place();
  }
  // Force of the fluid on it along x in the latest step.
  [[nodiscard]] double lift() const { return lift_; }
  [[nodiscard]] double velocity() const { return velocity_; }

 private:
  // Velocity of a marker by that along z and the turn about y.
  [[nodiscard]] Eigen::Matrix<double, 3, 2> motion_of(std::size_t m) const {
    const Vector3d& r = surface_.markers[m];
    Eigen::Matrix<double, 3, 2> motion;
    motion << 0, r.z(), 0, 0, 1, -r.x();
    return motion;
  }
  // The projection along the surface, of a sphere.
  [[nodiscard]] Eigen::Matrix3d along(std::size_t m) const {
    const Vector3d n = surface_.markers[m].normalized();
    return Eigen::Matrix3d::Identity() - n * n.transpose();
  }
  [[nodiscard]] Eigen::Matrix3d weight(std::size_t m) const {
    const double share = 1 / (1 + 2 * kappa * surface_.missed) - 1;
    return 2 * kappa * surface_.areas[m] * (Eigen::Matrix3d::Identity() + share * along(m));
  }
  [[nodiscard]] Vector3d fluid_at(std::span<const double> u, std::size_t m) const {
    return Vector3d::Map(&u[3 * m]) +
           surface_.missed / surface_.areas[m] * (along(m) * Vector3d::Map(&force_[3 * m]));
  }
  void place() {
    for (std::size_t m = 0; m < marker_count(); ++m)
      Vector3d::Map(&positions_[3 * m]) = centre_ + surface_.markers[m];
  }

  static constexpr double kappa = 2;
  rigid::Surface surface_;
  Vector3d centre_;
  double velocity_;
  std::vector<double> positions_, force_;
  double lift_ = 0;
};

// C_L = L 4 W^2/(U_max^2 a^4) at x = 0.3 W, a = 0.4 W, Re = 10, 6 W of half a channel, from t = 2
// to 3 W^2/nu. No law: the limit is that of the lattices.
double lift_coefficient(int nodes, double tau, bool corrected) {
  Plan plan;
  const double W = nodes / 2.0;
  plan.fluid.nodes = {nodes, nodes / 2, static_cast<int>(6 * W)};
  plan.fluid.boundary = {fluid::Boundary::halfway, fluid::Boundary::halfway,
                         fluid::Boundary::periodic};
  plan.fluid.mirror = fluid::Mirror::between_nodes;
  plan.fluid.tau = tau;
  plan.units = Plan::channel_units(plan.fluid);
  plan.drive(10);
  const Vector3d centre = plan.units.lattice_position({0.3, 0, 0});
  const double carried = suspension::InitialFlow(plan).at(centre.x(), centre.y()).velocity.z();
  const double a = 0.4 * W;
  if (corrected) {
    plan.fluid.equilibrium = fluid::Equilibrium::incompressible;
    plan.ride(carried);
  }
  const surface::Sphere sphere(a);
  suspension::FeltPlace place;
  if (corrected) place = suspension::felt_place(sphere, plan.fluid);
  const int frequency = surface::frequency_for_edge(a, 1.2);
  Held body(rigid::markers_of(sphere.mesh(frequency, -place.retraction),
                              place.slip / plan.units.viscosity()),
            centre, carried);
  fluid::Fluid fluid = suspension::make_fluid(plan, MPI_COMM_SELF);
  coupling::Coupler coupler(fluid, {{0, &body}}, 1);
  double sum = 0;
  int count = 0;
  while (plan.units.time(fluid.time()) < 3) {
    coupler.step();
    if (corrected && fluid.time() % 8 == 0)  // as a suspension whose lattice follows
      fluid.accelerate((body.velocity() - fluid.motion().velocity) / 64);
    if (plan.units.time(fluid.time()) < 2) continue;
    sum += body.lift();
    ++count;
  }
  return sum / count * 4 * W * W / (plan.u_max * plan.u_max * std::pow(a, 4));
}

void lift() {
  for (const int nodes : {20, 24, 30, 36, 48}) {
    for (const double tau : {1.0, 0.8, 0.6}) {
      for (const bool corrected : {false, true}) {
        row("lift", corrected ? "corrected" : "plain", tau, 0.2 * nodes,
            lift_coefficient(nodes, tau, corrected), NAN);
      }
    }
  }
}

// D/Ca of a Skalak capsule of C = k_a/k_s in weak shear between plates ten radii apart.
double deformation(double a, double C, bool corrected) {
  constexpr double eta = 1.0 / 6;
  constexpr double capillary = 0.002;
  const double rate = 0.1 * eta / (a * a);
  const int size = static_cast<int>(std::lround(10 * a));
  Plan plan;
  plan.fluid.nodes = {size, size, size};
  plan.fluid.boundary[0] = fluid::Boundary::halfway;
  const Vector3d u(0, 0, rate * size / 2);
  plan.fluid.wall_velocity[0] = {-u, u};
  plan.units = Plan::channel_units(plan.fluid);
  plan.drive(0);
  plan.follow = corrected;
  suspension::BodyPlan body;
  body.name = "capsule";
  body.shape = surface::make_shape("sphere", a);
  body.frequency = surface::frequency_for_edge(a, 1.2);
  body.centre = plan.units.lattice_position({0, 0.3 / size, 0.5 / size});
  suspension::CapsulePlan capsule;
  capsule.retraction = corrected ? suspension::felt_retraction(*body.shape, plan.fluid) : 0;
  capsule.moduli.k_s = eta * rate * a / capillary;
  capsule.moduli.k_a = C * capsule.moduli.k_s;
  const double factor =
      suspension::felt_modulus_factor(*body.shape, capsule.retraction, capsule.moduli, plan.fluid);
  capsule.moduli.k_s *= factor;
  capsule.moduli.k_a *= factor;
  capsule.moduli.k_v = capsule.moduli.k_s;
  body.kind = capsule;
  plan.bodies = {body};
  suspension::Suspension suspension(plan, PETSC_COMM_SELF);
  while (static_cast<double>(suspension.steps()) * rate < 0.6) suspension.step();
  return suspension::sample(suspension.own(0)->observe())["deformation"] / capillary;
}

// Small-deformation theory, and 1% by the walls.
void shear() {
  for (const double C : {1.0, 2.0}) {
    for (const double a : {3.2, 4.0, 4.8, 6.0, 7.2, 9.6}) {
      for (const bool corrected : {false, true}) {
        row(C == 1 ? "shear-1" : "shear-2", corrected ? "corrected" : "plain", 1, a,
            deformation(a, C, corrected), 1.01 * 3.75 * (2 + 3 * C) / (1 + 2 * C));
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) return 1;
  bool known = argc > 1;
  for (int n = 1; n < argc; ++n) {
    const std::string_view name = argv[n];
    known = known && (name == "array" || name == "wall" || name == "lift" || name == "shear");
  }
  if (!known) {
    std::fprintf(stderr, "usage: convergence_cases array|wall|lift|shear ...\n");
    return PetscFinalize() != 0 ? 1 : 2;
  }
  for (int n = 1; n < argc; ++n) {
    const std::string_view name = argv[n];
    if (name == "array") array();
    if (name == "wall") wall();
    if (name == "lift") lift();
    if (name == "shear") shear();
  }
  return PetscFinalize() != 0 ? 1 : 0;
}
