#include "ductile/surface/shape.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "ductile/surface/biconcave.hpp"
#include "ductile/surface/sphere.hpp"

namespace ductile::surface {
namespace {

struct Entry {
  std::string_view name;
  std::shared_ptr<const Shape> (*make)(double radius);
};

template <class S>
constexpr Entry entry() {
  return {S::shape_name, [](double radius) -> std::shared_ptr<const Shape> {
            return std::make_shared<S>(radius);
          }};
}

constexpr Entry shapes[] = {
    entry<Sphere>(),
    entry<Biconcave>(),
};

}  // namespace

Shape::Shape(std::string_view name, double radius, Core core)
    : name_(name), radius_(radius), core_(std::move(core)) {
  if (!(radius > 0) || !std::isfinite(radius)) {
    throw std::invalid_argument(std::string(name) + ": radius " + std::to_string(radius) +
                                " is not positive");
  }
}

double Shape::reach() const {
  double furthest = 0;
  for (const Eigen::Vector3d& point : core_.points) furthest = std::max(furthest, point.norm());
  return furthest + core_.radius;
}

double Shape::extent(const Eigen::Vector3d& direction) const {
  double furthest = 0;
  for (const Eigen::Vector3d& point : core_.points)
    furthest = std::max(furthest, point.dot(direction));
  return furthest + core_.radius;
}

std::shared_ptr<const Shape> make_shape(std::string_view name, double radius) {
  std::string known;
  for (const Entry& shape : shapes) {
    if (shape.name == name) return shape.make(radius);
    known += known.empty() ? "" : ", ";
    known += shape.name;
  }
  throw std::invalid_argument("unknown shape '" + std::string(name) + "'; known: " + known);
}

std::vector<std::string_view> shape_names() {
  std::vector<std::string_view> names;
  for (const Entry& shape : shapes) names.push_back(shape.name);
  return names;
}

}  // namespace ductile::surface
