// Scenarios and their keys as text.
#pragma once

#include <string>

#include "scenario/scenario.hpp"

namespace ductile::drivers {

/// The scenario as TOML, every key that applies with its unit and meaning as a comment. Read again,
/// it gives the identical scenario.
std::string resolved_toml(const Scenario& scenario);

/// Every key with type, bounds, default, unit and meaning, for people to read.
std::string describe_keys();

}  // namespace ductile::drivers
