// Where bodies are: the gaps between them and to the walls.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "ductile/suspension/plan.hpp"

namespace ductile::drivers {

/// Smallest distance between two surfaces.
struct Gap {
  enum class To { wall, body, image };
  To to = To::wall;
  std::size_t body = 0;   ///< index in Plan::bodies
  std::size_t other = 0;  ///< the other body's index; for a wall, its axis: 0 for x, 1 for y
  double distance = 0;    ///< lattice spacings; negative where they overlap
};

/// Below so many lattice spacings the flow in a gap is not resolved.
constexpr double resolved_gap = 4;

/// The gaps of every body to the nearer wall of each axis and to its own images, and of those
/// between two bodies (the nearest images of them) all below resolved_gap, or the smallest if none
/// is. That between two bodies of which neither is a sphere is taken between the vertices of fine
/// meshes, a few per cent too long for very small gaps; where bodies overlap only the sign of the
/// distance counts. Takes time in proportion to the bodies and to the pairs of them that are near.
std::vector<Gap> gaps(const suspension::Plan& plan);

/// Farthest that a body reaches from the middle of the channel along x or y (axis 0 or 1).
double reach_from_axis(const suspension::Plan& plan, std::size_t body, int axis);

/// How messages call a body and a wall: `body "lag"`, "the wall at x = -1".
std::string body_name(const suspension::Plan& plan, std::size_t body);
std::string wall_name(const suspension::Plan& plan, const Gap& gap);

/// The number of nodes across that widens a gap to `wanted` lattice spacings.
int nodes_for_gap(const suspension::Plan& plan, double distance, double wanted);

/// Lengths that differ by less, in lattice spacings, count as equal.
constexpr double round_off = 1e-9;

}  // namespace ductile::drivers
