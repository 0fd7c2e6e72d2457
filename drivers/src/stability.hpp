// How near an explicit membrane integrator comes to its limit of stability, predicted from the
// linearised scheme. doc/stability.md has the theory, and how well it predicts.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstddef>
#include <string_view>
#include <vector>

#include "ductile/fluid/fluid.hpp"
#include "ductile/membrane/shell.hpp"
#include "scenario.hpp"
#include "units.hpp"

namespace ductile::drivers {

/// All that decides: a capsule at rest in a fluid at rest, in lattice units.
struct StabilityProblem {
  BodyShape shape = BodyShape::sphere;
  double radius = 0;
  int frequency = 0;  ///< of the mesh
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  membrane::Moduli moduli;
  double mobility = 0;  ///< in dx/eta
  double tau = 1;
  fluid::Collision collision = fluid::Collision::bgk;
  double magic = 3.0 / 16.0;
  bool operator==(const StabilityProblem& other) const;
};

/// The problem of capsule `body` of a scenario, one of Scenario::bodies.
StabilityProblem stability_problem(const Scenario& scenario, const LatticeSetup& setup,
                                   std::size_t body);

/// Moduli over those at which a scheme becomes unstable: stable below 1.
struct StabilityLoad {
  double total = 0;    ///< all moduli raised together
  double shear = 0;    ///< k_s and k_a alone
  double bending = 0;  ///< k_b alone
  double volume = 0;   ///< k_v alone
};

/// Whether a scheme is an explicit one, whose limit StabilityModel knows.
bool has_stability_limit(std::string_view integrator);

/// The linear stability of a capsule under any explicit scheme. The constructor measures what the
/// fluid's velocity at the membrane answers to forces there, which takes a few hundred time steps
/// of a box about the capsule: 0.1 s at a radius of 7 lattice spacings, 2 s at 20. Beyond 20 a
/// smaller capsule with the same edges stands in.
class StabilityModel {
 public:
  /// Needs MPI; not collective. Throws std::invalid_argument as membrane::Shell and fluid::Fluid.
  explicit StabilityModel(const StabilityProblem& problem);

  /// Throws std::invalid_argument unless has_stability_limit(integrator).
  [[nodiscard]] StabilityLoad load(std::string_view integrator) const;

  /// What fails first.
  struct Weakest {
    double load = 0;
    double frequency = 0;  ///< radians in a step; pi: it changes sign in every step
    int degree = -1;       ///< of the spherical harmonic; -1 for a pattern of the mesh's own
  };
  [[nodiscard]] Weakest weakest(std::string_view integrator) const;

 private:
  enum Part : std::size_t { shear, bending, volume, part_count };
  using Weights = std::array<double, part_count>;

  // Displacements of one degree on a sphere: L compresses the surface in itself, N is normal to
  // it, T shears it. Entries are LL, LN, NN, TT: the stiffness of each part, and the transform of
  // the fluid's answer at each of a row of frequencies.
  struct Harmonic {
    int degree = 0;
    std::array<std::array<double, 4>, part_count> stiffness{};
    std::array<std::vector<std::complex<double>>, 4> answer;
  };

  void measure_harmonics(const StabilityProblem& problem, int steps);
  void measure_breathing(const StabilityProblem& problem, int steps);
  [[nodiscard]] Weakest swinging(const Weights& weights, std::string_view integrator) const;

  double slip_ = 0;  // eps', the membrane's mobility times area
  std::vector<Harmonic> harmonics_;
  std::array<double, part_count> alternating_{};  // largest eigenvalue of K G(-1), by part
  double alternating_total_ = 0;
};

/// A scheme is relied on up to this load. The prediction is wrong by up to 8% (doc/stability.md),
/// and a membrane in a flow is strained and stiffer than at rest.
constexpr double sound_load = 0.8;

/// The cheapest of membrane::integrator_names() that is stable, or the one that bears most.
std::string_view advised_integrator(const StabilityModel& model);

}  // namespace ductile::drivers
