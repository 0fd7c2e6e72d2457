// Whether two scenarios are one system.
#pragma once

#include <optional>
#include <string>

#include "scenario/scenario.hpp"

namespace ductile::drivers {

/// The first key whose value is another than before, and both values: "channel.reynolds = 12.0
/// where the run has 10.0"; nothing if none is. [run] may be another.
std::optional<std::string> difference(const Scenario& before, const Scenario& now);

}  // namespace ductile::drivers
