// Force and velocity where they vary from node to node.
#pragma once

#include <array>
#include <cstddef>
#include <variant>
#include <vector>

#include "ductile/fluid/fluid.hpp"

namespace ductile::fluid {

/// What there is on a patch's nodes. T is what the collision computes in: bodies read and write far
/// more of these than of anything else.
template <class T>
struct LocalFields {
  std::array<std::vector<T>, 3> force;     ///< beyond the uniform one, for the next step
  std::array<std::vector<T>, 3> velocity;  ///< (momentum + force/2)/density
  /// As of read_velocity(), with half of the uniform force, above a mirror plane; empty as long as
  /// no body asks.
  std::array<std::vector<T>, 3> momentum;
  std::vector<T> density;  ///< as momentum, and empty if it weighs nothing
};

/// The part of a box that lies on this rank: where a force acts that varies from node to node, and
/// where the velocity is known. Arrays run over x, y, z, z fastest; each row of z is `pitch` long,
/// with `pad` planes on either side of the `size[2]` that are this rank's own. In those planes the
/// velocity is 0 and the force is ignored, so that a stencil may reach over the edge.
///
/// Below a mirror plane the velocity is the image of that above. What is added to
/// `force` is half of the whole: its image in the plane is added to it, at the latest in the step,
/// also to what lies on the plane.
struct Patch {
  static constexpr int pad = 4;
  int box = 0;                 ///< index of the box it belongs to, among FluidImpl::boxes_
  std::array<int, 3> begin{};  ///< first own node; z in [0, nz)
  std::array<int, 3> size{};   ///< own nodes along each axis
  std::ptrdiff_t pitch = 0;

  std::variant<LocalFields<double>, LocalFields<float>> local;

  /// Its own, in [0, nz).
  [[nodiscard]] Range planes() const { return {begin[2], begin[2] + size[2]}; }
  /// Index of node (i, j, k), counted from `begin`; k may lie in the padding.
  [[nodiscard]] std::ptrdiff_t at(int i, int j, int k) const {
    return (static_cast<std::ptrdiff_t>(i) * size[1] + j) * pitch + pad + k;
  }
};

}  // namespace ductile::fluid
