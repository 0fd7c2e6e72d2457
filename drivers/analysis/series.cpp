#include "analysis/series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace ductile::drivers {

namespace {

/// A sample meant for a grid point may miss it by round-off.
constexpr double slack = 1e-9 * UniformSeries::step;

/// Hann's weights of n + 1 points; their sum is 1.
const std::vector<double>& hann(std::size_t n) {
  static std::map<std::size_t, std::vector<double>> known;
  std::vector<double>& weights = known[n];
  if (weights.empty()) {
    for (std::size_t i = 0; i <= n; ++i) {
      const double phase = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
      weights.push_back((1 - std::cos(phase)) / static_cast<double>(n));
    }
  }
  return weights;
}

/// By what factor Hann's mean of exp(-rate t) over `window` exceeds its value in the middle.
double hann_gain(double rate, double window) {
  const double a = 0.5 * rate * window;
  constexpr double pi2 = std::numbers::pi * std::numbers::pi;
  return a == 0 ? 1 : std::sinh(a) / a * pi2 / (a * a + pi2);
}

}  // namespace

void UniformSeries::add(double time, double value) {
  if (!std::isfinite(time) || !std::isfinite(value) ||
      (!knots_.empty() && !(time > knots_.back().time))) {
    throw std::invalid_argument(
        fmt::format("sample {} at t = {} after t = {}: numbers must be finite and time increase",
                    value, time, knots_.empty() ? 0 : knots_.back().time));
  }
  knots_.push_back({time, value, -1, 0});
  if (knots_.size() == 1) {
    start_ = time;
    values_.push_back(value);
    firm_ = 1;
    return;
  }
  eliminate();

  // Back from the last knot, whose curvature is that of the one before. The curvatures of a spline
  // forget what lies k knots away as 0.27^k: three intervals are filled anew, the first for good.
  const std::size_t last = knots_.size() - 1;
  const std::size_t first = last < 3 ? 0 : last - 3;
  std::array<double, 4> curvature{};
  if (last > 1) {
    curvature[last - first] = knots_[last - 1].right / (1 + knots_[last - 1].upper);
    for (std::size_t k = last; k-- > first;) {
      curvature[k - first] = knots_[k].right - knots_[k].upper * curvature[k + 1 - first];
    }
  }
  values_.resize(firm_);
  for (std::size_t k = first; k < last; ++k) {
    fill(knots_[k], knots_[k + 1], curvature[k - first], curvature[k + 1 - first]);
    if (k + 3 == last) firm_ = values_.size();
  }
}

/// Gives the last knot but one its row. The first knot's says that its curvature is the second's.
void UniformSeries::eliminate() {
  if (knots_.size() < 3) return;
  const Knot& a = knots_[knots_.size() - 3];
  Knot& b = knots_[knots_.size() - 2];
  const Knot& c = knots_.back();
  const double before = b.time - a.time;
  const double after = c.time - b.time;
  const double bend = (c.value - b.value) / after - (b.value - a.value) / before;
  const double diagonal = 2 * (before + after) - before * a.upper;
  b.upper = after / diagonal;
  b.right = (6 * bend - before * a.right) / diagonal;
}

/// Appends the grid points up to b.
void UniformSeries::fill(const Knot& a, const Knot& b, double curvature_a, double curvature_b) {
  const double h = b.time - a.time;
  while (time(size()) <= b.time + slack) {
    const double v = (time(size()) - a.time) / h;
    const double u = 1 - v;
    values_.push_back(u * a.value + v * b.value -
                      h * h / 6 * u * v * ((1 + u) * curvature_a + (1 + v) * curvature_b));
  }
}

std::size_t UniformSeries::steps(double duration) {
  return static_cast<std::size_t>(std::lround(duration / step));
}

double UniformSeries::mean(std::size_t first, std::size_t last) const {
  double sum = 0;
  for (std::size_t i = first; i <= last; ++i) sum += values_[i];
  return sum / static_cast<double>(last - first + 1);
}

double UniformSeries::smooth_mean(std::size_t last, double window) const {
  const std::size_t n = steps(window);
  const std::vector<double>& weights = hann(n);
  double sum = 0;
  for (std::size_t i = 0; i <= n; ++i) sum += weights[i] * values_[last - n + i];
  return sum;
}

namespace {

/// By how much means miss the course of the others: `m` are means at successive half shifts, the
/// latest first, of which every other gave the ratio of changes q and the limit. Where there is no
/// exponential through them, the course is a parabola.
double misfit(const std::array<double, 5>& m, double q, double limit) {
  std::array<double, 2> course{(3 * m[0] + 6 * m[2] - m[4]) / 8, (3 * m[4] + 6 * m[2] - m[0]) / 8};
  if (q > 0 && q < 1) {
    const double root = std::sqrt(q);
    course = {limit + (m[0] - limit) / root, limit + (m[0] - limit) / (root * q)};
  }
  return std::max(std::abs(m[1] - course[0]), std::abs(m[3] - course[1]));
}

/// Sets band and departure: of the values of the present window about the course.
void compare(Outlook& out, const UniformSeries& series, std::size_t last, double window,
             double shift) {
  const std::size_t n = UniformSeries::steps(window);
  const std::size_t recent = UniformSeries::steps(recent_part * window);
  const bool dying = out.state == Outlook::State::dying;
  const double amplitude = out.level - out.limit;  // of the smooth means; 0 for what rests
  const double decay = dying ? std::log(1 - out.rate * shift / amplitude) / shift : 0;
  const double scale = amplitude / hann_gain(decay, window);
  std::array<double, 2> low{};
  std::array<double, 2> high{};
  for (std::size_t i = 0; i <= n; ++i) {
    // Since the middle of the window.
    const double t = (static_cast<double>(i) - 0.5 * static_cast<double>(n)) * UniformSeries::step;
    const double course =
        dying ? out.limit + scale * std::exp(-decay * t) : out.level + out.rate * t;
    const double rest = series[last - n + i] - course;
    const std::size_t part = i <= n - recent ? 0 : 1;
    const bool starts = i == 0 || i == n - recent + 1;
    low[part] = starts ? rest : std::min(low[part], rest);
    high[part] = starts ? rest : std::max(high[part], rest);
  }
  out.band = high[0] - low[0];
  out.departure = std::max({0.0, high[1] - high[0], low[0] - low[1]});
}

/// The outlook by one window.
Outlook outlook_by(const UniformSeries& series, std::size_t last, const Settling& settling,
                   double window) {
  const std::size_t half_shift = UniformSeries::steps(settling.shift) / 2;
  std::array<double, 5> m{};
  for (std::size_t i = 0; i < m.size(); ++i) {
    m[i] = series.smooth_mean(last - i * half_shift, window);
  }
  const double change = m[0] - m[2];
  const double before = m[2] - m[4];
  const double unit = settling.relative ? std::max(std::abs(m[0]), settling.floor) : 1.0;
  const double q = before == 0 ? 0 : change / before;
  const double to_come = q > 0 && q < 1 ? change * q / (1 - q) : 0;  // after the window's middle

  Outlook out;
  out.misfit = misfit(m, q, m[0] + to_come);
  // Each of the means may be wrong by as much as those between.
  const double most_change = std::abs(change) + 2 * out.misfit;
  const double most_q = most_change / (std::abs(before) - 2 * out.misfit);
  out.level = m[0];
  out.limit = m[0];
  out.rate = change / settling.shift;
  if (std::abs(change) <= settling.rest * unit && std::abs(before) <= settling.rest * unit) {
    out.state = Outlook::State::resting;
    // Whatever still moves may die out as slowly as can be told from a drift that does not.
    out.error = most_change * dying_ratio / (1 - dying_ratio);
  } else if (q > 0 && most_q > 0 && most_q <= dying_ratio) {
    out.state = Outlook::State::dying;
    out.limit = m[0] + to_come;
    const double most = most_change * most_q / (1 - most_q);
    // An approach as slow as 1/t has up to thrice as much to come as the exponential. The error is
    // never less than the last change: a ratio made small by what came before it means little.
    out.error = std::max(most + std::abs(to_come), most_change);
    out.remaining = std::copysign(most, change) * std::pow(most_q, 0.5 * window / settling.shift);
  } else {
    return out;
  }
  compare(out, series, last, window, settling.shift);
  const double most_error =
      out.state == Outlook::State::dying ? settling.dying_error : settling.error;
  out.on_course = out.departure <= settling.departure * unit + departure_fraction * out.band;
  out.settled = out.on_course && std::abs(out.remaining) <= settling.remaining * unit &&
                out.error <= most_error * unit;
  return out;
}

}  // namespace

std::optional<Outlook> outlook(const UniformSeries& series, std::size_t last,
                               const Settling& settling) {
  if (last >= series.size() || last < UniformSeries::steps(settling.span())) return std::nullopt;
  const Outlook out = outlook_by(series, last, settling, settling.window);
  const double long_span = settling.span() - settling.window + settling.long_window;
  if (out.settled || settling.long_window == 0 || last < UniformSeries::steps(long_span)) {
    return out;
  }
  const Outlook other = outlook_by(series, last, settling, settling.long_window);
  return other.settled ? other : out;
}

}  // namespace ductile::drivers
