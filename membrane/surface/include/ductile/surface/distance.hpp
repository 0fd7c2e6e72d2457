// How near two surfaces are.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace ductile::surface {

/// A closed surface at one instant: x y z of each vertex in turn, and the triangles of its mesh.
/// Owns neither.
struct SurfaceView {
  std::span<const double> positions;
  std::span<const std::array<int, 3>> triangles;

  [[nodiscard]] Eigen::Vector3d vertex(int v) const {
    return Eigen::Vector3d::Map(&positions[3 * static_cast<std::size_t>(v)]);
  }
};

/// The box that holds a surface.
struct Bounds {
  Eigen::Vector3d low, high;
};
Bounds bounds(std::span<const double> positions);

/// The distance of two surfaces, the second moved by `shift`: 0 where one pierces the other,
/// infinity where it is `reach` or more. It is that of the vertices of each from the triangles of
/// the other. Throws std::invalid_argument unless reach is positive.
double distance(const SurfaceView& a, const SurfaceView& b, const Eigen::Vector3d& shift,
                double reach);

}  // namespace ductile::surface
