// The populations of a slab in memory, and where a row finds its own.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <optional>

#include "ductile/fluid/d3q19.hpp"
#include "ductile/fluid/fluid.hpp"
#include "kernel.hpp"

namespace ductile::fluid {

/// Zero-initialised memory on huge pages where the system grants them, so that the streams of a row
/// do not exhaust the TLB.
template <class Real>
class HugePages {
 public:
  explicit HugePages(std::size_t count) : bytes_(count * sizeof(Real)) {
    constexpr std::size_t huge = std::size_t{2} << 20U;
    const std::size_t rounded = (bytes_ + huge - 1) / huge * huge;
    data_.reset(static_cast<Real*>(std::aligned_alloc(huge, rounded)));
    if (!data_) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
    madvise(data_.get(), rounded, MADV_HUGEPAGE);
#endif
    std::fill_n(data_.get(), count, Real{0});
  }
  [[nodiscard]] Real* data() const {
    return data_.get();
  }
  [[nodiscard]] std::size_t bytes() const {
    return bytes_;
  }

 private:
  struct Free {
    void operator()(Real* p) const { std::free(p); }  // NOLINT: pairs with aligned_alloc
  };
  std::size_t bytes_;
  std::unique_ptr<Real, Free> data_;
};

/// Index of the velocity c_i mirrored in y.
constexpr int mirrored(int i) {
  const auto v = d3q19::c(i);
  int m = 0;
  while (d3q19::c(m) != std::array<int, 3>{v[0], -v[1], v[2]}) ++m;
  return m;
}

/// Nineteen arrays over x, y, z, z fastest. The populations are in one of the two states of the AA
/// pattern. Before an even step f_i of node x is in array i at x. The even step leaves the collided
/// f_i* in array opposite(i) at x; the odd step fetches f_i(x) from there, at x - c_i, and puts
/// f_i* in array i at x + c_i, which is the first state again. A half-way wall between x and x +
/// c_i sends f_i* back to x as f_(-i), and that is where the even step has left it: the odd step
/// then reads and writes array opposite(i) at x.
///
/// Below a mirror plane between nodes, f_i of node (x, -1) is f_m of node (x, 0), m being i
/// mirrored: what would come from there the odd step finds in array opposite(m) of row 0. On a
/// plane on node 0 f_i is f_m: there the two share a place.
template <class Real>
class Slab {
 public:
  Slab(const Options& options, int planes);

  [[nodiscard]] int planes() const { return planes_; }
  [[nodiscard]] std::size_t bytes() const { return storage_.bytes(); }

  /// Array i at column (x, y), from plane 0 of the slab on; planes -1 and planes() are there too,
  /// for what an odd step exchanges with the slabs below and above.
  [[nodiscard]] Real* at(int i, int x, int y) const { return column(x, y) + i * stride_; }
  /// Where f_i of column (x, y) streams from: (x, y) becomes that column, i the velocity that it
  /// has there, another only through a mirror plane. False if that is outside.
  bool trace(int& i, int& x, int& y) const {
    const auto v = d3q19::c(i);
    if (mirror_ == Mirror::between_nodes && y == 0 && v[1] > 0) {
      i = mirrored(i);
      return move(x, -v[0], nx_, boundary_[0]);
    }
    return move(x, -v[0], nx_, boundary_[0]) && move(y, -v[1], ny_, boundary_[1]);
  }
  /// Where the row finds its populations in an odd or an even step.
  [[nodiscard]] Row<Real> row(int x, int y, bool odd) const {
    const Places& places = places_[odd ? 1 : 0][kind(x, y)];
    Real* base = column(x, y);
    Row<Real> row;  // NOLINT(cppcoreguidelines-pro-type-member-init): every member is set below
    row.rest = base;
    for (int p = 0; p < d3q19::pairs; ++p) {
      const auto n = static_cast<std::size_t>(p);
      row.plus[p] = base + places.plus[n];
      row.minus[p] = base + places.minus[n];
    }
    return row;
  }
  /// The regularized wall that the row is on, if any.
  [[nodiscard]] const RowWall* wall(int x, int y) const {
    const auto& wall = walls_[kind(x, y)];
    return wall ? &*wall : nullptr;
  }
  /// Finds the regularized walls anew, with these velocities.
  void set_walls(const Options& options,
                 const std::array<std::array<Eigen::Vector3d, 2>, 3>& wall_velocity);
  /// The part of the cells around the column's nodes that is fluid: half on a regularized wall and
  /// on a mirror plane, a quarter where two of these meet.
  [[nodiscard]] double share(int x, int y) const {
    double share = mirror_ == Mirror::on_node && y == 0 ? 0.5 : 1;
    if (const RowWall* on = wall(x, y)) {
      for (const int normal : on->normal) share *= normal != 0 ? 0.5 : 1;
    }
    return share;
  }

 private:
  static constexpr std::ptrdiff_t line_ = 64 / sizeof(Real);
  static std::ptrdiff_t lines(std::ptrdiff_t n) { return (n + line_ - 1) / line_; }
  static bool move(int& x, int dx, int n, Boundary boundary) {
    x += dx;
    if (x >= 0 && x < n) return true;
    if (boundary != Boundary::periodic) return false;
    x = (x + n) % n;
    return true;
  }
  [[nodiscard]] Real* column(int x, int y) const {
    return storage_.data() + line_ + (static_cast<std::ptrdiff_t>(x) * ny_ + y) * pitch_;
  }
  // Rows of one kind are alike the first, the last or in between, in x and in y.
  [[nodiscard]] std::size_t kind(int x, int y) const {
    const auto along = [](int node, int n) { return node == 0 ? 0U : (node == n - 1 ? 2U : 1U); };
    return 3 * along(x, nx_) + along(y, ny_);
  }
  [[nodiscard]] std::ptrdiff_t place(int i, int x, int y, bool odd) const;
  void find_places();

  int nx_;
  int ny_;
  int planes_;
  std::array<Boundary, 3> boundary_;
  Mirror mirror_;
  std::ptrdiff_t pitch_;   // from row to row: plane -1 of one shares padding with the one before
  std::ptrdiff_t stride_;  // from array to array
  HugePages<Real> storage_;
  // Distances from a column's array 0.
  struct Places {
    std::array<std::ptrdiff_t, d3q19::pairs> plus;
    std::array<std::ptrdiff_t, d3q19::pairs> minus;
  };
  std::array<std::array<Places, 9>, 2> places_{};
  std::array<std::optional<RowWall>, 9> walls_;
};

template <class Real>
Slab<Real>::Slab(const Options& options, int planes)
    : nx_(options.nodes[0]),
      ny_(options.nodes[1]),
      planes_(planes),
      boundary_(options.boundary),
      mirror_(options.mirror),
      pitch_(lines(planes + 2) * line_),
      // An odd number of cache lines apart, the arrays do not compete for the same cache sets.
      stride_((lines(line_ + static_cast<std::ptrdiff_t>(nx_) * ny_ * pitch_) | 1) * line_),
      storage_(static_cast<std::size_t>(d3q19::Q * stride_)) {
  find_places();
  set_walls(options, options.wall_velocity);
}

// The distance of f_i from its column's array 0.
template <class Real>
std::ptrdiff_t Slab<Real>::place(int i, int x, int y, bool odd) const {
  const auto v = d3q19::c(i);
  if (mirror_ == Mirror::on_node && y == 0 && v[1] > 0) {
    return place(mirrored(i), x, y, odd);
  }
  int there = i;
  int xn = x;
  int yn = y;
  if (odd && trace(there, xn, yn)) {
    return at(d3q19::opposite(there), xn, yn) - v[2] - column(x, y);
  }
  return i * stride_;
}

template <class Real>
void Slab<Real>::find_places() {
  for (const int x : {0, nx_ / 2, nx_ - 1}) {
    for (const int y : {0, ny_ / 2, ny_ - 1}) {
      for (int p = 0; p < d3q19::pairs; ++p) {
        const auto n = static_cast<std::size_t>(p);
        for (const bool odd : {false, true}) {
          Places& places = places_[odd ? 1 : 0][kind(x, y)];
          places.plus[n] = place(d3q19::plus(p), x, y, odd);
          places.minus[n] = place(d3q19::minus(p), x, y, odd);
        }
      }
    }
  }
}

template <class Real>
void Slab<Real>::set_walls(const Options& options,
                           const std::array<std::array<Eigen::Vector3d, 2>, 3>& wall_velocity) {
  for (const int x : {0, nx_ / 2, nx_ - 1}) {
    for (const int y : {0, ny_ / 2, ny_ - 1}) {
      RowWall wall{};
      Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
      int count = 0;
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const int node = axis == 0 ? x : y;
        const bool low = node == 0;
        const bool high = node == options.nodes[axis] - 1;
        if (options.boundary[axis] != Boundary::regularized || !(low || high)) continue;
        if (axis == 1 && low && options.mirror != Mirror::none) continue;
        wall.normal[axis] = low ? 1 : -1;
        velocity += wall_velocity[axis][low ? 0 : 1];
        ++count;
      }
      if (count == 0) continue;
      // On an edge the mean of the two walls' velocities, less what would cross one of them.
      velocity /= count;
      for (const Eigen::Index axis : {0, 1}) {
        if (wall.normal[axis] != 0) velocity[axis] = 0;
      }
      std::copy_n(velocity.data(), 3, wall.velocity);
      walls_[kind(x, y)] = wall;
    }
  }
}

}  // namespace ductile::fluid
