// A capsule: a shell, its state, and the integrator that moves it.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

#include "ductile/membrane/integrator.hpp"
#include "ductile/membrane/shell.hpp"
#include "ductile/surface/mesh.hpp"

namespace ductile::membrane {

struct CapsuleOptions {
  /// Membrane mobility in units of dx/eta: vertex i slips through the fluid with eps_i F_i, eps_i =
  /// mobility/(eta A_i), A_i its reference area. 0 switches it off.
  double mobility = 1e-3;
  /// The fluid's dynamic viscosity eta; there is no default.
  double viscosity = 0;
  IntegratorFactory integrator = make_integrator("explicit-euler");
};

/// A step that a capsule cannot take: positions and velocities are those before it, forces its own.
class VertexFailure : public std::runtime_error {
 public:
  enum class Reason {
    force_not_finite,     ///< the membrane's force: a triangle collapsed
    velocity_not_finite,  ///< the vertex's velocity: the fluid blew up
    too_fast              ///< the vertex moves more than Capsule::max_displacement in a step
  };
  /// `displacement`: length of the vertex's step, in lattice spacings; not a number where its force
  /// or velocity is not finite.
  VertexFailure(Reason reason, int vertex, double displacement);

  [[nodiscard]] Reason reason() const { return reason_; }
  [[nodiscard]] int vertex() const { return vertex_; }
  [[nodiscard]] double displacement() const { return displacement_; }

 private:
  Reason reason_;
  int vertex_;
  double displacement_;
};

/// A capsule in a fluid. The calls that make up a step come in the order that integrator.hpp
/// describes: predict_force, correct_force as often as corrections() says, advance. All arrays hold
/// 3n numbers, interlaced, in lattice units; spans given out are valid until the next call that is
/// not const. Uses PETSC_COMM_SELF alone: no call is collective, and only the rank that owns the
/// capsule has it. Must go before PetscFinalize().
class Capsule {
 public:
  /// Farthest that a vertex may move in one step, in lattice spacings.
  static constexpr double max_displacement = 0.5;

  /// `reference` is the unstressed shape, wherever it lies; `positions` are where its vertices
  /// start. The two may differ in shape: a pre-inflated capsule starts larger than its reference.
  /// `velocities` are what velocities() tells before the first step, 0 if empty; without inertia,
  /// nothing that follows depends on them. Throws std::invalid_argument as Shell does, and if
  /// `positions` or `velocities` do not fit `reference` or are not finite, for a negative mobility,
  /// and for a viscosity that is not positive where the mobility needs it.
  Capsule(const surface::Mesh& reference, std::span<const Eigen::Vector3d> positions,
          const Moduli& moduli, const CapsuleOptions& options,
          std::span<const Eigen::Vector3d> velocities = {});
  // The integrator refers to the shell within.
  Capsule(const Capsule&) = delete;
  Capsule& operator=(const Capsule&) = delete;

  [[nodiscard]] int vertex_count() const { return shell_.vertex_count(); }
  [[nodiscard]] const Shell& shell() const { return shell_; }
  /// Positions, velocities and forces as PETSc vectors.
  [[nodiscard]] const State& state() const { return state_; }
  /// x^n.
  [[nodiscard]] std::span<const double> positions() const;
  /// Velocities of the vertices in the latest step, slip included; before the first those of the
  /// start.
  [[nodiscard]] std::span<const double> velocities() const;
  /// Forces on the fluid in the latest step.
  [[nodiscard]] std::span<const double> forces() const;

  /// What the integrator has spent.
  [[nodiscard]] SolveStatistics statistics() const { return integrator_->statistics(); }

  [[nodiscard]] int corrections() const { return integrator_->corrections(); }
  /// force <- what the capsule exerts on the fluid as far as it is known from x^n and the steps
  /// before. Throws VertexFailure.
  void predict_force(std::span<double> force);
  /// increment <- what to add to it, given the fluid's velocity with the force so far in. Throws
  /// VertexFailure or SolveFailure; std::logic_error if corrections() is 0.
  void correct_force(std::span<const double> fluid_velocity, const Response& response,
                     std::span<double> increment);
  /// Moves the vertices by one time step, given the fluid's velocity with the whole force in.
  /// Throws VertexFailure.
  void advance(std::span<const double> fluid_velocity);

  /// Writes positions, velocities, forces and slip of the latest step, and what the integrator
  /// remembers under "integrator/..."; between two steps.
  void save(const StateWriter& write) const;
  /// Takes over what save() of a capsule of the same reference, moduli and options wrote, wherever
  /// that one was, and goes on to the last bit as it would have (see Integrator::load()). The
  /// integrator is made anew, and reads its options of PETSc again. Passes on
  /// what `read` throws; the capsule is then as it was.
  void load(const StateReader& read);

  [[nodiscard]] Shape shape() const { return shell_.shape(state_.positions.get()); }
  [[nodiscard]] Energies energies() const { return shell_.energies(state_.positions.get()); }
  /// V/V0 - 1, V0 the reference volume.
  [[nodiscard]] double volume_error() const;
  /// Largest |v - u| of the latest step, u the fluid's velocity at the vertex: the mobility's slip,
  /// that of theta > 1/2, and of a scheme that extrapolates what it has added to u.
  [[nodiscard]] double slip() const { return slip_; }

 private:
  template <class Slip, class Io>
  static void transfer_parts(const State& state, Slip& slip, const Io& io);

  Shell shell_;
  State state_;
  VecPtr mobility_;        // eps_i, three times each
  VecPtr fluid_velocity_;  // work space
  VecPtr result_;          // of the integrator, until it has passed its check
  IntegratorFactory make_integrator_;
  std::unique_ptr<Integrator> integrator_;
  double slip_ = 0;
};

}  // namespace ductile::membrane
