#include "checks/geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ductile::drivers {
namespace {

using Eigen::Vector3d;
using suspension::BodyPlan;
using suspension::Plan;

/// A body's surface where it starts: balls about some points stand for it in distances.
class Placed {
 public:
  explicit Placed(const BodyPlan& body) : body_(body), core_(body.shape->core()) {
    for (Vector3d& point : core_.points) point = body.rotation * point + body.centre;
  }

  [[nodiscard]] const Vector3d& centre() const { return body_.centre; }
  /// Radius of a ball about the centre that holds the body.
  [[nodiscard]] double reach() const { return body_.shape->reach(); }
  /// Half of the body's width along an axis.
  [[nodiscard]] double extent(int axis) const {
    return body_.shape->extent(body_.rotation.transpose() * Vector3d::Unit(axis));
  }

  /// Distance to `other` moved by `shift`.
  [[nodiscard]] double distance(const Placed& other, const Vector3d& shift) const {
    double nearest2 = std::numeric_limits<double>::infinity();
    for (const Vector3d& mine : core_.points) {
      const Vector3d p = mine - shift;
      for (const Vector3d& theirs : other.core_.points)
        nearest2 = std::min(nearest2, (p - theirs).squaredNorm());
    }
    const double nearest = std::sqrt(nearest2) - core_.radius - other.core_.radius;
    const bool inside =
        std::ranges::any_of(core_.points,
                            [&](const Vector3d& p) { return other.contains(p - shift); }) ||
        std::ranges::any_of(other.core_.points,
                            [&](const Vector3d& p) { return contains(p + shift); });
    return inside ? std::min(nearest, -round_off) : nearest;
  }

 private:
  [[nodiscard]] bool contains(const Vector3d& point) const {
    return body_.shape->contains(body_.rotation.transpose() * (point - body_.centre));
  }

  const BodyPlan& body_;
  surface::Core core_;
};

/// Distance to the nearest periodic image of another body (or to the body itself).
double nearest_image(const Placed& a, const Placed& b, const Plan& plan) {
  const Vector3d apart = b.centre() - a.centre();
  const auto& nodes = plan.fluid.nodes;
  const int images_y = plan.side_walls() ? 0 : 1;
  const double home_y = images_y == 0 ? 0 : -std::round(apart.y() / nodes[1]);
  const double home_z = -std::round(apart.z() / nodes[2]);
  double nearest = std::numeric_limits<double>::infinity();
  for (int y = -images_y; y <= images_y; ++y) {
    for (int z = -1; z <= 1; ++z) {
      const Vector3d shift(0, (home_y + y) * nodes[1], (home_z + z) * nodes[2]);
      if ((apart + shift).norm() - a.reach() - b.reach() < nearest)
        nearest = std::min(nearest, a.distance(b, shift));
    }
  }
  return nearest;
}

double from_axis(const Placed& body, const Plan& plan, int axis) {
  return std::abs(body.centre()[axis] - plan.units.origin()[axis]) + body.extent(axis);
}

}  // namespace

double reach_from_axis(const Plan& plan, std::size_t body, int axis) {
  return from_axis(Placed(plan.bodies[body]), plan, axis);
}

int nodes_for_gap(const Plan& plan, double distance, double wanted) {
  const double width = 2 * plan.units.half_width() * wanted / distance;
  return static_cast<int>(std::ceil(width - round_off)) +
         (plan.fluid.boundary[0] == fluid::Boundary::regularized ? 1 : 0);
}

std::vector<Gap> gaps(const Plan& plan) {
  std::vector<Placed> bodies;
  for (const BodyPlan& body : plan.bodies) bodies.emplace_back(body);
  const std::array<double, 2> half_widths{plan.units.half_width(), plan.half_width_y()};
  std::vector<Gap> result;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<int>(axis);
      if (axis == 2 || (axis == 1 && !plan.side_walls())) {
        result.push_back({Gap::To::image, i, i, plan.fluid.nodes[axis] - 2 * bodies[i].extent(a)});
      } else {
        const int side = bodies[i].centre()[a] < plan.units.origin()[a] ? -1 : 1;
        result.push_back(
            {Gap::To::wall, i, axis, half_widths[axis] - from_axis(bodies[i], plan, a), side});
      }
    }
    for (std::size_t j = i + 1; j < bodies.size(); ++j)
      result.push_back({Gap::To::body, i, j, nearest_image(bodies[i], bodies[j], plan)});
  }
  return result;
}

}  // namespace ductile::drivers
