// Defaults that follow from other keys.
#pragma once

#include "scenario/scenario.hpp"

namespace ductile::drivers {

constexpr double paper_volume_modulus = 75000;  ///< rho nu^2/W^2

/// [membrane] volume_modulus, in rho nu^2/W^2: the paper's 75000, or where that is above 1.5 in
/// lattice units, what 1.5 comes to, rounded down to three digits. The explicit scheme bears more,
/// unless the capsule or tau is small (analysis/stability.hpp).
double default_volume_modulus(const ChannelOptions& channel, const FluidOptions& fluid);

/// [run] stop_distance, in W: 10, or in a shorter channel its length less 2, or half its length if
/// that is more.
double default_stop_distance(const ChannelOptions& channel);

}  // namespace ductile::drivers
