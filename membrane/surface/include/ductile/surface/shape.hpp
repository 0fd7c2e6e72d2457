// Closed surfaces that bodies start from, by name: one file a shape.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string_view>
#include <vector>

#include "ductile/surface/mesh.hpp"

namespace ductile::surface {

/// Points and the radius of the balls about them that stand for a surface in distance checks.
struct Core {
  std::vector<Eigen::Vector3d> points;
  double radius = 0;
};

/// A closed, point-symmetric surface in its own frame, its centre (of mass and of symmetry) at the
/// origin. Lengths are in the unit of the radius.
class Shape {
 public:
  Shape(const Shape&) = delete;
  Shape& operator=(const Shape&) = delete;
  virtual ~Shape() = default;

  [[nodiscard]] std::string_view name() const { return name_; }
  /// The length a that scales the shape.
  [[nodiscard]] double radius() const { return radius_; }

  /// icosphere(frequency) mapped onto the surface, each vertex then moved by `offset` along the
  /// outward normal there (negative: inward). Throws std::invalid_argument as icosphere(), and for
  /// an offset at which the surface would meet or fold itself.
  [[nodiscard]] virtual Mesh mesh(int frequency, double offset = 0) const = 0;
  /// Whether the point lies inside.
  [[nodiscard]] virtual bool contains(const Eigen::Vector3d& point) const = 0;

  [[nodiscard]] virtual double volume() const = 0;
  [[nodiscard]] virtual double area() const = 0;
  /// Moments of inertia about the centre per unit density: the integral of |r|^2 1 - r r^T over the
  /// volume.
  [[nodiscard]] virtual Eigen::Matrix3d inertia() const = 0;

  [[nodiscard]] const Core& core() const { return core_; }
  /// Radius of the smallest ball about the centre that holds the core.
  [[nodiscard]] double reach() const;
  /// Largest component of the core along a unit vector; by symmetry minus the least.
  [[nodiscard]] double extent(const Eigen::Vector3d& direction) const;

 protected:
  /// `name` must outlive the shape. Throws std::invalid_argument if the radius is not positive.
  Shape(std::string_view name, double radius, Core core);

 private:
  std::string_view name_;
  double radius_;
  Core core_;
};

/// The shape of that name, one of shape_names(). Throws std::invalid_argument for any other,
/// listing them, and if the radius is not positive.
std::shared_ptr<const Shape> make_shape(std::string_view name, double radius);

/// The shapes there are.
std::vector<std::string_view> shape_names();

}  // namespace ductile::surface
