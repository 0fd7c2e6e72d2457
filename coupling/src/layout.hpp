// Where bodies are: the boxes of nodes around them, and the ranks whose slabs they touch.
#pragma once

#include <span>
#include <vector>

#include "ductile/fluid/fluid.hpp"

namespace ductile::coupling {

/// The first plane of `box` brought into [0, period); unchanged without a period.
fluid::Box wrapped(fluid::Box box, int period);

/// Boxes that overlap are replaced by their common bounding box until none do; z repeats with
/// `period` (0: it does not). The result does not depend on the order of the boxes.
std::vector<fluid::Box> merged(std::span<const fluid::Box> boxes, int period);

/// Whether `inner` lies in `outer`, in any periodic image.
bool contains(const fluid::Box& outer, const fluid::Box& inner, int period);

/// Whether any of the `count` planes from `first` on lies in the slab, and whether all do.
bool touches(int first, int count, fluid::Range slab, int period);
bool within(int first, int count, fluid::Range slab, int period);

}  // namespace ductile::coupling
