// What a run writes, before it does.
#pragma once

#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Bytes of a run that comes to its time limit: rows, frames, and two checkpoints.
double disk_needed(const Case& given);

}  // namespace ductile::drivers
