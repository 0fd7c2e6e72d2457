// Runs of one scenario with several membrane integrators, side by side.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ductile/suspension/sample.hpp"
#include "output/summary.hpp"

namespace ductile::drivers {

/// A run with one of the integrators.
struct Contender {
  std::string integrator;
  Summary summary;  ///< with its profile
  std::vector<suspension::Sample> samples;
};

/// How far two trajectories are apart, as far as both go; lengths in W.
struct Difference {
  struct Body {
    double x = 0;  ///< largest |x - x'|
    double y = 0;
  };
  double until = 0;  ///< [W^2/nu]
  std::vector<Body> bodies;
  std::optional<double> dz;  ///< of a pair

  /// The largest of all bodies.
  [[nodiscard]] Body largest() const;
};

/// Takes the second trajectory at its own samples and where the first ends, the first interpolated
/// linearly between its own. Neither may be empty; both have the same bodies.
Difference difference(const std::vector<suspension::Sample>& first,
                      const std::vector<suspension::Sample>& second);

/// Time of a step in milliseconds. Each part is the largest of all ranks; `rest` is what remains of
/// the step (boxes, locating, exchange, waiting), or 0 should the others overlap more than that.
struct StepCost {
  double fluid = 0;
  double interpolation = 0;
  double bodies = 0;  ///< of capsules: the membrane
  double spreading = 0;
  double rest = 0;
  double step = 0;
};
/// Nothing of a run without a step.
std::optional<StepCost> step_cost(const RunProfile& profile);

/// One column an integrator; differences are to the first. Numbers that nothing stands behind are
/// shown as '-'. What made a run fail follows below.
std::string table(const std::vector<Contender>& contenders);

/// compare.json: the numbers of the table and more, in full; ductile/comparisons.py reads it. Each
/// run's directory is that of its integrator's name.
std::string to_json(const std::vector<Contender>& contenders);

}  // namespace ductile::drivers
