// The equation of an implicit step of a membrane without mass, and its linearisation.
#pragma once

#include <exception>

#include "ductile/membrane/integrator.hpp"

namespace ductile::membrane {

/// A membrane without mass moves with the fluid, and the fluid answers its force within the step.
/// With the displacement of a step of length h (a fraction of the time step)
///
///     d = h [u + (2 theta R + eps) F] = h u + B F,
///
/// u the fluid's velocity without F and R its response (S S^T/(2 rho)), backward Euler asks for the
/// force that belongs to the positions it leads to:
///
///     r(F) = F + dE/dx(x + h u + B F) = 0,        r'(F) = 1 + K B.
///
/// B is symmetric and positive definite (semidefinite where eps = 0), so this is the minimum of
/// E(x + d) + (d - h u) . B^-1 (d - h u)/2.
///
/// The unknown that PETSc sees is y = b F, b the row sums of B along x: nearly the displacement
/// that smooth forces cause, in lattice spacings. With D = 1/b
///
///     dr/dy = D + K B D        the operator, which applies R
///             D + K            its preconditioning matrix, sparse: B lumped, and no rank one
///
/// K = K_sparse + c g g^T, the second part the volume's.
class StepEquation {
 public:
  /// `shell` and `mobility` must outlive it.
  StepEquation(const Shell& shell, Vec mobility, double theta);
  StepEquation(const StepEquation&) = delete;
  StepEquation& operator=(const StepEquation&) = delete;

  /// The step to solve, from `start`; all three must live until it is solved.
  void begin(Vec start, Vec drift, const Response& response, double h);
  /// The equation is meant to be linearised anew: takes the row sums of B, along y those along x.
  void lump();

  /// Turns y into F, and F into y.
  void to_force(Vec y, Vec force) const;
  void to_unknown(Vec force, Vec y) const;
  /// positions <- x + h u + B F; force and positions may not be the same.
  void positions(Vec force, Vec positions) const;
  /// r(F), for y.
  void residual(Vec y, Vec r) const;
  /// K at y, into operator and preconditioning matrix.
  void linearise(Vec y);

  /// Takes K where linearise() was called last, as it does itself; for an equation just loaded.
  void assemble();
  /// The row sums of B, and where it was linearised last.
  void save(const StateWriter& write) const;
  void load(const StateReader& read);

  [[nodiscard]] Mat operator_matrix() const { return operator_.get(); }
  [[nodiscard]] Mat preconditioning_matrix() const { return preconditioner_.get(); }
  /// velocity <- R force; the fluid's part alone.
  void respond(Vec force, Vec velocity) const;
  [[nodiscard]] double theta() const { return theta_; }

  /// Calls f and turns an exception into an error code for PETSc; rethrow() throws it again once
  /// PETSc has returned.
  template <class F>
  PetscErrorCode guarded(const F& f) {
    try {
      f();
      return 0;
    } catch (...) {
      exception_ = std::current_exception();
      return PETSC_ERR_LIB;
    }
  }
  /// Throws what a guarded call has caught, if any.
  void rethrow();

 private:
  template <class Self, class Io>
  static void transfer_parts(Self& self, const Io& io);
  // product <- B force.
  void apply_b(Vec force, Vec product) const;
  void apply_jacobian(Vec y, Vec product) const;
  static PetscErrorCode multiply(Mat matrix, Vec y, Vec product);

  const Shell& shell_;
  Vec mobility_;
  double theta_;

  Vec start_ = nullptr;
  Vec drift_ = nullptr;
  const Response* response_ = nullptr;
  double h_ = 1;

  VecPtr scale_;          // D
  VecPtr linearised_at_;  // positions
  MatPtr preconditioner_;
  MatPtr operator_;
  double volume_stiffness_ = 0;  // c
  VecPtr volume_gradient_;       // g

  mutable VecPtr force_, displaced_, work_;
  std::exception_ptr exception_;
};

}  // namespace ductile::membrane
