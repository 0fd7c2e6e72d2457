#include "analysis/series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace ductile::drivers {

void UniformSeries::add(double time, double value) {
  if (!std::isfinite(time) || !std::isfinite(value) || (!values_.empty() && !(time > last_time_))) {
    throw std::invalid_argument(
        fmt::format("sample {} at t = {} after t = {}: numbers must be finite and time increase",
                    value, time, last_time_));
  }
  if (values_.empty()) {
    start_ = time;
    values_.push_back(value);
  } else {
    const double slope = (value - last_value_) / (time - last_time_);
    // A sample meant for a grid point may miss it by round-off.
    constexpr double slack = 1e-9 * step;
    while (this->time(size()) <= time + slack) {
      values_.push_back(last_value_ + slope * (this->time(size()) - last_time_));
    }
  }
  last_time_ = time;
  last_value_ = value;
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
  double sum = 0;
  double weights = 0;
  for (std::size_t i = 0; i <= n; ++i) {
    const double phase = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
    const double weight = 1 - std::cos(phase);
    sum += weight * values_[last - n + i];
    weights += weight;
  }
  return sum / weights;
}

std::optional<Outlook> outlook(const UniformSeries& series, std::size_t last,
                               const Settling& settling) {
  if (last >= series.size() || last < UniformSeries::steps(settling.span())) return std::nullopt;
  const std::size_t shift = UniformSeries::steps(settling.shift);
  const double m0 = series.smooth_mean(last, settling.window);
  const double m1 = series.smooth_mean(last - shift, settling.window);
  const double m2 = series.smooth_mean(last - 2 * shift, settling.window);
  const double change = m0 - m1;
  const double before = m1 - m2;
  const double unit = settling.relative ? std::max(std::abs(m0), settling.floor) : 1.0;

  Outlook out;
  out.level = m0;
  out.limit = m0;
  out.rate = change / settling.shift;
  if (std::abs(change) <= settling.rest * unit && std::abs(before) <= 2 * settling.rest * unit) {
    out.state = Outlook::State::resting;
    out.settled = true;
  } else if (before != 0 && change / before > 0 && change / before <= dying_ratio) {
    const double q = change / before;
    out.state = Outlook::State::dying;
    out.limit = m0 + change * q / (1 - q);
    // m0 is centred half a window before the present.
    out.remaining = (out.limit - m0) * std::pow(q, 0.5 * settling.window / settling.shift);
    out.settled = std::abs(out.remaining) <= settling.remaining * unit;
  }
  return out;
}

}  // namespace ductile::drivers
