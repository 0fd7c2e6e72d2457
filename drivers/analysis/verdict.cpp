#include "analysis/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace ductile::drivers {

namespace {

/// An extremum of dz, at a grid point.
struct Extremum {
  std::size_t at;
  double value;
};

/// The start of the series followed by its extrema: turning points after which dz has gone back by
/// at least `reversal`.
std::vector<Extremum> extrema(const UniformSeries& dz, double reversal) {
  std::size_t low = 0;
  std::size_t high = 0;
  int direction = 0;  // of the leg under way: up, down, or none yet
  std::vector<Extremum> points;
  for (std::size_t i = 0; i < dz.size(); ++i) {
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

/// The pair's motion as the rules see it, at the last grid point.
class Motion {
 public:
  Motion(const UniformSeries& dz, const std::array<UniformSeries, 2>& x)
      : dz_(dz), x_(x), now_(dz.size() - 1), points_(extrema(dz, rules::reversal)) {
    for (std::size_t i = 1; i < points_.size(); ++i) {
      swings_.push_back(std::abs(points_[i].value - points_[i - 1].value));
    }
  }

  [[nodiscard]] double elapsed() const { return dz_.time(now_) - dz_.time(0); }
  /// Extrema, not counting the start.
  [[nodiscard]] int extrema_count() const { return static_cast<int>(swings_.size()); }
  /// Swing that ended in the i-th extremum from the last (0). The first extremum's, from the
  /// start, is none of an oscillation.
  [[nodiscard]] double swing(int i = 0) const {
    return swings_[swings_.size() - 1 - static_cast<std::size_t>(i)];
  }
  [[nodiscard]] double largest_swing() const {
    return swings_.size() < 2 ? 0 : *std::max_element(swings_.begin() + 1, swings_.end());
  }

  /// Range of dz over the last `duration`.
  [[nodiscard]] double range(double duration) const {
    double low = dz_[now_];
    double high = low;
    for (std::size_t i = now_ - UniformSeries::steps(duration); i <= now_; ++i) {
      low = std::min(low, dz_[i]);
      high = std::max(high, dz_[i]);
    }
    return high - low;
  }

  /// dz has stopped oscillating.
  [[nodiscard]] bool quiet() const {
    double longest = 0;
    std::size_t last = 0;
    for (std::size_t i = 0; i < swings_.size(); ++i) {
      if (swings_[i] < rules::pronounced) continue;
      last = points_[i + 1].at;
      longest = std::max(longest, duration(points_[i].at, last));
    }
    return last == 0 ||
           duration(last, now_) >= std::max(rules::quiet_time, rules::quiet_intervals * longest);
  }

  /// The oscillation goes on: the next extremum is not overdue.
  [[nodiscard]] bool oscillating() const {
    const std::size_t n = points_.size();
    return duration(points_[n - 1].at, now_) <=
           rules::quiet_intervals * std::max(duration(points_[n - 2].at, points_[n - 1].at),
                                             duration(points_[n - 3].at, points_[n - 2].at));
  }

  /// Over the last `swings` swings dz and x went about the same places as over those before.
  [[nodiscard]] bool midline_fixed(std::size_t swings) const {
    const std::size_t n = points_.size() - 1;
    const std::size_t a = points_[n - 2 * swings].at;
    const std::size_t b = points_[n - swings].at;
    const std::size_t c = points_[n].at;
    const auto change = [&](const UniformSeries& s) {
      return std::abs(s.mean(b, c) - s.mean(a, b));
    };
    return change(dz_) <= rules::midline_fraction * swing() &&
           change(x_[0]) <= rules::lateral_midline && change(x_[1]) <= rules::lateral_midline;
  }

 private:
  [[nodiscard]] double duration(std::size_t from, std::size_t to) const {
    return dz_.time(to) - dz_.time(from);
  }

  const UniformSeries& dz_;
  const std::array<UniformSeries, 2>& x_;
  std::size_t now_;
  std::vector<Extremum> points_;
  std::vector<double> swings_;  // swings_[i] from points_[i] to points_[i + 1]
};

/// Swings of an oscillation that `periods` comparisons over a full period (two swings) need.
constexpr int regular_swings = rules::periods + 2;

bool decays(const Motion& m) {
  if (m.extrema_count() < regular_swings + 1 || !m.oscillating()) return false;
  for (int i = 0; i < rules::periods; ++i) {
    if (m.swing(i) >= rules::damped_ratio * m.swing(i + 2)) return false;
  }
  return m.largest_swing() >= rules::pronounced &&
         m.swing() <= rules::damped_fraction * m.largest_swing() && m.midline_fixed(2);
}

bool lasts_regularly(const Motion& m) {
  if (m.extrema_count() < regular_swings + 1) return false;
  for (int i = 0; i < regular_swings; ++i) {
    if (m.swing(i) < rules::pronounced) return false;
  }
  for (int i = 0; i < rules::periods; ++i) {
    const double ratio = m.swing(i) / m.swing(i + 2);
    if (ratio > rules::lasting_factor || ratio * rules::lasting_factor < 1) return false;
  }
  return m.midline_fixed(2);
}

bool lasts_irregularly(const Motion& m) {
  constexpr int n = rules::irregular_swings;
  if (m.extrema_count() < 2 * n + 1) return false;
  double now = 0;
  double before = 0;
  for (int i = 0; i < n; ++i) {
    now += m.swing(i) / n;
    before += m.swing(n + i) / n;
  }
  return std::min(now, before) >= rules::pronounced && now <= rules::irregular_factor * before &&
         before <= rules::irregular_factor * now && m.midline_fixed(n);
}

bool lasts(const Motion& m) {
  return m.elapsed() >= rules::minimum_time && (lasts_regularly(m) || lasts_irregularly(m)) &&
         m.oscillating();
}

/// |dz| has grown at a steady rate over the last three shifts.
bool parts_steadily(const UniformSeries& dz) {
  const std::size_t last = dz.size() - 1;
  if (last < UniformSeries::steps(rules::parting_time)) return false;
  std::array<double, 4> level{};  // the latest first
  for (std::size_t i = 0; i < level.size(); ++i) {
    level[i] = dz.smooth_mean(last - i * UniformSeries::steps(rules::distance.shift),
                              rules::distance.window);
  }
  const double away = level[0] < 0 ? -1 : 1;
  std::array<double, 3> growth{};
  for (std::size_t i = 0; i < growth.size(); ++i) growth[i] = away * (level[i] - level[i + 1]);
  return std::all_of(growth.begin(), growth.end(), [](double g) { return g >= rules::parting; }) &&
         growth[0] >= rules::parting_ratio * growth[1] &&
         growth[1] >= rules::parting_ratio * growth[2];
}

/// "dz falls by 0.012 per unit of time, towards 1.95", or nothing where it has settled.
std::string unsettled(std::string_view what, const Outlook& o) {
  if (o.settled) return {};
  std::string text = fmt::format("{} {} by {:.3g} per unit of time", what,
                                 o.rate < 0 ? "falls" : "grows", std::abs(o.rate));
  if (o.state == Outlook::State::dying) text += fmt::format(", towards {:.3g}", o.limit);
  return text;
}

}  // namespace

std::string_view to_string(PairClass pair_class) {
  switch (pair_class) {
    case PairClass::stable:
      return "stable";
    case PairClass::damped:
      return "damped";
    case PairClass::bounded:
      return "bounded";
    case PairClass::unstable:
      return "unstable";
    case PairClass::undecided:
      break;
  }
  return "undecided";
}

Verdict judge(const UniformSeries& dz, const std::array<UniformSeries, 2>& x,
              double stop_distance) {
  const std::size_t now = dz.size() - 1;
  const Motion motion(dz, x);
  const double time = dz.time(now);
  const auto verdict = [time](PairClass c, std::string reason) {
    return Verdict{c, time, std::move(reason)};
  };
  const std::string swapped =
      dz[0] * dz[now] < 0 ? "; the lagging particle has passed the leading one" : "";

  if (decays(motion)) {
    return verdict(
        PairClass::damped,
        fmt::format("dz swings by {:.3g} at first and by {:.3g} after {} extrema, less "
                    "in every period{}",
                    motion.largest_swing(), motion.swing(), motion.extrema_count(), swapped));
  }
  if (lasts(motion)) {
    return verdict(PairClass::bounded,
                   fmt::format("dz goes on swinging by {:.3g} after {} extrema, about a fixed "
                               "place{}",
                               motion.swing(), motion.extrema_count(), swapped));
  }

  const auto distance = outlook(dz, now, rules::distance);
  const auto lead = outlook(x[0], now, rules::lateral);
  const auto lag = outlook(x[1], now, rules::lateral);
  if (!distance || !lead || !lag || motion.elapsed() < rules::minimum_time) {
    return verdict(PairClass::undecided,
                   fmt::format("{:.3g} units of time are too few to tell", motion.elapsed()));
  }
  const bool quiet = motion.quiet();
  const bool lateral_settled = lead->settled && lag->settled;
  if (quiet && lateral_settled && distance->settled && std::abs(distance->limit) < stop_distance) {
    const bool damped =
        motion.extrema_count() >= rules::damped_extrema &&
        motion.largest_swing() >= rules::pronounced &&
        motion.range(rules::quiet_time) <= rules::damped_fraction * motion.largest_swing();
    const std::string settles = distance->state == Outlook::State::dying
                                    ? fmt::format("dz approaches {:.3g}", distance->limit)
                                    : fmt::format("dz rests at {:.3g}", distance->level);
    return damped ? verdict(PairClass::damped, fmt::format("{} after {} extrema{}", settles,
                                                           motion.extrema_count(), swapped))
                  : verdict(PairClass::stable, settles + swapped);
  }
  if (quiet && lateral_settled && parts_steadily(dz)) {
    return verdict(PairClass::unstable,
                   fmt::format("|dz| grows steadily by {:.3g} per unit of time while both "
                               "particles keep their lateral places{}",
                               std::abs(distance->rate), swapped));
  }

  std::string reason;
  for (const auto& part :
       {quiet ? std::string() : fmt::format("dz swung by {:.3g} not long ago", motion.swing()),
        unsettled("dz", *distance), unsettled("x of the leading particle", *lead),
        unsettled("x of the lagging particle", *lag)}) {
    if (!part.empty()) reason += (reason.empty() ? "" : "; ") + part;
  }
  if (reason.empty()) reason = fmt::format("dz heads for {:.3g}", distance->limit);
  return verdict(PairClass::undecided, reason + swapped);
}

PairJudge::PairJudge(double stop_distance) : stop_distance_(stop_distance) {
  if (!(stop_distance > 0)) {
    throw std::invalid_argument(
        fmt::format("stop distance {}: it must be positive", stop_distance));
  }
}

void PairJudge::update(double time, double dz, double x_lead, double x_lag) {
  if (verdict_.decided()) return;
  dz_.add(time, dz);
  x_[0].add(time, x_lead);
  x_[1].add(time, x_lag);
  if (std::abs(dz) >= stop_distance_) {
    verdict_ = {
        PairClass::unstable, time,
        fmt::format("|dz| has reached {:.3g}{}", stop_distance_,
                    dz_[0] * dz < 0 ? "; the lagging particle has passed the leading one" : "")};
  } else if (dz_.size() > next_look_) {
    verdict_ = judge(dz_, x_, stop_distance_);
    next_look_ += UniformSeries::steps(rules::look_interval);
  }
}

void PairJudge::update(const suspension::Sample& sample) {
  if (sample.bodies.size() != 2) {
    throw std::invalid_argument(
        fmt::format("a pair has 2 bodies, the sample {}", sample.bodies.size()));
  }
  update(sample.time, suspension::axial_distance(sample), sample.bodies[0].position().x(),
         sample.bodies[1].position().x());
}

}  // namespace ductile::drivers
