// Where points meet the lattice: forces at points, velocities at points.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "ductile/fluid/fluid.hpp"

namespace ductile::fluid {

/// A component of a velocity from its four planes' parts, the same wherever they are added.
inline double sum_of_planes(const double* parts) {
  return ((parts[0] + parts[1]) + parts[2]) + parts[3];
}

/// Points in one of a fluid's boxes, with Peskin's 4-point kernel between them and the nodes,
/// eqs. (15)-(17). Each rank acts on the nodes that it holds and on no others; no call is
/// collective. Positions are in lattice units, of node (i, j, k) as (i, j, k); z of any periodic
/// image.
class Points {
 public:
  /// No points yet; those to come lie in box `box` of the ones that were placed last. They can be
  /// used until boxes are placed anew. The fluid outlives them.
  Points(Fluid& fluid, int box);
  ~Points();
  Points(Points&&) noexcept;
  Points& operator=(Points&&) noexcept;
  Points(const Points&) = delete;
  Points& operator=(const Points&) = delete;

  /// Where they are until the next call; 3n numbers, x y z of each in turn, not kept. The box holds
  /// all nodes that they reach.
  void locate(std::span<const double> positions);
  /// n.
  [[nodiscard]] std::size_t size() const;
  /// Whether this rank holds all four planes of nodes that point m reaches.
  [[nodiscard]] bool whole(std::size_t m) const;
  /// How many are not.
  [[nodiscard]] std::size_t split() const;

  /// Adds `force`, 3n numbers, to the force that acts on the fluid in the next step, point by
  /// point, eq. (16) (the minus sign is in the force). Across a mirror plane each point has an
  /// image, which exerts the image of its force: points of a surface that is its own image exert
  /// half of what they exert in the whole fluid.
  void add_force(std::span<const double> force);
  /// velocity[3 m ..] <- the velocity of each whole point m, eq. (15), the sum over the four planes
  /// of nodes that it reaches in their order; 3n numbers, of which those of other points are left
  /// as they are. Of those, in their order, partial[12 n + 4 component + plane] <- the part from
  /// each plane, 0 from those that this rank does not hold: sum_of_planes() of what the ranks add
  /// up to is the same to the last bit on any number of them. The velocity is that left by
  /// Fluid::update_velocity() or step().
  void velocities(std::span<double> velocity, std::span<double> partial) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ductile::fluid
