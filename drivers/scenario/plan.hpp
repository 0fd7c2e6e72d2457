// From a scenario, in the paper's units, to a plan in lattice units.
#pragma once

#include <cstdint>

#include "ductile/suspension/plan.hpp"
#include "scenario/scenario.hpp"

namespace ductile::drivers {

/// The most that is sound, errors of compressibility going as its square: a case that starts with
/// more is refused, a run that comes to more warns.
constexpr double largest_mach = 0.3;

/// When a run ends and what it writes on the way, in time steps. Intervals are not whole: what is
/// due every 0.05 W^2/nu is written at the steps nearest to 0.05, 0.1, 0.15 ..., at any resolution.
/// 0 is never.
struct Schedule {
  std::int64_t end = 0;
  double rows = 0;
  double surfaces = 0;
  double fields = 0;

  /// Whether `step` is the nearest to a multiple of the interval.
  static bool due(std::int64_t step, double interval);
};

/// A scenario and what it is in lattice units.
struct Case {
  Scenario scenario;
  suspension::Plan plan;
  Schedule schedule;
};

/// Plans a scenario whose values are each within their bounds; whether they go together, nobody has
/// seen yet. Lengths are rounded to whole nodes, and Re is that of the channel as it then is.
Case planned(Scenario scenario);

}  // namespace ductile::drivers
