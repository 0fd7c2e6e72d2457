#include "bodies.hpp"

#include "adapters.hpp"
#include "ductile/surface/biconcave.hpp"
#include "ductile/surface/mesh.hpp"
#include "ductile/surface/sphere.hpp"

namespace ductile::drivers {
namespace {

surface::Mesh unplaced_mesh(const BodyOptions& options, const BodySetup& setup) {
  return options.shape == BodyShape::biconcave
             ? surface::Biconcave(setup.radius).mesh(setup.frequency)
             : surface::icosphere(setup.frequency, setup.radius);
}

class CapsuleBody final : public ImmersedBody {
 public:
  CapsuleBody(const BodyOptions& options, const LatticeSetup& lattice, const BodySetup& setup)
      : lattice_(lattice),
        energy_unit_(setup.moduli.k_s * setup.radius * setup.radius),
        capsule_(make(options, lattice, setup)),
        markers_(*capsule_) {}

  [[nodiscard]] coupling::Body& markers() override { return markers_; }
  [[nodiscard]] std::span<const double> positions() const override { return capsule_->positions(); }
  [[nodiscard]] std::span<const double> velocities() const override {
    return capsule_->velocities();
  }
  [[nodiscard]] std::span<const double> forces() const override { return capsule_->forces(); }
  [[nodiscard]] BodySample sample() const override {
    const membrane::Shape shape = capsule_->shape();
    // The centroid one step ago, from the velocities that moved the vertices since.
    const membrane::Shell& shell = capsule_->shell();
    const membrane::VecPtr before = shell.create_vec();
    membrane::petsc_check(VecWAXPY(before.get(), -1, capsule_->state().velocities.get(),
                                   capsule_->state().positions.get()));
    BodySample sample;
    sample.position = lattice_.position(shape.centroid);
    sample.velocity = lattice_.velocity(shape.centroid - shell.shape(before.get()).centroid);
    sample.slip = lattice_.velocity(Eigen::Vector3d::UnitX()).x() * capsule_->slip();
    sample.capsule = true;
    sample.deformation = shape.taylor_deformation();
    sample.volume_error = capsule_->volume_error();
    // Without stiffness there is neither strain energy nor a unit for it.
    sample.strain_energy = energy_unit_ > 0 ? capsule_->energies().strain / energy_unit_ : 0;
    return sample;
  }
  [[nodiscard]] membrane::SolveStatistics solver() const override { return capsule_->statistics(); }

 private:
  static std::unique_ptr<membrane::Capsule> make(const BodyOptions& options,
                                                 const LatticeSetup& lattice,
                                                 const BodySetup& setup) {
    const surface::Mesh reference = unplaced_mesh(options, setup);
    surface::Mesh placed = reference;
    surface::place(placed, setup.rotation, setup.centre);
    membrane::CapsuleOptions capsule;
    capsule.mobility = options.membrane.mobility;
    capsule.viscosity = lattice.nu;
    capsule.integrator = membrane::make_integrator(
        options.membrane.integrator,
        {options.membrane.theta, options.membrane.substeps, options.membrane.step_cuts});
    return std::make_unique<membrane::Capsule>(reference, placed.vertices, setup.moduli, capsule);
  }

  const LatticeSetup& lattice_;
  double energy_unit_;
  std::unique_ptr<membrane::Capsule> capsule_;
  CapsuleMarkers markers_;
};

class RigidBody final : public ImmersedBody {
 public:
  RigidBody(const BodyOptions& options, const LatticeSetup& lattice, const BodySetup& setup)
      : lattice_(lattice),
        body_(make(options, lattice, setup)),
        markers_(body_),
        surface_(static_cast<std::size_t>(3 * (10 * setup.frequency * setup.frequency + 2))) {}

  [[nodiscard]] coupling::Body& markers() override { return markers_; }
  [[nodiscard]] std::span<const double> positions() const override {
    return body_.positions().first(surface_);
  }
  [[nodiscard]] std::span<const double> velocities() const override {
    return markers_.velocity().first(surface_);
  }
  [[nodiscard]] std::span<const double> forces() const override { return {}; }
  [[nodiscard]] BodySample sample() const override {
    BodySample sample;
    sample.position = lattice_.position(body_.state().position);
    sample.velocity = lattice_.velocity(body_.state().velocity);
    sample.slip = lattice_.velocity(Eigen::Vector3d::UnitX()).x() * body_.slip().max;
    return sample;
  }

 private:
  static rigid::Body make(const BodyOptions& options, const LatticeSetup& lattice,
                          const BodySetup& setup) {
    const surface::Sphere shape(setup.radius);
    rigid::Options rigid;
    rigid.density_ratio = options.density_ratio;
    rigid.gravity = lattice.gravity;
    rigid.corrections = options.rigid.iterations;
    rigid.memory = options.rigid.memory;
    rigid::State state;
    state.position = setup.centre;
    state.orientation = Eigen::Quaterniond(setup.rotation);
    const rigid::Solid solid = rigid::solid_of(shape);
    const rigid::Surface markers =
        rigid::markers_of(shape.mesh(setup.frequency, -options.rigid.retraction));
    return {rigid::lined(markers, solid, rigid), solid, rigid, state};
  }

  const LatticeSetup& lattice_;
  rigid::Body body_;
  RigidMarkers markers_;
  std::size_t surface_;  // numbers of the mesh's vertices, which come before any inside the body
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
