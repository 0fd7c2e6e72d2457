// Scenarios and their keys as text.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "scenario/scenario.hpp"

namespace ductile::drivers {

/// The scenario as TOML, every key that applies with its unit and meaning as a comment. Read again,
/// it gives the identical scenario.
std::string resolved_toml(const Scenario& scenario);
/// The same without [run]: what may not be another when a run goes on.
std::string system_toml(const Scenario& scenario);

/// Every key that applies, by the name that --set knows ("channel.nodes", "body.lag.x"), and its
/// value as TOML, which is JSON as well.
std::vector<std::pair<std::string, std::string>> parameters(const Scenario& scenario);

/// Every key with type, bounds, default, unit and meaning, for people to read.
std::string describe_keys();

}  // namespace ductile::drivers
