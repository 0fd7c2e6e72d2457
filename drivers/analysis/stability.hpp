// How near an explicit membrane integrator comes to its limit of stability, predicted from the
// linearised scheme. doc/stability.md has the theory, and how well it predicts.
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstddef>
#include <list>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "ductile/fluid/fluid.hpp"
#include "ductile/membrane/integrator.hpp"
#include "ductile/membrane/shell.hpp"
#include "ductile/suspension/plan.hpp"

namespace ductile::drivers {

/// All that decides: a capsule at rest in a fluid at rest, in lattice units.
struct StabilityProblem {
  std::string_view shape = "sphere";  ///< one of surface::shape_names()
  double radius = 0;
  double retraction = 0;  ///< of the membrane behind the surface
  int frequency = 0;      ///< of the mesh
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  membrane::Moduli moduli;
  double mobility = 0;  ///< in dx/eta
  double tau = 1;
  fluid::Collision collision = fluid::Collision::bgk;
  double magic = 3.0 / 16.0;
  bool operator==(const StabilityProblem& other) const;
};

/// The problem of capsule `body` of a plan.
StabilityProblem stability_problem(const suspension::Plan& plan, std::size_t body);

/// Moduli over those at which a scheme becomes unstable: stable below 1.
struct StabilityLoad {
  double total = 0;    ///< all moduli raised together
  double shear = 0;    ///< k_s and k_a alone
  double bending = 0;  ///< k_b alone
  double volume = 0;   ///< k_v alone
};

/// The linear stability of a capsule under any scheme whose vertices move by a weighted sum of
/// velocities (membrane::SchemeTraits::weights). The constructor measures what the
/// fluid's velocity at the membrane answers to forces there, which takes a few hundred time steps
/// of a box about the capsule: 0.1 s at a radius of 7 lattice spacings, 0.8 s at 20, more with a
/// low tau or a fine mesh (seconds_to_measure()). Beyond 20 a smaller capsule with the same edges
/// stands in.
class StabilityModel {
 public:
  /// Needs MPI; not collective. Throws std::invalid_argument as membrane::Shell and fluid::Fluid.
  explicit StabilityModel(const StabilityProblem& problem);

  /// `weights` are the scheme's. Throws std::invalid_argument if there are none. Kept, for the
  /// next to ask.
  [[nodiscard]] const StabilityLoad& load(std::span<const double> weights) const;

  /// What fails first.
  struct Weakest {
    double load = 0;
    double frequency = 0;  ///< radians in a step; pi: it changes sign in every step
    int degree = -1;       ///< of the spherical harmonic; -1 for a pattern of the mesh's own
  };
  [[nodiscard]] Weakest weakest(std::span<const double> weights) const;

 private:
  enum Part : std::size_t { shear, bending, volume, part_count };
  using Shares = std::array<double, part_count>;  // of each part of the moduli

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
  [[nodiscard]] Weakest swinging(const Shares& shares, std::span<const double> weights) const;
  [[nodiscard]] StabilityLoad find_load(std::span<const double> weights) const;

  double slip_ = 0;  // eps', the membrane's mobility times area
  std::vector<Harmonic> harmonics_;
  std::array<double, part_count> alternating_{};  // largest eigenvalue of K G(-1), by part
  double alternating_total_ = 0;
  mutable std::list<std::pair<std::vector<double>, StabilityLoad>> loads_;
};

/// About how long the constructor of its model takes on one core, within a factor of 2: from counts
/// of steps, nodes and vertices alone, so the same for the same problem everywhere.
double seconds_to_measure(const StabilityProblem& problem);

/// A scheme is relied on up to this load. The prediction is up to 3% too high and 20% too low
/// (doc/stability.md), and a membrane in a flow is strained and stiffer than at rest.
constexpr double sound_load = 0.8;

/// Whether a scheme is to be relied on: its load is sound, or, of one without weights, that of
/// explicit Euler is within its reach.
bool relied_on(const membrane::Scheme& scheme, const StabilityModel& model);

/// The cheapest of membrane::schemes() that is relied on, or the one that reaches furthest.
const membrane::Scheme& advised_scheme(const StabilityModel& model);

/// The models of a plan's capsules, each measured when it is first asked for; equal capsules share
/// one. The plan must outlive it.
class StabilityModels {
 public:
  /// Models are measured as long as their seconds_to_measure() add up to `seconds` at most.
  StabilityModels(const suspension::Plan& plan, double seconds) : plan_(plan), left_(seconds) {}
  /// That of capsule `body`; null where it would take longer than what is left.
  const StabilityModel* operator[](std::size_t body);

 private:
  const suspension::Plan& plan_;
  double left_;
  std::vector<std::pair<StabilityProblem, std::unique_ptr<StabilityModel>>> models_;
};

}  // namespace ductile::drivers
