#include "ductile/surface/distance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>

namespace ductile::surface {
namespace {

using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

constexpr double infinity = std::numeric_limits<double>::infinity();

double distance2_to_edge(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d edge = b - a;
  const double length2 = edge.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(edge) / length2, 0.0, 1.0) : 0;
  return (p - a - t * edge).squaredNorm();
}

double distance2_to_triangle(const Vector3d& p, const Corners& x) {
  const Vector3d normal = (x[1] - x[0]).cross(x[2] - x[0]);
  bool above = true;  // whether p projects onto the triangle
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d inward = normal.cross(x[(k + 1) % 3] - x[k]);
    above = above && inward.dot(p - x[k]) >= 0;
  }
  const double area2 = normal.squaredNorm();
  if (above && area2 > 0) {
    const double height = (p - x[0]).dot(normal);
    return height * height / area2;
  }
  return std::min({distance2_to_edge(p, x[0], x[1]), distance2_to_edge(p, x[1], x[2]),
                   distance2_to_edge(p, x[2], x[0])});
}

// Six times the volume of a tetrahedron.
double volume6(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

bool pierces(const Vector3d& p, const Vector3d& q, const Corners& x) {
  if (volume6(x[0], x[1], x[2], p) * volume6(x[0], x[1], x[2], q) >= 0) return false;
  const double side = volume6(p, q, x[0], x[1]);
  return side * volume6(p, q, x[1], x[2]) > 0 && side * volume6(p, q, x[2], x[0]) > 0;
}

double longest_edge(const SurfaceView& surface) {
  double longest2 = 0;
  for (const auto& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      longest2 =
          std::max(longest2, (surface.vertex(t[k]) - surface.vertex(t[(k + 1) % 3])).squaredNorm());
    }
  }
  return std::sqrt(longest2);
}

Bounds widened(const Bounds& box, double by) {
  return {box.low.array() - by, box.high.array() + by};
}
Bounds common(const Bounds& a, const Bounds& b) {
  return {a.low.cwiseMax(b.low), a.high.cwiseMin(b.high)};
}
bool empty(const Bounds& box) {
  return !(box.low.array() <= box.high.array()).all();
}
bool holds(const Bounds& box, const Vector3d& p) {
  return (p.array() >= box.low.array()).all() && (p.array() <= box.high.array()).all();
}

// The triangles of a surface, moved by a shift, that come within `reach` of the points of a box, by
// cells: those near a point are all in its cell.
class NearTriangles {
 public:
  NearTriangles(const SurfaceView& surface, const Vector3d& shift, const Bounds& box, double reach)
      : box_(box), cell_(reach) {
    for (int a = 0; a < 3; ++a) {
      const double cells = std::ceil((box.high[a] - box.low[a]) / cell_);
      count_[static_cast<std::size_t>(a)] = std::max(1, static_cast<int>(cells));
    }
    cells_.resize(static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1]) *
                  static_cast<std::size_t>(count_[2]));
    for (const auto& t : surface.triangles) {
      const Corners x{surface.vertex(t[0]) + shift, surface.vertex(t[1]) + shift,
                      surface.vertex(t[2]) + shift};
      add(x, reach);
    }
  }

  /// Those near a point of the box.
  [[nodiscard]] const std::vector<Corners>& near(const Vector3d& p) const {
    return cells_[index(place(p))];
  }

 private:
  using Place = std::array<int, 3>;

  [[nodiscard]] Place place(const Vector3d& p) const {
    Place at{};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<int>(a);
      at[a] = std::clamp(static_cast<int>((p[axis] - box_.low[axis]) / cell_), 0, count_[a] - 1);
    }
    return at;
  }
  [[nodiscard]] std::size_t index(const Place& at) const {
    return (static_cast<std::size_t>(at[0]) * static_cast<std::size_t>(count_[1]) +
            static_cast<std::size_t>(at[1])) *
               static_cast<std::size_t>(count_[2]) +
           static_cast<std::size_t>(at[2]);
  }
  void add(const Corners& x, double reach) {
    const Bounds around = common(
        widened({x[0].cwiseMin(x[1]).cwiseMin(x[2]), x[0].cwiseMax(x[1]).cwiseMax(x[2])}, reach),
        box_);
    if (empty(around)) return;
    const Place low = place(around.low);
    const Place high = place(around.high);
    for (int i = low[0]; i <= high[0]; ++i) {
      for (int j = low[1]; j <= high[1]; ++j) {
        for (int k = low[2]; k <= high[2]; ++k) cells_[index({i, j, k})].push_back(x);
      }
    }
  }

  Bounds box_;
  double cell_;
  std::array<int, 3> count_{};
  std::vector<std::vector<Corners>> cells_;
};

// From the vertices and edges of one surface in a box to the triangles of the other.
class Search {
 public:
  Search(const SurfaceView& from, const Bounds& box, const NearTriangles& triangles)
      : from_(from), box_(box), triangles_(triangles) {}

  [[nodiscard]] double nearest2() const {
    double nearest2 = infinity;
    for (std::size_t n = 0; n < from_.positions.size(); n += 3) {
      const Vector3d p = Vector3d::Map(&from_.positions[n]);
      if (!holds(box_, p)) continue;
      for (const Corners& x : triangles_.near(p))
        nearest2 = std::min(nearest2, distance2_to_triangle(p, x));
    }
    return nearest2;
  }

  /// Whether an edge goes through a triangle. The edge starts in the triangle's reach if that is
  /// longer than the edge.
  [[nodiscard]] bool pierce() const {
    return std::ranges::any_of(from_.triangles, [this](const std::array<int, 3>& t) {
      for (std::size_t k = 0; k < 3; ++k) {
        // The neighbour has the same edge, the other way round.
        if (t[k] < t[(k + 1) % 3] && pierces_any(t[k], t[(k + 1) % 3])) return true;
      }
      return false;
    });
  }

 private:
  [[nodiscard]] bool pierces_any(int from, int to) const {
    const Vector3d p = from_.vertex(from);
    if (!holds(box_, p)) return false;
    const Vector3d q = from_.vertex(to);
    return std::ranges::any_of(triangles_.near(p),
                               [&](const Corners& x) { return pierces(p, q, x); });
  }

  const SurfaceView& from_;
  const Bounds& box_;
  const NearTriangles& triangles_;
};

}  // namespace

Bounds bounds(std::span<const double> positions) {
  Bounds box{Vector3d::Constant(infinity), Vector3d::Constant(-infinity)};
  for (std::size_t n = 0; n < positions.size(); n += 3) {
    const Vector3d x = Vector3d::Map(&positions[n]);
    box.low = box.low.cwiseMin(x);
    box.high = box.high.cwiseMax(x);
  }
  return box;
}

double distance(const SurfaceView& a, const SurfaceView& b, const Vector3d& shift, double reach) {
  if (!(reach > 0))
    throw std::invalid_argument("distance: reach " + std::to_string(reach) + " must be positive");
  const Bounds box_a = bounds(a.positions);
  Bounds box_b = bounds(b.positions);
  box_b.low += shift;
  box_b.high += shift;
  if (empty(common(widened(box_a, reach), box_b))) return infinity;

  const double longest = std::max(longest_edge(a), longest_edge(b));
  const double wide = std::max(reach, longest);
  const Bounds of_a = common(box_a, widened(box_b, wide));
  const Bounds of_b = common(box_b, widened(box_a, wide));
  const NearTriangles near_b(b, shift, of_a, wide);
  // The other way round everything is moved back by the shift.
  const Bounds of_b_at_home{of_b.low - shift, of_b.high - shift};
  const NearTriangles near_a(a, -shift, of_b_at_home, wide);
  const Search from_a(a, of_a, near_b);
  const Search from_b(b, of_b_at_home, near_a);
  const double nearest = std::sqrt(std::min(from_a.nearest2(), from_b.nearest2()));
  if (nearest <= longest && (from_a.pierce() || from_b.pierce())) return 0;
  return nearest < reach ? nearest : infinity;
}

}  // namespace ductile::surface
