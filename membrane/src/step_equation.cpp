#include "step_equation.hpp"

#include <utility>

#include "state.hpp"

namespace ductile::membrane {

StepEquation::StepEquation(const Shell& shell, Vec mobility, double theta)
    : shell_(shell),
      mobility_(mobility),
      theta_(theta),
      scale_(shell.create_vec()),
      linearised_at_(shell.create_vec()),
      preconditioner_(shell.create_tangent()),
      volume_gradient_(shell.create_vec()),
      force_(shell.create_vec()),
      displaced_(shell.create_vec()),
      work_(shell.create_vec()) {
  const PetscInt n = 3 * shell.vertex_count();
  Mat matrix = nullptr;
  petsc_check(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, this, &matrix));
  operator_.reset(matrix);
  // The cast to a function of no arguments is how PETSc takes operations.
  petsc_check(MatShellSetOperation(matrix, MATOP_MULT, reinterpret_cast<void (*)()>(multiply)));
}

void StepEquation::begin(Vec start, Vec drift, const Response& response, double h) {
  start_ = start;
  drift_ = drift;
  response_ = &response;
  h_ = h;
}

void StepEquation::lump() {
  petsc_check(VecSet(force_.get(), 1));
  apply_b(force_.get(), scale_.get());
  // Each axis answers alike, but for a mirror plane, across which equal forces along y cancel.
  const VecArray<double> rows(scale_.get());
  for (std::size_t n = 0; n < rows.size(); n += 3) rows[n + 1] = rows[n];
  petsc_check(VecReciprocal(scale_.get()));
}

void StepEquation::to_force(Vec y, Vec force) const {
  petsc_check(VecPointwiseMult(force, scale_.get(), y));
}

void StepEquation::to_unknown(Vec force, Vec y) const {
  petsc_check(VecPointwiseDivide(y, force, scale_.get()));
}

void StepEquation::respond(Vec force, Vec velocity) const {
  const VecArray<const double> f(force);
  const VecArray<double> v(velocity);
  (*response_)(f.span(), v.span());
}

void StepEquation::apply_b(Vec force, Vec product) const {
  respond(force, product);
  petsc_check(VecPointwiseMult(work_.get(), mobility_, force));
  petsc_check(VecAXPBY(product, h_, 2 * theta_ * h_, work_.get()));
}

void StepEquation::positions(Vec force, Vec positions) const {
  apply_b(force, positions);
  petsc_check(VecAXPBYPCZ(positions, 1, h_, 1, start_, drift_));
}

void StepEquation::residual(Vec y, Vec r) const {
  to_force(y, force_.get());
  positions(force_.get(), displaced_.get());
  shell_.force(displaced_.get(), r);
  petsc_check(VecAYPX(r, -1, force_.get()));
}

void StepEquation::linearise(Vec y) {
  to_force(y, force_.get());
  positions(force_.get(), linearised_at_.get());
  assemble();
}

void StepEquation::assemble() {
  shell_.tangent(linearised_at_.get(), preconditioner_.get());
  volume_stiffness_ = shell_.volume_stiffness(linearised_at_.get(), volume_gradient_.get());
  petsc_check(MatDiagonalSet(preconditioner_.get(), scale_.get(), ADD_VALUES));
  petsc_check(MatAssemblyBegin(operator_.get(), MAT_FINAL_ASSEMBLY));
  petsc_check(MatAssemblyEnd(operator_.get(), MAT_FINAL_ASSEMBLY));
}

template <class Self, class Io>
void StepEquation::transfer_parts(Self& self, const Io& io) {
  transfer(io, "scale", self.scale_);
  transfer(io, "linearised_at", self.linearised_at_);
}
void StepEquation::save(const StateWriter& write) const {
  transfer_parts(*this, write);
}
void StepEquation::load(const StateReader& read) {
  transfer_parts(*this, read);
}

// (D + K B D) y, K being the preconditioning matrix less D, plus c g g^T.
void StepEquation::apply_jacobian(Vec y, Vec product) const {
  to_force(y, force_.get());
  apply_b(force_.get(), displaced_.get());
  petsc_check(MatMult(preconditioner_.get(), displaced_.get(), product));
  petsc_check(VecPointwiseMult(work_.get(), scale_.get(), displaced_.get()));
  petsc_check(VecAXPBYPCZ(product, 1, -1, 1, force_.get(), work_.get()));
  if (volume_stiffness_ > 0) {
    PetscScalar change = 0;
    petsc_check(VecDot(displaced_.get(), volume_gradient_.get(), &change));
    petsc_check(VecAXPY(product, volume_stiffness_ * change, volume_gradient_.get()));
  }
}

PetscErrorCode StepEquation::multiply(Mat matrix, Vec y, Vec product) {
  void* context = nullptr;
  if (const PetscErrorCode code = MatShellGetContext(matrix, &context)) return code;
  auto& self = *static_cast<StepEquation*>(context);
  return self.guarded([&] { self.apply_jacobian(y, product); });
}

void StepEquation::rethrow() {
  if (exception_) std::rethrow_exception(std::exchange(exception_, nullptr));
}

}  // namespace ductile::membrane
