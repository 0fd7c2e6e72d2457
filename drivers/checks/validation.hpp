// Whether the values of a scenario go together, and whether its lattice can carry them.
#pragma once

#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Throws ScenarioError for the first of these that does not hold:
/// - no two keys contradict each other, and bodies start inside the channel's length;
/// - the Mach number is at most 0.3;
/// - radii are at least 2 lattice spacings, and no body reaches across periodic sides;
/// - no body is in a wall or in another body, and there are nodes enough across each gap: 2 lattice
///   spacings to a wall, so that the kernel's stencil stays in the fluid, 1 between bodies;
/// - where the channel is said to be symmetric, so is each body's mesh.
void validate(const Case& given);

}  // namespace ductile::drivers
