// Shells at rest under given forces.
#pragma once

#include <petscsnes.h>
#include <petscvec.h>

#include <stdexcept>

#include "ductile/membrane/shell.hpp"

namespace ductile::membrane {

struct EquilibriumOptions {
  /// What may be left of dE/dx - f, over the larger of f and what that was at the start; 2-norms.
  /// Round-off in dE/dx is let pass in any case.
  double tolerance = 1e-9;
  int max_steps = 200;  ///< systems of equations to solve, failed ones included
};

/// What a solution took and is.
struct Equilibrium {
  int steps = 0;              ///< systems of equations solved
  int newton_iterations = 0;  ///< in all of them
  double residual = 0;        ///< |dE/dx - f|, force
  /// How many independent small motions lower E - f.x: 0 at a minimum. Those of a shell that f
  /// would turn round or turn over count.
  int unstable_modes = 0;
};

/// No equilibrium was found.
class EquilibriumFailure : public std::runtime_error {
 public:
  enum class Reason {
    max_steps,  ///< EquilibriumOptions::max_steps used up
    no_descent  ///< no step, however short, could be solved and lowered the energy
  };
  EquilibriumFailure(Reason reason, SNESConvergedReason latest, int newton_iterations,
                     double residual, double target);

  [[nodiscard]] Reason reason() const { return reason_; }
  /// How the latest solve ended.
  [[nodiscard]] SNESConvergedReason latest() const { return latest_; }
  /// In all solves.
  [[nodiscard]] int newton_iterations() const { return newton_iterations_; }
  /// |dE/dx - f|, force.
  [[nodiscard]] double residual() const { return residual_; }

 private:
  Reason reason_;
  SNESConvergedReason latest_;
  int newton_iterations_;
  double residual_;
};

/// Finds x where E(x) - f.x is stationary, downhill from the start; f are fixed forces on the
/// vertices, which do not turn with the shell. `positions` is the start, then the solution; both
/// vectors hold 3n numbers. Not collective.
///
/// The way there is that of a shell in a very viscous fluid: implicit Euler steps of growing length
/// in dx/dt = f - dE/dx, shorter again where one cannot be solved or does not lower E - f.x. Each
/// is solved by SNES (options prefix membrane_static_; by default Newton's method with the exact
/// tangent, whose sparse part is factored and preconditions the whole). The last steps are so long
/// that they are Newton's. What drag is left then keeps the tangent regular and the shell in place
/// in the motions that cost nothing: translations, and rotations that leave f.x as it is. From a
/// shape far away, raise f in several calls.
///
/// Throws std::invalid_argument if f is not balanced (the total of its forces, or of their torques
/// at the start, above 1e-9 of the sum of their sizes), for vectors of the wrong size, a start with
/// a collapsed triangle, a shell that resists no deformation, and a tolerance or max_steps that is
/// not positive; EquilibriumFailure where there is no convergence: `positions` is then what has the
/// least energy so far.
Equilibrium find_equilibrium(const Shell& shell, Vec force, Vec positions,
                             const EquilibriumOptions& options = {});

}  // namespace ductile::membrane
