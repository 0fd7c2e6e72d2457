// From a scenario, in the paper's units, to a plan in lattice units.
#pragma once

#include <cstdint>

#include "ductile/suspension/plan.hpp"
#include "scenario/scenario.hpp"

namespace ductile::drivers {

/// When a run ends and what it writes on the way, in time steps; 0 is never.
struct Schedule {
  std::int64_t end = 0;
  std::int64_t rows = 0;
  std::int64_t surfaces = 0;
  std::int64_t fields = 0;
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
