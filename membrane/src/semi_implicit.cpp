#include "semi_implicit.hpp"

#include <algorithm>
#include <cmath>
#include <string>

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
  // The linear residual is all that tells whether a step was solved: it must be the true one.
  PCSide side = PC_RIGHT;
  PetscBool unchecked = PETSC_FALSE;
  petsc_check(KSPGetPCSide(ksp, &side));
  petsc_check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &unchecked));
  if (side != PC_RIGHT || unchecked == PETSC_TRUE) {
    throw std::invalid_argument(
        "integrator: semi-implicit needs a -membrane_ksp_type that iterates, with "
        "-membrane_ksp_pc_side right, such as gmres or bcgs");
  }
  if (!(rtol_ > 0 && rtol_ < 1)) {
    throw std::invalid_argument("integrator: -membrane_ksp_rtol " + std::to_string(rtol_) +
                                " must be above 0 and below 1: what the linear solve may leave of "
                                "the force");
  }
}

void SemiImplicit::solve(Vec unknown) {
  equation().residual(unknown, residual_.get());
  PetscReal norm = 0;
  petsc_check(VecNorm(residual_.get(), NORM_2, &norm));
  if (!std::isfinite(norm)) throw SolveFailure("the force is not finite", 0, 0, norm, 0);

  // The residual is relative to the force; there is none before the first step.
  const double force = force_norm(unknown);
  const double target = std::max(rtol_ * (force > 0 ? force : norm), floor_);
  if (norm <= target) return;
  if (tangent_is_due()) linearise(unknown);
  petsc_check(KSPSetTolerances(ksp_.get(), 0, target, PETSC_DEFAULT, PETSC_DEFAULT));
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
