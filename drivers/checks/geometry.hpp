// Where bodies are: the gaps between them and to the walls.
#pragma once

#include <cstddef>
#include <vector>

#include "ductile/suspension/gaps.hpp"
#include "ductile/suspension/plan.hpp"

namespace ductile::drivers {

using suspension::Gap;

/// Below so many lattice spacings the flow in a gap is not resolved.
constexpr double resolved_gap = 4;

/// The gaps where the bodies start: of every body to the nearer wall of each axis and to its own
/// images, and of those between two bodies (the nearest images of them) all below resolved_gap, or
/// the smallest if none is. That between two bodies of which neither is a sphere is taken between
/// the vertices of fine meshes, a few per cent too long for very small gaps; where bodies overlap
/// only the sign of the distance counts. Takes time in proportion to the bodies and to the pairs of
/// them that are near.
std::vector<Gap> gaps(const suspension::Plan& plan);

/// Farthest that a body reaches from the middle of the channel along x or y (axis 0 or 1).
double reach_from_axis(const suspension::Plan& plan, std::size_t body, int axis);

/// The number of nodes across that widens a gap to `wanted` lattice spacings.
int nodes_for_gap(const suspension::Plan& plan, double distance, double wanted);

/// Lengths that differ by less, in lattice spacings, count as equal.
constexpr double round_off = 1e-9;

}  // namespace ductile::drivers
