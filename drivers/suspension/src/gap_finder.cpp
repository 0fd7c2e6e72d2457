#include "gap_finder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "ductile/surface/distance.hpp"

namespace ductile::suspension {

using Eigen::Vector3d;

/// A body's markers, and their surface.
struct GapFinder::Surface {
  std::size_t body;
  surface::SurfaceView view;
  surface::Bounds box;
};

// The numbering of an icosphere depends on its frequency alone, and shapes only move its vertices.
GapFinder::GapFinder(const Plan& plan) : plan_(plan) {
  std::map<int, std::shared_ptr<const Triangles>> known;
  for (const BodyPlan& body : plan.bodies) {
    std::shared_ptr<const Triangles>& triangles = known[body.frequency];
    if (!triangles) triangles = std::make_shared<const Triangles>(body.mesh().triangles);
    triangles_.push_back(triangles);
  }
}

std::vector<Gap> GapFinder::below(double reach,
                                  const std::vector<std::vector<double>>& positions) const {
  std::vector<Surface> surfaces;
  for (std::size_t b = 0; b < positions.size(); ++b) {
    surfaces.push_back({b, {positions[b], *triangles_[b]}, surface::bounds(positions[b])});
  }
  std::vector<Gap> gaps;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    add_walls(surfaces[i], reach, gaps);
    for (std::size_t j = i; j < surfaces.size(); ++j)
      add_bodies(surfaces[i], surfaces[j], reach, gaps);
  }
  return gaps;
}

void GapFinder::add_walls(const Surface& body, double reach, std::vector<Gap>& gaps) const {
  const std::array<double, 2> half_widths{plan_.units.half_width(), plan_.half_width_y()};
  for (std::size_t axis = 0; axis < (plan_.side_walls() ? 2U : 1U); ++axis) {
    const auto a = static_cast<int>(axis);
    const double middle = plan_.units.origin()[a];
    for (const int side : {-1, 1}) {
      const double outermost = side < 0 ? middle - body.box.low[a] : body.box.high[a] - middle;
      const double room = half_widths[axis] - outermost;
      const double distance = room - plan_.bodies[body.body].retraction();
      if (distance < reach)
        gaps.push_back({Gap::To::wall, body.body, axis, distance, side, room <= 0});
    }
  }
}

void GapFinder::add_bodies(const Surface& a, const Surface& b, double reach,
                           std::vector<Gap>& gaps) const {
  const bool same = a.body == b.body;
  const std::array<double, 3> period{0, plan_.side_walls() ? 0.0 : plan_.fluid.nodes[1],
                                     static_cast<double>(plan_.fluid.nodes[2])};
  // Images that may be near are those that bring the middles of the boxes together.
  const Vector3d apart = (a.box.low + a.box.high - b.box.low - b.box.high) / 2;
  std::array<std::vector<double>, 3> shifts{std::vector<double>{0}, {0}, {0}};
  for (std::size_t axis = 1; axis < 3; ++axis) {
    if (period[axis] == 0) continue;
    const double home = std::round(apart[static_cast<int>(axis)] / period[axis]);
    shifts[axis] = {home * period[axis], (home - 1) * period[axis], (home + 1) * period[axis]};
  }
  const double outside = this->outside(a.body, b.body);
  reach += outside;
  double nearest = std::numeric_limits<double>::infinity();
  for (const double y : shifts[1]) {
    for (const double z : shifts[2]) {
      if (same && y == 0 && z == 0) continue;
      const Vector3d shift(0, y, z);
      // Most are far apart, and their vertices need not be looked at.
      const bool near = (b.box.low + shift - a.box.high).maxCoeff() < reach &&
                        (a.box.low - b.box.high - shift).maxCoeff() < reach;
      if (near) nearest = std::min(nearest, surface::distance(a.view, b.view, shift, reach));
    }
  }
  if (nearest >= reach) return;
  // Where two surfaces are nearest their normals point at each other.
  gaps.push_back(
      {same ? Gap::To::image : Gap::To::body, a.body, b.body, nearest - outside, 0, nearest <= 0});
}

}  // namespace ductile::suspension
