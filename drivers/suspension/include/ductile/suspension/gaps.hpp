// The gaps between bodies, and between bodies and walls.
#pragma once

#include <cstddef>

namespace ductile::suspension {

/// Smallest distance between two surfaces. Where no film is computed between them (has_films()),
/// markers inside of their surface (BodyPlan::retraction()) keep apart by about a lattice spacing,
/// whatever lies between: a film of fluid so thin that the lattice does not resolve it may leave
/// surfaces that overlap by some tenths of a spacing.
struct Gap {
  enum class To { wall, body, image };
  To to = To::wall;
  std::size_t body = 0;   ///< index in Plan::bodies
  std::size_t other = 0;  ///< the other body's index; for a wall, its axis: 0 for x, 1 for y
  double distance = 0;    ///< lattice spacings; less than 0 where they overlap
  int side = 0;           ///< of a wall: -1 at the axis' low end, 1 at its high end
  bool crossed = false;   ///< the markers' surfaces meet: nothing is right any longer

  /// Whether both lie between the same two.
  [[nodiscard]] bool between_same(const Gap& gap) const {
    return to == gap.to && body == gap.body && other == gap.other && side == gap.side;
  }
};

/// How far the 4-point kernel reaches from a marker, in lattice spacings.
constexpr double kernel_reach = 2;

}  // namespace ductile::suspension
