#include "checks/geometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace ductile::drivers {
namespace {

using Eigen::Vector3d;
using suspension::BodyPlan;
using suspension::Plan;

/// A body's surface where it starts: balls about some points stand for it in distances.
class Placed {
 public:
  explicit Placed(const BodyPlan& body)
      : body_(body), reach_(body.shape->reach()), core_(body.shape->core()) {
    for (Vector3d& point : core_.points) point = body.rotation * point + body.centre;
  }

  [[nodiscard]] const Vector3d& centre() const { return body_.centre; }
  /// Radius of a ball about the centre that holds the body.
  [[nodiscard]] double reach() const { return reach_; }
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
  double reach_;
  surface::Core core_;
};

/// Distance to the nearest periodic image of another body (or to the body itself), if it is below
/// `within`; else some distance that is not.
double nearest_image(const Placed& a, const Placed& b, const Plan& plan, double within) {
  const Vector3d apart = b.centre() - a.centre();
  const auto& nodes = plan.fluid.nodes;
  const int images_y = plan.side_walls() ? 0 : 1;
  const double home_y = images_y == 0 ? 0 : -std::round(apart.y() / nodes[1]);
  const double home_z = -std::round(apart.z() / nodes[2]);
  double nearest = within;
  for (int y = -images_y; y <= images_y; ++y) {
    for (int z = -1; z <= 1; ++z) {
      const Vector3d shift(0, (home_y + y) * nodes[1], (home_z + z) * nodes[2]);
      if ((apart + shift).norm() - a.reach() - b.reach() < nearest)
        nearest = std::min(nearest, a.distance(b, shift));
    }
  }
  return nearest;
}

/// All gaps below `within` between two bodies, the first index being the lower. Only bodies whose
/// balls, about their centres, are as near along z are looked at.
std::vector<Gap> near_pairs(const std::vector<Placed>& bodies, const Plan& plan, double within) {
  const double length = plan.fluid.nodes[2];
  const auto folded = [length](double z) { return z - length * std::floor(z / length); };
  std::vector<std::pair<double, std::size_t>> order;
  double largest = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    order.emplace_back(folded(bodies[i].centre().z()), i);
    largest = std::max(largest, bodies[i].reach());
  }
  std::ranges::sort(order);
  std::vector<Gap> result;
  const std::size_t n = order.size();
  for (std::size_t at = 0; at < n; ++at) {
    const auto [z, i] = order[at];
    const double farthest = bodies[i].reach() + largest + within;
    // Onwards along z and round the end, up to half a period: the rest is met the other way.
    for (std::size_t step = 1; step < n; ++step) {
      const std::size_t next = (at + step) % n;
      const double apart = order[next].first - z + (at + step < n ? 0 : length);
      if (apart > farthest || 2 * apart > length || (2 * apart == length && next < at)) break;
      const std::size_t j = order[next].second;
      const double distance =
          nearest_image(bodies[std::min(i, j)], bodies[std::max(i, j)], plan, within);
      if (distance < within)
        result.push_back({Gap::To::body, std::min(i, j), std::max(i, j), distance});
    }
  }
  return result;
}

/// Those below resolved_gap, or the smallest if there is none.
std::vector<Gap> pairs(const std::vector<Placed>& bodies, const Plan& plan) {
  std::vector<Gap> found;
  const auto& nodes = plan.fluid.nodes;
  const double everywhere = 2.0 * (nodes[0] + nodes[1] + nodes[2]);
  for (double within = resolved_gap; bodies.size() > 1 && found.empty(); within *= 2) {
    found = near_pairs(bodies, plan, within);
    if (within > resolved_gap && !found.empty())
      found = {*std::ranges::min_element(found, {}, &Gap::distance)};
    if (within > everywhere) break;
  }
  std::ranges::sort(found, {}, [](const Gap& gap) { return std::pair(gap.body, gap.other); });
  return found;
}

double from_axis(const Placed& body, const Plan& plan, int axis) {
  return std::abs(body.centre()[axis] - plan.units.origin()[axis]) + body.extent(axis);
}

}  // namespace

double reach_from_axis(const Plan& plan, std::size_t body, int axis) {
  return from_axis(Placed(plan.bodies[body]), plan, axis);
}

int nodes_for_gap(const Plan& plan, double distance, double wanted) {
  constexpr double most = 1e9;  // more than any lattice has
  const double width = std::min(2 * plan.units.half_width() * wanted / distance, most);
  return static_cast<int>(std::ceil(width - round_off)) +
         (plan.fluid.boundary[0] == fluid::Boundary::regularized ? 1 : 0);
}

std::vector<Gap> gaps(const Plan& plan) {
  std::vector<Placed> bodies;
  for (const BodyPlan& body : plan.bodies) bodies.emplace_back(body);
  const std::array<double, 2> half_widths{plan.units.half_width(), plan.half_width_y()};
  const std::vector<Gap> between = pairs(bodies, plan);
  auto next = between.begin();
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
    for (; next != between.end() && next->body == i; ++next) result.push_back(*next);
  }
  return result;
}

}  // namespace ductile::drivers
