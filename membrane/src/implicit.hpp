// Backward Euler, at any stiffness.
#pragma once

#include <limits>

#include "implicit_step.hpp"

namespace ductile::membrane {

/// x^(n+1) = x^n + u + (2 theta R + eps) F with F = -dE/dx(x^(n+1)), by Newton's method (PETSc's
/// SNES, options prefix "membrane_"); first order. Converged means |r| <= snes_rtol |F| +
/// snes_atol, norms over all forces: what the fluid receives differs from the elastic force at the
/// new positions by no more. The tangent is kept over solves (-membrane_tangent_lag) while few
/// iterations suffice.
class Implicit final : public ImplicitStep {
 public:
  // Times of steps: doc/integrators.md.
  static SchemeTraits traits() {
    return {.reach = std::numeric_limits<double>::infinity(), .cost = 18};
  }

  Implicit(const Shell& shell, Vec mobility, const IntegratorOptions& options);

 private:
  void solve(Vec unknown) override;
  SNESConvergedReason newton(Vec unknown);
  bool solved(Vec unknown, SNESConvergedReason reason);

  static PetscErrorCode function(SNES snes, Vec y, Vec r, void* self);
  static PetscErrorCode jacobian(SNES snes, Vec y, Mat matrix, Mat preconditioner, void* self);
  static PetscErrorCode converged(SNES snes, PetscInt iteration, PetscReal y_norm,
                                  PetscReal step_norm, PetscReal residual,
                                  SNESConvergedReason* reason, void* self);

  SnesPtr snes_;
  VecPtr residual_, guess_;
  bool full_newton_ = false;  // a new tangent at each iteration
  double target_ = 0;
  double left_ = 0;  // |r| at the latest look
};

}  // namespace ductile::membrane
