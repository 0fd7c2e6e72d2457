#include "semi_implicit.hpp"

#include <algorithm>
#include <cmath>

namespace ductile::membrane {

SemiImplicit::SemiImplicit(const Shell& shell, Vec mobility, const IntegratorOptions& options)
    : ImplicitStep(shell, mobility, options),
      residual_(shell.create_vec()),
      correction_(shell.create_vec()),
      floor_(round_off(shell)) {
  KSP ksp = nullptr;
  petsc_check(KSPCreate(PETSC_COMM_SELF, &ksp));
  ksp_.reset(ksp);
  petsc_check(KSPSetOptionsPrefix(ksp, "membrane_"));
  petsc_check(
      KSPSetOperators(ksp, equation().operator_matrix(), equation().preconditioning_matrix()));
  set_up(ksp);
  petsc_check(KSPSetTolerances(ksp, 1e-3, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  petsc_check(KSPSetFromOptions(ksp));
  petsc_check(KSPGetTolerances(ksp, &rtol_, nullptr, nullptr, nullptr));
}

void SemiImplicit::solve(Vec unknown) {
  equation().residual(unknown, residual_.get());
  PetscReal norm = 0;
  petsc_check(VecNorm(residual_.get(), NORM_2, &norm));
  if (!std::isfinite(norm)) throw SolveFailure("the force is not finite", 0, 0, norm, 0);
  if (tangent_is_due()) linearise(unknown);

  // What is left is relative to the force, of which there is none before the first step.
  const double force = force_norm(unknown);
  const double target = force > 0 ? rtol_ * force : rtol_ * norm;
  petsc_check(
      KSPSetTolerances(ksp_.get(), 0, std::max(target, floor_), PETSC_DEFAULT, PETSC_DEFAULT));
  petsc_check(VecZeroEntries(correction_.get()));
  const PetscErrorCode code = KSPSolve(ksp_.get(), residual_.get(), correction_.get());
  equation().rethrow();
  petsc_check(code);
  PetscInt iterations = 0;
  petsc_check(KSPGetIterationNumber(ksp_.get(), &iterations));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  petsc_check(KSPGetConvergedReason(ksp_.get(), &reason));
  count().newton_iterations += 1;
  count().krylov_iterations += iterations;
  if (reason < 0) {
    petsc_check(KSPGetResidualNorm(ksp_.get(), &norm));
    throw SolveFailure(KSPConvergedReasons[reason], 1, iterations, norm, target);
  }
  petsc_check(VecAXPY(unknown, -1, correction_.get()));
}

}  // namespace ductile::membrane
