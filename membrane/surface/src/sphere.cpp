#include "ductile/surface/sphere.hpp"

#include <numbers>

namespace ductile::surface {

Sphere::Sphere(double radius) : Shape(shape_name, radius, {{Eigen::Vector3d::Zero()}, radius}) {}

Mesh Sphere::mesh(int frequency, double offset) const {
  return icosphere(frequency, radius() + offset);
}

bool Sphere::contains(const Eigen::Vector3d& point) const {
  return point.norm() < radius();
}

double Sphere::volume() const {
  return 4.0 / 3 * std::numbers::pi * radius() * radius() * radius();
}

double Sphere::area() const {
  return 4 * std::numbers::pi * radius() * radius();
}

Eigen::Matrix3d Sphere::inertia() const {
  return Eigen::Matrix3d::Identity() * (0.4 * volume() * radius() * radius());
}

}  // namespace ductile::surface
