// Where points meet the lattice: forces at points, velocities at points.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "ductile/fluid/fluid.hpp"

namespace ductile::fluid {

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

  /// Adds `force`, 3n numbers, to the force that acts on the fluid in the next step, point by
  /// point, eq. (16) (the minus sign is in the force). Across a mirror plane each point has an
  /// image, which exerts the image of its force: points of a surface that is its own image exert
  /// half of what they exert in the whole fluid.
  void add_force(std::span<const double> force);
  /// partial[12 m + 4 component + plane] <- the part of point m's velocity, eq. (15), that comes
  /// from each of the four planes of nodes that it reaches, 0 of planes that this rank does not
  /// hold. Summed in the planes' order over the ranks that hold them they are the same to the last
  /// bit on any number of ranks. The velocity is that left by Fluid::update_velocity() or step().
  void velocities(std::span<double> partial) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ductile::fluid
