#include "bodies.hpp"

#include <stdexcept>

#include "ductile/membrane/capsule.hpp"
#include "ductile/membrane/mesh.hpp"
#include "ductile/rigid/body.hpp"

namespace ductile::drivers {
namespace {

membrane::Mesh unplaced_mesh(const BodyOptions& options, const BodySetup& setup) {
  return options.shape == BodyShape::biconcave ? membrane::biconcave(setup.frequency, setup.radius)
                                               : membrane::icosphere(setup.frequency, setup.radius);
}

class CapsuleBody final : public ImmersedBody {
 public:
  CapsuleBody(const BodyOptions& options, const LatticeSetup& lattice, const BodySetup& setup)
      : lattice_(lattice),
        energy_unit_(setup.moduli.k_s * setup.radius * setup.radius),
        capsule_(make(options, lattice, setup)) {}

  [[nodiscard]] std::size_t marker_count() const override {
    return static_cast<std::size_t>(capsule_->vertex_count());
  }
  [[nodiscard]] std::span<const double> positions() const override { return capsule_->positions(); }
  [[nodiscard]] int corrections() const override { return capsule_->corrections(); }
  void predict_force(std::span<double> force) override { capsule_->predict_force(force); }
  void correct_force(std::span<const double> velocity, const coupling::Response& response,
                     std::span<double> increment) override {
    capsule_->correct_force(
        velocity,
        [&](std::span<const double> force, std::span<double> answer) {
          response.apply(force, answer);
        },
        increment);
  }
  void advance(std::span<const double> velocity) override { capsule_->advance(velocity); }

  [[nodiscard]] BodySample sample() const override {
    const membrane::Shape shape = capsule_->shape();
    // The centroid one step ago, from the velocities that moved the vertices since.
    const membrane::Shell& shell = capsule_->shell();
    const membrane::VecPtr before(shell.create_vec());
    membrane::petsc_check(VecWAXPY(before.get(), -1, capsule_->state().velocities.get(),
                             capsule_->state().positions.get()));
    BodySample sample;
    sample.position = lattice_.position(shape.centroid);
    sample.velocity = lattice_.velocity(shape.centroid - shell.shape(before.get()).centroid);
    sample.capsule = true;
    sample.deformation = shape.taylor_deformation();
    sample.volume_error = capsule_->volume_error();
    sample.strain_energy = capsule_->energies().strain / energy_unit_;
    return sample;
  }
  [[nodiscard]] std::span<const double> velocities() const override {
    return capsule_->velocities();
  }
  [[nodiscard]] std::span<const double> forces() const override { return capsule_->forces(); }

 private:
  static std::unique_ptr<membrane::Capsule> make(const BodyOptions& options,
                                                 const LatticeSetup& lattice,
                                                 const BodySetup& setup) {
    const membrane::Mesh reference = unplaced_mesh(options, setup);
    membrane::Mesh placed = reference;
    membrane::place(placed, setup.rotation, setup.centre);
    membrane::CapsuleOptions capsule;
    capsule.mobility = options.membrane.mobility;
    capsule.viscosity = lattice.nu;
    capsule.integrator = membrane::make_integrator(options.membrane.integrator);
    return std::make_unique<membrane::Capsule>(reference, placed.vertices, setup.moduli, capsule);
  }

  const LatticeSetup& lattice_;
  double energy_unit_;
  std::unique_ptr<membrane::Capsule> capsule_;
};

class RigidBody final : public ImmersedBody {
 public:
  RigidBody(const BodyOptions& options, const LatticeSetup& lattice, const BodySetup& setup)
      : lattice_(lattice), body_(make(options, lattice, setup)) {
    velocities_.resize(3 * marker_count());
  }

  [[nodiscard]] std::size_t marker_count() const override { return body_.marker_count(); }
  [[nodiscard]] std::span<const double> positions() const override { return body_.positions(); }
  [[nodiscard]] int corrections() const override { return body_.corrections(); }
  void predict_force(std::span<double> force) override { body_.predict_force(force); }
  void correct_force(std::span<const double> velocity, const coupling::Response& /*response*/,
                     std::span<double> increment) override {
    body_.correct_force(velocity, increment);
  }
  void advance(std::span<const double> velocity) override {
    velocities_.assign(velocity.begin(), velocity.end());
    body_.advance(velocity);
  }

  [[nodiscard]] BodySample sample() const override {
    BodySample sample;
    sample.position = lattice_.position(body_.state().position);
    sample.velocity = lattice_.velocity(body_.state().velocity);
    return sample;
  }
  [[nodiscard]] std::span<const double> velocities() const override { return velocities_; }
  [[nodiscard]] std::span<const double> forces() const override { return {}; }

 private:
  static rigid::Body make(const BodyOptions& options, const LatticeSetup& lattice,
                          const BodySetup& setup) {
    const membrane::Mesh mesh = unplaced_mesh(options, setup);
    rigid::Options rigid;
    rigid.density_ratio = options.density_ratio;
    rigid.gravity = lattice.gravity;
    rigid.corrections = options.rigid.iterations;
    rigid::State state;
    state.position = setup.centre;
    state.orientation = Eigen::Quaterniond(setup.rotation);
    return {{mesh.vertices, membrane::vertex_areas(mesh)}, rigid::ball(setup.radius), rigid, state};
  }

  const LatticeSetup& lattice_;
  rigid::Body body_;
  std::vector<double> velocities_;
};

}  // namespace

std::unique_ptr<ImmersedBody> make_body(const Scenario& scenario, const LatticeSetup& setup,
                                        std::size_t index) {
  const BodyOptions& options = scenario.bodies.at(index);
  if (options.kind == BodyKind::capsule) {
    return std::make_unique<CapsuleBody>(options, setup, setup.bodies.at(index));
  }
  return std::make_unique<RigidBody>(options, setup, setup.bodies.at(index));
}

std::vector<std::array<int, 3>> surface_triangles(const Scenario& scenario,
                                                  const LatticeSetup& setup, std::size_t index) {
  return unplaced_mesh(scenario.bodies.at(index), setup.bodies.at(index)).triangles;
}

}  // namespace ductile::drivers
