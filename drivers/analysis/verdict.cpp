#include "analysis/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/motion.hpp"

namespace ductile::drivers {

namespace {

/// Seen for long enough, over so many periods, and the next extremum is not overdue.
bool oscillates(const Motion& m, int periods) {
  return m.elapsed() >= rules::minimum_time && m.periods_count() >= periods &&
         m.overdue() <= rules::quiet_intervals;
}

/// Over the last n periods.
bool keeps_places(const Motion& m, int n) {
  return std::abs(m.lateral(n, 0).slope) <= rules::lateral_drift &&
         std::abs(m.lateral(n, 1).slope) <= rules::lateral_drift;
}

/// In the last half period the midline has moved no further than in the one before, and in both
/// little.
bool midline_settles(const Motion& m) {
  const double change = m.midline_change(0);
  const double before = m.midline_change(1);
  return change <= before + extremum_error &&
         change + before <= rules::midline_fraction * m.swing() &&
         std::abs(m.midline(3).slope) <= rules::settling_midline;
}

bool decays(const Motion& m) {
  constexpr int n = rules::damped_periods;
  if (!oscillates(m, n) || m.leg() >= m.swing()) return false;
  return m.largest_swing() >= rules::pronounced &&
         m.swing() <= rules::damped_fraction * m.largest_swing() &&
         m.growth(n).high() <= -1 / rules::lasting_time && midline_settles(m) && keeps_places(m, n);
}

bool lasts(const Motion& m) {
  if (!oscillates(m, rules::lasting_periods)) return false;
  const double from = m.start() + (1 - rules::lasting_part) * m.elapsed();
  int n = 0;
  while (n < m.periods_count() && m.period_began(n) >= from) {
    if (m.swing_of_period(n++) < rules::pronounced) return false;
  }
  return n >= rules::lasting_periods && m.growth(n).steepest() <= 1 / rules::lasting_time &&
         m.midline(n).steepest() <= rules::lasting_midline &&
         keeps_places(m, rules::lasting_periods);
}

/// Swings, pronounced or not, grow.
bool grows(const Motion& m) {
  return oscillates(m, rules::damped_periods) &&
         m.growth(m.periods_count()).low() >= 1 / rules::lasting_time;
}

/// dz has stopped oscillating.
bool quiet(const Motion& m) {
  const double wait =
      std::max(rules::quiet_time, rules::quiet_intervals * m.longest_swing(rules::pronounced));
  return m.time_since_swing(rules::pronounced) >= wait && !grows(m);
}

/// |dz| has grown at a steady rate over the last three shifts.
bool parts_steadily(const UniformSeries& dz, std::size_t now) {
  if (now < UniformSeries::steps(rules::parting_time)) return false;
  std::array<double, 4> level{};  // the latest first
  for (std::size_t i = 0; i < level.size(); ++i) {
    level[i] = dz.smooth_mean(now - i * UniformSeries::steps(rules::distance.shift),
                              rules::distance.window);
  }
  const double away = level[0] < 0 ? -1 : 1;
  std::array<double, 3> growth{};
  for (std::size_t i = 0; i < growth.size(); ++i) growth[i] = away * (level[i] - level[i + 1]);
  return std::all_of(growth.begin(), growth.end(), [](double g) { return g >= rules::parting; }) &&
         growth[0] >= rules::parting_ratio * growth[1] &&
         growth[1] >= rules::parting_ratio * growth[2];
}

/// "1.85 +- 0.41"
std::string limit(const Outlook& o) {
  return fmt::format("{:.3g} +- {:.2g}", o.limit, o.error);
}

/// "dz falls by 0.012 per unit of time, towards 1.95 +- 0.2"
std::string unsettled(std::string_view what, const Outlook& o) {
  if (o.state != Outlook::State::moving && !o.on_course) {
    return fmt::format("{} leaves its course", what);
  }
  if (o.state == Outlook::State::resting) return fmt::format("{} is at {}", what, limit(o));
  std::string text = fmt::format("{} {} by {:.3g} per unit of time", what,
                                 o.rate < 0 ? "falls" : "grows", std::abs(o.rate));
  if (o.state == Outlook::State::dying) text += ", towards " + limit(o);
  return text;
}

std::string too_short(double elapsed) {
  return fmt::format(
      "a verdict takes {:g} units of time and two samples more; there are {:.3g} "
      "so far",
      rules::minimum_time, elapsed);
}

/// What a pair was told by, at one look.
struct Look {
  const Motion& motion;
  bool quiet = false;
  Outlook distance, lead, lag;
};

/// The pair has come to rest, or is on its way there.
Verdict at_rest(const Look& look, double time) {
  const Motion& m = look.motion;
  const double clear = std::max(rules::reversal, rules::damped_contrast * look.distance.band);
  const bool damped =
      m.largest_swing() >= rules::pronounced && m.swings_above(clear) >= rules::damped_extrema - 1;
  std::string reason = fmt::format(
      "dz {} {}", look.distance.state == Outlook::State::dying ? "approaches" : "rests at",
      limit(look.distance));
  if (damped) reason += fmt::format(" after {} extrema", m.extrema_count());
  return {damped ? PairClass::damped : PairClass::stable, time, std::move(reason), look.distance};
}

/// Why nothing can be said.
std::string open_points(const Look& look) {
  std::string reason;
  const auto add = [&reason](const std::string& part) {
    reason += (reason.empty() ? "" : "; ") + part;
  };
  if (!look.quiet) {
    add(look.motion.extrema_count() == 0
            ? "dz swings"
            : fmt::format("dz swung by {:.3g} not long ago", look.motion.swing()));
  }
  if (!look.distance.settled) add(unsettled("dz", look.distance));
  if (!look.lead.settled) add(unsettled("x of the leading particle", look.lead));
  if (!look.lag.settled) add(unsettled("x of the lagging particle", look.lag));
  return reason.empty() ? "dz heads for " + limit(look.distance) : reason;
}

Verdict look_at(const UniformSeries& dz, const std::array<UniformSeries, 2>& x, std::size_t now,
                double stop_distance) {
  const Motion motion(dz, x, now, rules::reversal);
  const double time = dz.time(now);
  if (decays(motion)) {
    return {PairClass::damped, time,
            fmt::format("dz swings by {:.3g} at first and by {:.3g} after {} extrema, dying out",
                        motion.largest_swing(), motion.swing(), motion.extrema_count())};
  }
  if (lasts(motion)) {
    return {PairClass::bounded, time,
            fmt::format("dz goes on swinging by {:.3g} after {} extrema, about a fixed place",
                        motion.swing(), motion.extrema_count())};
  }
  const auto distance = outlook(dz, now, rules::distance);
  const auto lead = outlook(x[0], now, rules::lateral);
  const auto lag = outlook(x[1], now, rules::lateral);
  if (!distance || !lead || !lag || motion.elapsed() < rules::minimum_time) {
    return {PairClass::undecided, time, too_short(motion.elapsed())};
  }
  const Look look{motion, quiet(motion), *distance, *lead, *lag};
  const bool in_place = look.quiet && lead->settled && lag->settled;
  if (in_place && distance->settled && std::abs(distance->limit) < stop_distance) {
    return at_rest(look, time);
  }
  if (in_place && parts_steadily(dz, now)) {
    return {PairClass::unstable, time,
            fmt::format("|dz| grows steadily by {:.3g} per unit of time while both particles keep "
                        "their lateral places",
                        std::abs(distance->rate))};
  }
  const bool heads = distance->state != Outlook::State::moving && distance->on_course;
  return {PairClass::undecided, time, open_points(look), heads ? distance : std::nullopt};
}

std::string if_passed(double first, double now) {
  return first * now < 0 ? "; the lagging particle has passed the leading one" : "";
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

Verdict judge(const UniformSeries& dz, const std::array<UniformSeries, 2>& x, std::size_t now,
              double stop_distance) {
  Verdict verdict = look_at(dz, x, now, stop_distance);
  verdict.reason += if_passed(dz[0], dz[now]);
  return verdict;
}

PairJudge::PairJudge(double stop_distance)
    : stop_distance_(stop_distance), next_look_(UniformSeries::steps(rules::minimum_time)) {
  if (!(stop_distance > 0)) {
    throw std::invalid_argument(
        fmt::format("stop distance {}: it must be positive", stop_distance));
  }
}

void PairJudge::update(double time, double dz, double x_lead, double x_lag) {
  const bool first = dz_.size() == 0;
  dz_.add(time, dz);
  x_[0].add(time, x_lead);
  x_[1].add(time, x_lag);
  // Rows that fall on whole time steps miss an interval by one of them.
  constexpr double rounding = 1.05;
  sparse_ = sparse_ || (!first && time - last_time_ > rounding * rules::longest_sampling);
  last_time_ = time;

  // A pair that starts beyond the stop distance has parted when it is further apart than it began.
  nearest_ = first ? std::abs(dz) : std::min(nearest_, std::abs(dz));
  const double far = nearest_ < stop_distance_ ? stop_distance_ : nearest_ + rules::pronounced;
  parted_ = parted_ || (!first && std::abs(dz) >= far);
  if (verdict_.decided()) return;
  if (parted_) {
    verdict_ = {PairClass::unstable, time,
                fmt::format("|dz| has reached {:.3g}", far) + if_passed(dz_[0], dz)};
  } else if (sparse_) {
    verdict_ = {PairClass::undecided, time,
                fmt::format("samples are further apart than {:g} units of time, which hides swings "
                            "of dz",
                            rules::longest_sampling)};
  } else if (next_look_ >= dz_.firm()) {
    if (next_look_ == UniformSeries::steps(rules::minimum_time)) {
      verdict_ = {PairClass::undecided, time, too_short(time - dz_.time(0))};
    }
  } else {
    for (; next_look_ < dz_.firm() && !verdict_.decided();
         next_look_ += UniformSeries::steps(rules::look_interval)) {
      verdict_ = judge(dz_, x_, next_look_, stop_distance_);
    }
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
