#include "ductile/membrane/equilibrium.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>

#include "shell_math.hpp"

namespace ductile::membrane {
namespace {

using Eigen::Vector3d;

VecPtr duplicate(Vec vec) {
  Vec result = nullptr;
  petsc_check(VecDuplicate(vec, &result));
  return VecPtr(result);
}
double norm(Vec vec) {
  double result = 0;
  petsc_check(VecNorm(vec, NORM_2, &result));
  return result;
}
double dot(Vec a, Vec b) {
  double result = 0;
  petsc_check(VecDot(a, b, &result));
  return result;
}

// |x - mean x|; over n, the least residual that round-off lets one see is eps times the stiffness
// of such a length.
double spread(Vec positions) {
  const VecArray<const double> x(positions);
  const auto points = Eigen::Matrix3Xd::Map(x.data(), 3, static_cast<Eigen::Index>(x.size() / 3));
  return (points.colwise() - points.rowwise().mean()).norm();
}

std::string in_words(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", number);
  return text;
}

void validate(const EquilibriumOptions& options) {
  if (!(options.tolerance > 0)) {
    throw std::invalid_argument("equilibrium: tolerance = " + in_words(options.tolerance) +
                                " must be positive");
  }
  if (options.max_steps < 1) {
    throw std::invalid_argument("equilibrium: max_steps = " + std::to_string(options.max_steps) +
                                " must be at least 1");
  }
}

void validate_balance(Vec force, Vec positions, int vertex_count) {
  const auto f = array_of<const double>(force, vertex_count);
  const auto x = array_of<const double>(positions, vertex_count);
  Vector3d total = Vector3d::Zero(), torque = Vector3d::Zero();
  double force_scale = 0, torque_scale = 0;
  for (int i = 0; i < vertex_count; ++i) {
    const Vector3d part = point(f.data(), i), arm = point(x.data(), i);
    total += part;
    torque += arm.cross(part);
    force_scale += part.norm();
    torque_scale += arm.norm() * part.norm();
  }
  const auto refuse = [](const char* what, double sum, double scale) {
    throw std::invalid_argument(std::string("equilibrium: the forces are not balanced: their ") +
                                what + " is " + in_words(sum) + " in total, against " +
                                in_words(scale) + " of all parts: it must be below 1e-9 of that");
  };
  if (!(total.norm() <= 1e-9 * force_scale)) refuse("sum", total.norm(), force_scale);
  if (!(torque.norm() <= 1e-9 * torque_scale)) refuse("torque", torque.norm(), torque_scale);
}

// E(x) - f.x + (drag/2) |x - origin|^2 and its derivatives.
class Potential {
 public:
  Potential(const Shell& shell, Vec force, Vec start)
      : shell_(shell), force_(force), origin_(duplicate(start)), tangent_(shell.create_tangent()) {
    petsc_check(VecCopy(start, origin_.get()));
    if (shell.moduli().k_v == 0) return;
    // tangent + g c g^T.
    volume_gradient_ = shell.create_vec();
    double* column = nullptr;
    petsc_check(VecGetArray(volume_gradient_.get(), &column));
    Mat mat = nullptr;
    const PetscInt n = 3 * shell.vertex_count();
    petsc_check(MatCreateSeqDense(PETSC_COMM_SELF, n, 1, column, &mat));
    petsc_check(VecRestoreArray(volume_gradient_.get(), &column));
    volume_column_.reset(mat);
    Vec vec = nullptr;
    petsc_check(VecCreateSeq(PETSC_COMM_SELF, 1, &vec));
    volume_stiffness_.reset(vec);
    petsc_check(VecSet(vec, shell.moduli().k_v / shell.reference_volume()));
    petsc_check(MatCreateLRC(tangent_.get(), volume_column_.get(), vec, nullptr, &mat));
    whole_.reset(mat);
  }

  double drag = 0;
  [[nodiscard]] Vec origin() const { return origin_.get(); }
  [[nodiscard]] Mat whole() const { return whole_ ? whole_.get() : tangent_.get(); }
  [[nodiscard]] Mat sparse() const { return tangent_.get(); }
  /// g, or null if c = 0.
  [[nodiscard]] Vec volume_gradient() const { return volume_gradient_.get(); }
  /// c
  [[nodiscard]] double volume_stiffness() const {
    return shell_.moduli().k_v / shell_.reference_volume();
  }

  /// Without the drag's part.
  [[nodiscard]] double energy(Vec x) const { return shell_.energies(x).total() - dot(force_, x); }

  void gradient(Vec x, Vec result) const {
    shell_.force(x, result);
    petsc_check(VecAXPBY(result, -1, -1, force_));
    petsc_check(VecAXPBYPCZ(result, drag, -drag, 1, x, origin_.get()));
  }

  /// Root mean square of the sparse part's eigenvalues, without drag.
  [[nodiscard]] double stiffness(Vec x) const {
    shell_.tangent(x, tangent_.get());
    double result = 0;
    petsc_check(MatNorm(tangent_.get(), NORM_FROBENIUS, &result));
    result /= std::sqrt(3 * shell_.vertex_count());
    if (!std::isfinite(result)) {
      throw std::invalid_argument("equilibrium: a triangle has collapsed at the start");
    }
    if (result == 0) {
      throw std::invalid_argument(
          "equilibrium: the shell resists no deformation: k_s, k_a or k_b "
          "must be positive");
    }
    return result;
  }

  void hessian(Vec x) {
    shell_.tangent(x, tangent_.get());
    petsc_check(MatShift(tangent_.get(), drag));
    if (!whole_) return;
    shell_.volume_stiffness(x, volume_gradient_.get());
    petsc_check(MatAssemblyBegin(whole_.get(), MAT_FINAL_ASSEMBLY));
    petsc_check(MatAssemblyEnd(whole_.get(), MAT_FINAL_ASSEMBLY));
  }

 private:
  const Shell& shell_;
  Vec force_;
  VecPtr origin_;
  MatPtr tangent_;
  // What c g g^T is made of; the column is the gradient's own numbers. All null if k_v = 0.
  VecPtr volume_gradient_, volume_stiffness_;
  MatPtr volume_column_, whole_;
};

// No exception may leave through PETSc.
template <class Action>
PetscErrorCode guarded(Action&& action) {
  try {
    action();
  } catch (const PetscFailure& failure) {
    return failure.code();
  } catch (const std::exception& error) {
    return PetscError(PETSC_COMM_SELF, __LINE__, __func__, __FILE__, PETSC_ERR_LIB,
                      PETSC_ERROR_INITIAL, "%s", error.what());
  }
  return 0;
}
PetscErrorCode gradient(SNES /*snes*/, Vec x, Vec result, void* potential) {
  return guarded([&] { static_cast<const Potential*>(potential)->gradient(x, result); });
}
PetscErrorCode hessian(SNES /*snes*/, Vec x, Mat /*whole*/, Mat /*sparse*/, void* potential) {
  return guarded([&] { static_cast<Potential*>(potential)->hessian(x); });
}

SnesPtr make_solver(Potential& potential, Vec work, double target) {
  SNES snes = nullptr;
  petsc_check(SNESCreate(PETSC_COMM_SELF, &snes));
  SnesPtr owner(snes);
  petsc_check(SNESSetOptionsPrefix(snes, "membrane_static_"));
  petsc_check(SNESSetFunction(snes, work, &gradient, &potential));
  petsc_check(SNESSetJacobian(snes, potential.whole(), potential.sparse(), &hessian, &potential));
  petsc_check(SNESSetTolerances(snes, target / 2, 1e-3, 0, 20, -1));
  KSP ksp = nullptr;
  petsc_check(SNESGetKSP(snes, &ksp));
  petsc_check(KSPSetTolerances(ksp, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, 50));
  PC pc = nullptr;
  petsc_check(KSPGetPC(ksp, &pc));
  petsc_check(PCSetType(pc, PCLU));
  petsc_check(SNESSetFromOptions(snes));
  return owner;
}

// The number of negative eigenvalues of H = P + c g g^T. It is that of P, less one if
// 1/c + g^T P^-1 g is negative (Haynsworth); that of P is that of its factors' diagonal
// (Sylvester).
int unstable_modes(Potential& potential, Vec x) {
  potential.hessian(x);
  Mat mat = nullptr;
  // PETSc counts in factors of MATSEQAIJ.
  petsc_check(MatConvert(potential.sparse(), MATSEQAIJ, MAT_INITIAL_MATRIX, &mat));
  const MatPtr scalar(mat);
  petsc_check(MatSetOption(mat, MAT_SYMMETRIC, PETSC_TRUE));
  KSP ksp = nullptr;
  petsc_check(KSPCreate(PETSC_COMM_SELF, &ksp));
  const KspPtr owner(ksp);
  petsc_check(KSPSetOptionsPrefix(ksp, "membrane_static_inertia_"));
  petsc_check(KSPSetType(ksp, KSPPREONLY));
  petsc_check(KSPSetOperators(ksp, mat, mat));
  PC pc = nullptr;
  petsc_check(KSPGetPC(ksp, &pc));
  petsc_check(PCSetType(pc, PCCHOLESKY));
  petsc_check(KSPSetFromOptions(ksp));
  petsc_check(KSPSetUp(ksp));
  petsc_check(PCFactorGetMatrix(pc, &mat));
  PetscInt negative = 0, zero = 0, positive = 0;
  petsc_check(MatGetInertia(mat, &negative, &zero, &positive));
  if (Vec g = potential.volume_gradient()) {
    const VecPtr solution = duplicate(x);
    petsc_check(KSPSolve(ksp, g, solution.get()));
    if (1 / potential.volume_stiffness() + dot(g, solution.get()) < 0) --negative;
  }
  return static_cast<int>(negative);
}

}  // namespace

EquilibriumFailure::EquilibriumFailure(Reason reason, SNESConvergedReason latest,
                                       int newton_iterations, double residual, double target)
    : std::runtime_error(
          "equilibrium: not found after " + std::to_string(newton_iterations) +
          " Newton iterations: " +
          (reason == Reason::max_steps ? "max_steps used up" : "no step lowers the energy") +
          "; residual force " + in_words(residual) + ", asked for " + in_words(target) +
          "; the latest solve ended with " + SNESConvergedReasons[latest]),
      reason_(reason),
      latest_(latest),
      newton_iterations_(newton_iterations),
      residual_(residual) {}

Equilibrium find_equilibrium(const Shell& shell, Vec force, Vec positions,
                             const EquilibriumOptions& options) {
  validate(options);
  validate_balance(force, positions, shell.vertex_count());

  Potential potential(shell, force, positions);
  const VecPtr gradient = duplicate(positions), next = duplicate(positions);
  const auto residual_at = [&](Vec x) {
    potential.drag = 0;
    potential.gradient(x, gradient.get());
    return norm(gradient.get());
  };
  Equilibrium result;
  result.residual = residual_at(positions);

  // Drags, as parts of the matrix's typical eigenvalue.
  const double stiffness = potential.stiffness(positions);
  const double first = 1e-2 * stiffness, least = 1e-8 * stiffness, most = 1e4 * stiffness;
  const double target = std::max(options.tolerance * std::max(norm(force), result.residual),
                                 1e-14 * stiffness * spread(positions));
  const auto snes = make_solver(potential, gradient.get(), target);

  double energy = potential.energy(positions), drag = first;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  while (result.residual > target) {
    const auto fail = [&](EquilibriumFailure::Reason why) {
      throw EquilibriumFailure(why, reason, result.newton_iterations, result.residual, target);
    };
    if (result.steps == options.max_steps) fail(EquilibriumFailure::Reason::max_steps);
    if (drag > most) fail(EquilibriumFailure::Reason::no_descent);

    potential.drag = drag;
    petsc_check(VecCopy(positions, potential.origin()));
    petsc_check(VecCopy(positions, next.get()));
    petsc_check(SNESSolve(snes.get(), nullptr, next.get()));
    PetscInt iterations = 0;
    petsc_check(SNESGetIterationNumber(snes.get(), &iterations));
    petsc_check(SNESGetConvergedReason(snes.get(), &reason));
    ++result.steps;
    result.newton_iterations += static_cast<int>(iterations);

    const double next_energy = potential.energy(next.get());
    const double round_off = 1e-13 * (std::abs(energy) + norm(force) * norm(next.get()));
    if (reason > 0 && next_energy <= energy + round_off) {
      petsc_check(VecCopy(next.get(), positions));
      energy = next_energy;
      result.residual = residual_at(positions);
      drag = std::max(least, drag * (iterations <= 4 ? .03 : .2));
    } else {
      drag *= 10;
    }
  }
  potential.drag = least;
  result.unstable_modes = unstable_modes(potential, positions);
  return result;
}

}  // namespace ductile::membrane
