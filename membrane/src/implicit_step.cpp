#include "implicit_step.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "state.hpp"

namespace ductile::membrane {
namespace {

template <class... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

}  // namespace

SolveFailure::SolveFailure(const std::string& reason, int newton_iterations, int krylov_iterations,
                           double residual, double target)
    : std::runtime_error(
          text("the implicit step was not solved: ", reason, " after ", newton_iterations,
               " Newton and ", krylov_iterations, " Krylov iterations, force out of balance by ",
               residual, ", at most ", target, " wanted; more substeps or step_cuts may help")),
      reason_(reason),
      newton_iterations_(newton_iterations),
      krylov_iterations_(krylov_iterations),
      residual_(residual) {}

ImplicitStep::ImplicitStep(const Shell& shell, Vec mobility, const IntegratorOptions& options)
    : mobility_(mobility),
      equation_(shell, mobility, options.theta),
      substeps_(options.substeps),
      step_cuts_(options.step_cuts),
      last_(shell.create_vec()),
      before_(shell.create_vec()),
      drift_(shell.create_vec()),
      unknown_(shell.create_vec()),
      start_(shell.create_vec()),
      force_(shell.create_vec()),
      mean_(shell.create_vec()),
      slip_(shell.create_vec()) {
  petsc_check(PetscOptionsGetInt(nullptr, "membrane_", "-tangent_lag", &lag_, nullptr));
  if (lag_ < 1) {
    throw std::invalid_argument(text("integrator: -membrane_tangent_lag ", lag_,
                                     " must be at least 1, a new tangent for "
                                     "each step"));
  }
}

void ImplicitStep::set_up(KSP ksp) {
  PC pc = nullptr;
  petsc_check(KSPSetType(ksp, KSPGMRES));
  petsc_check(KSPGMRESSetRestart(ksp, 60));
  petsc_check(KSPSetPCSide(ksp, PC_RIGHT));  // residuals are then those of the force
  petsc_check(KSPSetTolerances(ksp, 1e-2, PETSC_DEFAULT, PETSC_DEFAULT, 1000));
  petsc_check(KSPGetPC(ksp, &pc));
  petsc_check(PCSetType(pc, PCNONE));
}

double ImplicitStep::round_off(const Shell& shell) {
  return 1e-11 * shell.moduli().k_s * std::sqrt(3.0 * shell.vertex_count());
}

double ImplicitStep::force_norm(Vec unknown) {
  equation_.to_force(unknown, force_.get());
  PetscReal norm = 0;
  petsc_check(VecNorm(force_.get(), NORM_2, &norm));
  return norm;
}

void ImplicitStep::linearise(Vec unknown) {
  equation_.linearise(unknown);
  stale_ = false;
  age_ = 0;
  ++statistics_.tangents;
}

void ImplicitStep::predict_force(const State& /*state*/, Vec force) {
  petsc_check(VecCopy(last_.get(), force));
  if (steps_ > 1) petsc_check(VecAXPBY(force, -1, 2, before_.get()));
}

void ImplicitStep::correct_force(const State& state, Vec fluid_velocity, const Response& response,
                                 Vec increment) {
  // The capsule's own force so far is taken out: the equation answers for it.
  equation_.begin(state.positions.get(), fluid_velocity, response, 1);
  equation_.respond(state.forces.get(), drift_.get());
  petsc_check(VecAYPX(drift_.get(), -1, fluid_velocity));

  int substeps = substeps_;
  for (int cuts = step_cuts_;; --cuts) {
    try {
      step(state, response, substeps);
      break;
    } catch (const SolveFailure&) {
      if (cuts <= 0) throw;
      ++statistics_.step_cuts;
      renew_tangent();
      substeps *= 2;
    }
  }
  if (equation_.theta() > 0.5) {
    equation_.respond(mean_.get(), slip_.get());
    petsc_check(VecScale(slip_.get(), 2 * equation_.theta() - 1));
  }
  petsc_check(VecWAXPY(increment, -1, state.forces.get(), mean_.get()));
}

// mean_ <- the force of the step, in so many substeps.
void ImplicitStep::step(const State& state, const Response& response, int substeps) {
  const double h = 1.0 / substeps;
  petsc_check(VecCopy(state.positions.get(), start_.get()));
  petsc_check(VecCopy(state.forces.get(), force_.get()));
  petsc_check(VecZeroEntries(mean_.get()));
  for (int n = 0; n < substeps; ++n) {
    equation_.begin(start_.get(), drift_.get(), response, h);
    if (age_ >= lag_ || substeps != substeps_) renew_tangent();
    if (stale_ || !lumped_) equation_.lump();
    lumped_ = true;
    equation_.to_unknown(force_.get(), unknown_.get());
    solve(unknown_.get());
    ++statistics_.solves;
    equation_.to_force(unknown_.get(), force_.get());
    petsc_check(VecAXPY(mean_.get(), h, force_.get()));
    if (n + 1 < substeps) {
      equation_.positions(force_.get(), slip_.get());
      petsc_check(VecCopy(slip_.get(), start_.get()));
    }
  }
}

void ImplicitStep::advance(const State& state, Vec fluid_velocity, Vec velocity) {
  petsc_check(VecPointwiseMult(velocity, mobility_, state.forces.get()));
  petsc_check(VecAXPY(velocity, 1, fluid_velocity));
  if (equation_.theta() > 0.5) petsc_check(VecAXPY(velocity, 1, slip_.get()));
}

void ImplicitStep::accept() {
  std::swap(last_, before_);
  petsc_check(VecCopy(mean_.get(), last_.get()));
  steps_ = std::min(steps_ + 1, 2);
  ++age_;
}

// All other vectors are written before they are read in each step, and the solvers start afresh
// in each solve.
template <class Self, class Io>
void ImplicitStep::transfer_parts(Self& self, const Io& io) {
  transfer(io, "last", self.last_);
  transfer(io, "before", self.before_);
  transfer(io, "steps", self.steps_);
  transfer(io, "lumped", self.lumped_);
  transfer(io, "stale", self.stale_);
  transfer(io, "age", self.age_);
  transfer(io, "solves", self.statistics_.solves);
  transfer(io, "newton_iterations", self.statistics_.newton_iterations);
  transfer(io, "krylov_iterations", self.statistics_.krylov_iterations);
  transfer(io, "tangents", self.statistics_.tangents);
  transfer(io, "step_cuts", self.statistics_.step_cuts);
}
void ImplicitStep::save(const StateWriter& write) const {
  transfer_parts(*this, write);
  equation_.save(write);
}
void ImplicitStep::load(const StateReader& read) {
  transfer_parts(*this, read);
  equation_.load(read);
  if (!stale_) equation_.assemble();
}

}  // namespace ductile::membrane
