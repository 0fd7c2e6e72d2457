// For benchmarks: what bounds the fluid's speed.
#pragma once

#include "ductile/fluid/fluid.hpp"

namespace ductile::fluid {

/// The memory traffic of one Fluid::step() without the collision: every population of this rank is
/// loaded from and stored to where an even or an odd step would (in turn), walls and prefetches
/// alike, and no message is sent. Its speed is the most that the machine's memory allows the step.
/// Leaves the populations meaningless: initialise() before stepping again.
void stream_only(Fluid& fluid);

}  // namespace ductile::fluid
