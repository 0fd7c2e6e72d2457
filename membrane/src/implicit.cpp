#include "implicit.hpp"

#include <cmath>
#include <limits>
#include <string>

namespace ductile::membrane {
namespace {

// Newton iterations beyond which a kept tangent no longer pays.
constexpr PetscInt many_iterations = 3;
// What a linear solve may leave, over the residual that the step may leave.
constexpr double linear_share = 0.3;

}  // namespace

Implicit::Implicit(const Shell& shell, Vec mobility, const IntegratorOptions& options)
    : ImplicitStep(shell, mobility, options),
      residual_(shell.create_vec()),
      guess_(shell.create_vec()) {
  SNES snes = nullptr;
  petsc_check(SNESCreate(PETSC_COMM_SELF, &snes));
  snes_.reset(snes);
  petsc_check(SNESSetOptionsPrefix(snes, "membrane_"));
  petsc_check(SNESSetFunction(snes, residual_.get(), function, this));
  petsc_check(SNESSetJacobian(snes, equation().operator_matrix(),
                              equation().preconditioning_matrix(), jacobian, this));
  petsc_check(SNESSetConvergenceTest(snes, converged, this, nullptr));
  petsc_check(SNESSetTolerances(snes, round_off(shell), 1e-3, 0, 25, PETSC_DEFAULT));
  KSP ksp = nullptr;
  petsc_check(SNESGetKSP(snes, &ksp));
  set_up(ksp);
  petsc_check(SNESSetFromOptions(snes));
  PetscReal rtol = 0, ksp_rtol = 0;
  petsc_check(SNESGetTolerances(snes, nullptr, &rtol, nullptr, nullptr, nullptr));
  petsc_check(KSPGetTolerances(ksp, &ksp_rtol, nullptr, nullptr, nullptr));
  if (!(rtol >= 0 && rtol < 1) || !(ksp_rtol > 0 && ksp_rtol < 1)) {
    throw std::invalid_argument("integrator: -membrane_snes_rtol " + std::to_string(rtol) +
                                " must be at least 0 and -membrane_ksp_rtol " +
                                std::to_string(ksp_rtol) + " above 0, both below 1");
  }
}

PetscErrorCode Implicit::function(SNES /*snes*/, Vec y, Vec r, void* self) {
  StepEquation& equation = static_cast<Implicit*>(self)->equation();
  return equation.guarded([&] { equation.residual(y, r); });
}

PetscErrorCode Implicit::jacobian(SNES /*snes*/, Vec y, Mat /*matrix*/, Mat /*preconditioner*/,
                                  void* self) {
  auto& scheme = *static_cast<Implicit*>(self);
  if (!scheme.tangent_is_due() && !scheme.full_newton_) return 0;
  return scheme.equation().guarded([&] { scheme.linearise(y); });
}

PetscErrorCode Implicit::converged(SNES snes, PetscInt /*iteration*/, PetscReal /*y_norm*/,
                                   PetscReal /*step_norm*/, PetscReal residual,
                                   SNESConvergedReason* reason, void* self) {
  auto& scheme = *static_cast<Implicit*>(self);
  scheme.left_ = residual;
  return scheme.equation().guarded([&] {
    PetscReal rtol = 0, atol = 0, ksp_rtol = 0;
    PetscInt ksp_limit = 0;
    Vec y = nullptr;
    KSP ksp = nullptr;
    petsc_check(SNESGetTolerances(snes, &atol, &rtol, nullptr, nullptr, nullptr));
    petsc_check(SNESGetSolution(snes, &y));
    scheme.target_ = rtol * scheme.force_norm(y) + atol;
    // The linear solve that comes next need not go further than the step does.
    petsc_check(SNESGetKSP(snes, &ksp));
    petsc_check(KSPGetTolerances(ksp, &ksp_rtol, nullptr, nullptr, &ksp_limit));
    petsc_check(
        KSPSetTolerances(ksp, ksp_rtol, linear_share * scheme.target_, PETSC_DEFAULT, ksp_limit));
    *reason = SNES_CONVERGED_ITERATING;
    if (!std::isfinite(residual)) {
      *reason = SNES_DIVERGED_FNORM_NAN;
    } else if (residual <= scheme.target_) {
      *reason = SNES_CONVERGED_FNORM_RELATIVE;
    }
  });
}

SNESConvergedReason Implicit::newton(Vec unknown) {
  left_ = target_ = std::numeric_limits<double>::quiet_NaN();
  const PetscErrorCode code = SNESSolve(snes_.get(), nullptr, unknown);
  equation().rethrow();
  petsc_check(code);
  PetscInt newton = 0, krylov = 0;
  petsc_check(SNESGetIterationNumber(snes_.get(), &newton));
  petsc_check(SNESGetLinearSolveIterations(snes_.get(), &krylov));
  count().newton_iterations += newton;
  count().krylov_iterations += krylov;
  if (newton > many_iterations) renew_tangent();
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  petsc_check(SNESGetConvergedReason(snes_.get(), &reason));
  return reason;
}

// The force balance decides, whatever the chosen solver says of itself.
bool Implicit::solved(Vec unknown, SNESConvergedReason reason) {
  if (reason < 0) return false;
  if (left_ <= target_) return true;
  PetscReal rtol = 0, atol = 0;
  petsc_check(SNESGetTolerances(snes_.get(), &atol, &rtol, nullptr, nullptr, nullptr));
  equation().residual(unknown, residual_.get());
  petsc_check(VecNorm(residual_.get(), NORM_2, &left_));
  target_ = rtol * force_norm(unknown) + atol;
  return left_ <= target_;
}

void Implicit::solve(Vec unknown) {
  petsc_check(VecCopy(unknown, guess_.get()));
  full_newton_ = false;
  SNESConvergedReason reason = newton(unknown);
  if (solved(unknown, reason)) return;
  full_newton_ = true;
  petsc_check(VecCopy(guess_.get(), unknown));
  reason = newton(unknown);
  if (solved(unknown, reason)) return;
  PetscInt newton = 0, krylov = 0;
  petsc_check(SNESGetIterationNumber(snes_.get(), &newton));
  petsc_check(SNESGetLinearSolveIterations(snes_.get(), &krylov));
  throw SolveFailure(reason < 0 ? SNESConvergedReasons[reason] : "the solver stopped too early",
                     newton, krylov, left_, target_);
}

}  // namespace ductile::membrane
