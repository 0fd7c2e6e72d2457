// The report of `ductile check`: what a case would be when run.
#pragma once

#include <optional>
#include <string>

#include "checks/speed.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Lattice, flow, bodies with their margins of stability, gaps, memory and time, notes and
/// warnings; a line each.
std::string report(const Case& given, int cores, const std::optional<KnownSpeed>& known);

}  // namespace ductile::drivers
