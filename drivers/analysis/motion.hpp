// The swings of a pair's axial distance.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "analysis/series.hpp"

namespace ductile::drivers {

/// Slope of a straight line through points, by least squares, and what it may be at most and at
/// least.
struct Trend {
  double slope = 0;
  double error = 0;
  [[nodiscard]] double low() const { return slope - error; }
  [[nodiscard]] double high() const { return slope + error; }
  [[nodiscard]] double steepest() const { return std::abs(slope) + error; }
};

/// Extrema of dz are known to so much, the noise of the lattice [W].
constexpr double extremum_error = 0.01;

/// An extremum of dz, at a grid point.
struct Extremum {
  std::size_t at;
  double value;
};

/// dz of a pair up to a grid point, as the rules of the verdict see it. Refers to the series.
class Motion {
 public:
  /// A turning point is an extremum once dz has gone back from it by `reversal`.
  Motion(const UniformSeries& dz, const std::array<UniformSeries, 2>& x, std::size_t now,
         double reversal);

  [[nodiscard]] double start() const { return dz_.time(0); }
  [[nodiscard]] double elapsed() const { return duration(0, now_); }
  /// Extrema, not counting the start.
  [[nodiscard]] int extrema_count() const { return static_cast<int>(swings_.size()); }
  /// Swing that ended in the i-th extremum from the last (0). The first extremum's, from the
  /// start, is none of an oscillation.
  [[nodiscard]] double swing(int i = 0) const {
    return swings_[swings_.size() - 1 - static_cast<std::size_t>(i)];
  }
  [[nodiscard]] double largest_swing() const;
  /// From the last extremum to the present; from the start, if there is none.
  [[nodiscard]] double leg() const {
    return points_.empty() ? std::abs(dz_[now_] - dz_[0]) : std::abs(dz_[now_] - point(0).value);
  }
  /// Swings of at least so much, not counting the first.
  [[nodiscard]] int swings_above(double size) const;
  /// Time since the last swing of at least so much ended, the first counted; since the start, if
  /// there is none.
  [[nodiscard]] double time_since_swing(double size) const;
  /// The longest that a swing of at least so much has taken; 0 if there is none.
  [[nodiscard]] double longest_swing(double size) const;
  /// Time since the last extremum, over the longer of the times between the last three.
  [[nodiscard]] double overdue() const;

  /// Periods are counted from the last, 0; each is from an extremum to the next but one, and begins
  /// half a period before that counted before it. There are extrema_count() - 2 of an oscillation.
  [[nodiscard]] int periods_count() const { return std::max(0, extrema_count() - 2); }
  /// Mean of the two swings of a period.
  [[nodiscard]] double swing_of_period(int i) const { return 0.5 * (swing(i) + swing(i + 1)); }
  /// When the i-th period from the last began.
  [[nodiscard]] double period_began(int i) const { return dz_.time(point(i + 2).at); }
  /// Trends over the last n periods: of the swings' logarithms [nu/W^2], of dz's midline [nu/W],
  /// and of a particle's mean lateral position [nu/W].
  [[nodiscard]] Trend growth(int n) const;
  [[nodiscard]] Trend midline(int n) const;
  /// Change of dz's midline between the i-th period from the last and the one before.
  [[nodiscard]] double midline_change(int i) const { return std::abs(middle(i) - middle(i + 1)); }
  [[nodiscard]] Trend lateral(int n, std::size_t body) const;

 private:
  [[nodiscard]] double middle(int i) const {
    return (point(i).value + 2 * point(i + 1).value + point(i + 2).value) / 4;
  }
  [[nodiscard]] const Extremum& point(int i) const {
    return points_[points_.size() - 1 - static_cast<std::size_t>(i)];
  }
  [[nodiscard]] double duration(std::size_t from, std::size_t to) const {
    return dz_.time(to) - dz_.time(from);
  }
  template <class Value>
  [[nodiscard]] Trend trend(int n, double noise, Value value) const;

  const UniformSeries& dz_;
  const std::array<UniformSeries, 2>& x_;
  std::size_t now_;
  std::vector<Extremum> points_;  // the start, and the extrema
  std::vector<double> swings_;    // swings_[i] from points_[i] to points_[i + 1]
};

}  // namespace ductile::drivers
