// How a shell moves in time, apart from what its force is: one file a scheme.
//
// In each step, from t to t + 1 (lattice units), the fluid and the shell's scheme talk as follows;
// u is the fluid's velocity at the vertices, F their force on the fluid:
//
//   1.  F  = predict_force()                  what follows from the state at t
//   2.  corrections() times:
//           u  = the fluid's, with all force so far
//           F += correct_force(u)             the scheme may ask how u would answer to more force
//   3.  u  = the fluid's, with the whole force
//       v  = advance(u)                       x^(n+1) = x^n + v
//
// A vertex moves with the fluid and slips through it under its own force: v = u + eps F, eps being
// the vertex's mobility. That slip relaxes strain on the scale of a lattice spacing, which the
// interpolation between lattice and vertices hides from the fluid; eps = 0 is the pure immersed
// boundary method.
#pragma once

#include <petscvec.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "ductile/membrane/petsc.hpp"
#include "ductile/membrane/shell.hpp"

namespace ductile::membrane {

/// A shell's state between two steps; each 3n numbers, interlaced, block size 3, lattice units.
struct State {
  VecPtr positions;   ///< x^n
  VecPtr velocities;  ///< v of the vertices in the latest step, x^n - x^(n-1)
  VecPtr forces;      ///< F on the fluid as far as known
};

/// The fluid's instantaneous answer to more force at the vertices, these fixed at x^n: velocity <-
/// R force, linear, symmetric and positive semi-definite; both 3n.
using Response = std::function<void(std::span<const double> force, std::span<double> velocity)>;

/// Takes a part of an object's state: its name, unique within the object, and its numbers. Counts
/// and flags come as numbers too.
using StateWriter = std::function<void(std::string_view name, std::span<const double> numbers)>;
/// Fills in what a StateWriter took under that name, of the same size.
using StateReader = std::function<void(std::string_view name, std::span<double> numbers)>;

/// What a scheme has spent since it was made; zeros in a scheme that solves nothing.
struct SolveStatistics {
  std::int64_t solves = 0;             ///< systems of equations solved, one a substep
  std::int64_t newton_iterations = 0;  ///< in all of them
  std::int64_t krylov_iterations = 0;  ///< in all Newton iterations
  std::int64_t tangents = 0;           ///< assemblies of the tangent
  std::int64_t step_cuts = 0;          ///< steps repeated with more substeps
};

/// What the schemes may be told; each takes what it needs.
struct IntegratorOptions {
  /// Implicit schemes: how much of its own force's effect a vertex feels within the step. 1/2 is
  /// what the fluid really answers (no slip, and the trapezoidal rule's stability); up to 1 damps
  /// more, at the price of a slip of (2 theta - 1) R F.
  double theta = 0.5;
  int substeps = 1;   ///< implicit: into how many the time step is divided
  int step_cuts = 0;  ///< implicit: how often a step that fails is tried again with twice as many
};

/// A system of equations was not solved: positions and velocities are those before the step.
class SolveFailure : public std::runtime_error {
 public:
  /// `reason` is PETSc's; `residual` the largest norm over all forces that is left, and `target`
  /// what it should have come to, lattice units.
  SolveFailure(const std::string& reason, int newton_iterations, int krylov_iterations,
               double residual, double target);
  [[nodiscard]] const std::string& reason() const { return reason_; }
  [[nodiscard]] int newton_iterations() const { return newton_iterations_; }
  [[nodiscard]] int krylov_iterations() const { return krylov_iterations_; }
  [[nodiscard]] double residual() const { return residual_; }

 private:
  std::string reason_;
  int newton_iterations_;
  int krylov_iterations_;
  double residual_;
};

/// A scheme for one shell. It leaves the state as it finds it: its results are its last arguments.
class Integrator {
 public:
  Integrator() = default;
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;
  virtual ~Integrator() = default;

  /// How many fluid velocities the scheme needs before its force is final; constant.
  [[nodiscard]] virtual int corrections() const { return 0; }
  /// force <- what the shell exerts on the fluid as far as it follows from the state at t.
  virtual void predict_force(const State& state, Vec force) = 0;
  /// increment <- what to add to state.forces, given the fluid's velocity with those in. Throws
  /// std::logic_error in a scheme without corrections.
  virtual void correct_force(const State& state, Vec fluid_velocity, const Response& response,
                             Vec increment);
  /// velocity <- v, given the fluid's with the whole force in.
  virtual void advance(const State& state, Vec fluid_velocity, Vec velocity) = 0;
  /// The step is taken: what advance() gave is the state's now. A step that failed has no such
  /// call: what the scheme remembers of past steps must then be as it was before it. What a solver
  /// keeps to go faster, as a tangent, may be another, within its tolerance.
  virtual void accept() {}

  [[nodiscard]] virtual SolveStatistics statistics() const { return {}; }

  /// Writes all that the scheme remembers of past steps, and what statistics() tells; between two
  /// steps. A scheme that remembers nothing overrides neither this nor load().
  virtual void save(const StateWriter& /*write*/) const {}
  /// Takes over what save() of a scheme for the same shell, mobility and options wrote, and goes on
  /// to the last bit as that one would have; for a scheme newly made. (PETSc options by which a
  /// solver keeps more than its matrices from one solve to the next, such as ksp_guess_type, spoil
  /// the last bits.) Passes on what `read` throws; the scheme is then of no use.
  virtual void load(const StateReader& /*read*/) {}
};

/// Makes a scheme for a shell and its mobility eps, 3n numbers; both must outlive the scheme.
using IntegratorFactory =
    std::function<std::unique_ptr<Integrator>(const Shell& shell, Vec mobility)>;

/// What one needs to know of a scheme to choose it.
struct SchemeTraits {
  /// The weights, latest first, of a scheme whose force is -dE/dx(x^n) and whose vertices move by a
  /// weighted sum of u + eps F of this step and of earlier ones. Its limit of stability follows
  /// from them (doc/stability.md). Empty for any other scheme.
  std::vector<double> weights = {};
  /// The multiple of explicit Euler's limit up to which the moduli may be, for a scheme without
  /// weights; infinity where there is no limit.
  double reach = 0;
  /// Time that a step's membrane work takes, over explicit Euler's.
  double cost = 1;
};

/// A scheme by name.
struct Scheme {
  using Factory = std::unique_ptr<Integrator> (*)(const Shell& shell, Vec mobility,
                                                  const IntegratorOptions& options);
  std::string_view name;
  SchemeTraits traits;
  Factory make;
};

/// The scheme of the class T, derived from Integrator: T has a static function traits(), and is
/// made from a shell, its mobility and, if it takes them, the options. `name` must outlive it.
template <class T>
Scheme scheme(std::string_view name) {
  return {name, T::traits(),
          [](const Shell& shell, Vec mobility,
             [[maybe_unused]] const IntegratorOptions& options) -> std::unique_ptr<Integrator> {
            if constexpr (std::is_constructible_v<T, const Shell&, Vec, const IntegratorOptions&>) {
              return std::make_unique<T>(shell, mobility, options);
            } else {
              return std::make_unique<T>(shell, mobility);
            }
          }};
}

/// The schemes there are.
std::span<const Scheme> schemes();
/// Explicit Euler, the paper's: the limit and the cost of others are counted in its own.
const Scheme& reference_scheme();
/// Their names.
std::vector<std::string_view> integrator_names();
/// That of schemes() with this name. Throws std::invalid_argument, listing them, for any other.
const Scheme& find_scheme(std::string_view name);

/// The factory of a scheme with these options. Throws std::invalid_argument if they are out of
/// bounds.
IntegratorFactory make_integrator(const Scheme& scheme, const IntegratorOptions& options = {});
/// Alike, for find_scheme(name).
IntegratorFactory make_integrator(std::string_view name, const IntegratorOptions& options = {});

}  // namespace ductile::membrane
