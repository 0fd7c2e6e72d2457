// The paper's seven pairs, drivers/scenarios/M1.toml to B4.toml, as they were when built.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

namespace ductile::drivers {

/// Name and scenario file of each, in the paper's order.
const std::vector<std::pair<std::string_view, std::string_view>>& pair_scenarios();

}  // namespace ductile::drivers
