// The paper's biconcave cell.
#pragma once

#include "ductile/surface/shape.hpp"

namespace ductile::surface {

/// The biconcave cell of the paper's eq. (18): the sphere of radius a, transformed. The dimple axis
/// is z; V = 2.7154735 a^3, A = 12.6200173 a^2. Its core is the vertices of mesh(16), without a
/// radius.
class Biconcave final : public Shape {
 public:
  static constexpr std::string_view shape_name = "biconcave";

  /// Throws std::invalid_argument if the radius is not positive.
  explicit Biconcave(double radius);

  /// An offset must be above -0.1242 a, where the two dimples meet, and below 0.632 a, where a
  /// dimple folds.
  [[nodiscard]] Mesh mesh(int frequency, double offset = 0) const override;
  [[nodiscard]] bool contains(const Eigen::Vector3d& point) const override;
  [[nodiscard]] double volume() const override;
  [[nodiscard]] double area() const override;
  [[nodiscard]] Eigen::Matrix3d inertia() const override;
};

}  // namespace ductile::surface
