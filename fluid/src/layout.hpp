// Boxes of nodes and slabs of planes.
#pragma once

#include <span>
#include <vector>

#include "ductile/fluid/fluid.hpp"

namespace ductile::fluid {

/// The image of a plane in [0, period); unchanged without a period.
int first_image(int plane, int period);

/// The first plane of `box` brought into [0, period); unchanged without a period.
Box wrapped(Box box, int period);

/// Boxes that overlap are replaced by their common bounding box until none do; z repeats with
/// `period` (0: it does not). The result does not depend on the order of the boxes.
std::vector<Box> merged(std::span<const Box> boxes, int period);

/// Whether `inner` lies in `outer`, in any periodic image.
bool contains(const Box& outer, const Box& inner, int period);

/// Whether any of the `count` planes from `first` on lies in the slab, and whether all do.
bool touches(int first, int count, Range slab, int period);
bool within(int first, int count, Range slab, int period);

}  // namespace ductile::fluid
