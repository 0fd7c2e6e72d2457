// The sphere.
#pragma once

#include "ductile/surface/shape.hpp"

namespace ductile::surface {

/// The sphere of radius a. Its core is its centre, with the radius a.
class Sphere final : public Shape {
 public:
  static constexpr std::string_view shape_name = "sphere";

  /// Throws std::invalid_argument if the radius is not positive.
  explicit Sphere(double radius);

  /// icosphere(frequency, a + offset).
  [[nodiscard]] Mesh mesh(int frequency, double offset = 0) const override;
  [[nodiscard]] bool contains(const Eigen::Vector3d& point) const override;
  [[nodiscard]] double volume() const override;
  [[nodiscard]] double area() const override;
  [[nodiscard]] Eigen::Matrix3d inertia() const override;
};

}  // namespace ductile::surface
