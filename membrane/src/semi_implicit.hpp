// One Newton step of the implicit scheme: cheap stability.
#pragma once

#include "implicit_step.hpp"

namespace ductile::membrane {

/// Linearises the step equation where the extrapolated force leads and solves that once (PETSc's
/// KSP, options prefix "membrane_"), so that
///
///     F = F_0 - (1 + K B)^-1 [F_0 + dE/dx(x_0)],     x_0 = x^n + u + B F_0,
///
/// F_0 being the extrapolated force. The tangent K is kept over solves (-membrane_tangent_lag): it
/// only serves the correction, the force balance at x_0 is exact. Solved means that the linear
/// system has a residual of at most ksp_rtol |F|; what the linearisation leaves is not looked at,
/// which is what the scheme saves. First order.
class SemiImplicit final : public ImplicitStep {
 public:
  // La = 10^5 at 36 nodes across, and times of steps (doc/integrators.md).
  static SchemeTraits traits() { return {.reach = 100, .cost = 12}; }

  SemiImplicit(const Shell& shell, Vec mobility, const IntegratorOptions& options);

 private:
  void solve(Vec unknown) override;

  KspPtr ksp_;
  VecPtr residual_, correction_;
  double rtol_ = 0;  // -membrane_ksp_rtol
  double floor_;
};

}  // namespace ductile::membrane
