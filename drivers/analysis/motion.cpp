#include "analysis/motion.hpp"

#include <algorithm>
#include <cmath>

namespace ductile::drivers {

namespace {

/// The start of the series followed by its extrema.
std::vector<Extremum> extrema(const UniformSeries& dz, std::size_t now, double reversal) {
  std::size_t low = 0;
  std::size_t high = 0;
  int direction = 0;  // of the leg under way: up, down, or none yet
  std::vector<Extremum> points;
  for (std::size_t i = 0; i <= now; ++i) {
    if (dz[i] > dz[high]) high = i;
    if (dz[i] < dz[low]) low = i;
    if (direction >= 0 && dz[high] - dz[i] >= reversal) {
      points.push_back({direction == 0 ? 0 : high, dz[direction == 0 ? 0 : high]});
      direction = -1;
      low = i;
    } else if (direction <= 0 && dz[i] - dz[low] >= reversal) {
      points.push_back({direction == 0 ? 0 : low, dz[direction == 0 ? 0 : low]});
      direction = 1;
      high = i;
    }
  }
  return points;
}

}  // namespace

Motion::Motion(const UniformSeries& dz, const std::array<UniformSeries, 2>& x, std::size_t now,
               double reversal)
    : dz_(dz), x_(x), now_(now), points_(extrema(dz, now, reversal)) {
  for (std::size_t i = 1; i < points_.size(); ++i) {
    swings_.push_back(std::abs(points_[i].value - points_[i - 1].value));
  }
}

double Motion::largest_swing() const {
  return swings_.size() < 2 ? 0 : *std::max_element(swings_.begin() + 1, swings_.end());
}

int Motion::swings_above(double size) const {
  if (swings_.empty()) return 0;
  return static_cast<int>(std::count_if(swings_.begin() + 1, swings_.end(),
                                        [size](double swing) { return swing >= size; }));
}

double Motion::time_since_swing(double size) const {
  for (std::size_t i = swings_.size(); i-- > 0;) {
    if (swings_[i] >= size) return duration(points_[i + 1].at, now_);
  }
  return elapsed();
}

double Motion::longest_swing(double size) const {
  double longest = 0;
  for (std::size_t i = 0; i < swings_.size(); ++i) {
    if (swings_[i] >= size) longest = std::max(longest, duration(points_[i].at, points_[i + 1].at));
  }
  return longest;
}

double Motion::overdue() const {
  const double longer =
      std::max(duration(point(1).at, point(0).at), duration(point(2).at, point(1).at));
  return duration(point(0).at, now_) / longer;
}

/// Least squares through `value` of the last n periods, each known to `noise` at best. Periods
/// overlap by half, so that the residuals of n stand for those of n/2.
template <class Value>
Trend Motion::trend(int n, double noise, Value value) const {
  double t_mean = 0;
  double v_mean = 0;
  for (int i = 0; i < n; ++i) {
    t_mean += dz_.time(point(i + 1).at) / n;
    v_mean += value(i) / n;
  }
  double tt = 0;
  double tv = 0;
  double vv = 0;
  for (int i = 0; i < n; ++i) {
    const double t = dz_.time(point(i + 1).at) - t_mean;
    const double v = value(i) - v_mean;
    tt += t * t;
    tv += t * v;
    vv += v * v;
  }
  const double slope = tv / tt;
  const double variance = std::max(0.0, vv - slope * tv) / std::max(1, n - 2);
  return {slope, 2 * std::sqrt(2 * std::max(variance, noise * noise) / tt)};
}

Trend Motion::growth(int n) const {
  double mean = 0;
  for (int i = 0; i < n; ++i) mean += swing_of_period(i) / n;
  return trend(n, extremum_error / mean, [this](int i) { return std::log(swing_of_period(i)); });
}

Trend Motion::midline(int n) const {
  return trend(n, extremum_error / 2, [this](int i) { return middle(i); });
}

Trend Motion::lateral(int n, std::size_t body) const {
  return trend(n, 0, [this, body](int i) { return x_[body].mean(point(i + 2).at, point(i).at); });
}

}  // namespace ductile::drivers
