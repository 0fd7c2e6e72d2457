// The report of `ductile check`: what a case would be when run.
#pragma once

#include <optional>
#include <string>

#include "checks/speed.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Seconds for which `check` predicts stability unless asked to be thorough.
constexpr double usual_patience = 0.3;

/// Lattice, flow, bodies with their margins of stability, gaps, memory and time, notes and
/// warnings; a line each. The stability of capsules is predicted as long as it takes `patience`
/// seconds at most, as StabilityModels estimates them.
std::string report(const Case& given, int cores, const std::optional<KnownSpeed>& known,
                   double patience = usual_patience);

}  // namespace ductile::drivers
