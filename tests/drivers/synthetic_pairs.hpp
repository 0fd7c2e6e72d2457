// Synthetic histories of a pair, of every kind that the judge must tell apart, drawn at random.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string_view>
#include <vector>

#include "analysis/verdict.hpp"

namespace ductile::drivers {

/// What a history does in the end; in brackets the right verdict.
enum class Kind {
  rests,       ///< comes to rest within a few units, perhaps with modulations (stable)
  overshoots,  ///< once, then falls slowly (stable)
  approaches,  ///< its limit slowly, exponentially or by a power of time (stable)
  decays,      ///< an oscillation that dies out (damped; stable where it is too small)
  lasts,       ///< an oscillation that goes on (bounded)
  wobbles,     ///< the same with swings that differ (bounded)
  parts,       ///< dz reaches 10 (unstable)
  grows,       ///< without end, in one of many ways (unstable)
  shrinks,     ///< without end (unstable, once the particles have passed each other)
  wanders,     ///< an oscillation that grows, or whose mean drifts (unstable)
  leaves,      ///< rests for 30 to 45 units, then grows or shrinks without end (unstable)
  migrates     ///< dz rests, x does not (none)
};
inline constexpr std::array<std::string_view, 12> kind_names{
    "rests", "overshoots", "approaches", "decays",  "lasts",  "wobbles",
    "parts", "grows",      "shrinks",    "wanders", "leaves", "migrates"};

/// Uniform random numbers that are the same with every standard library.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11U) * 0x1p-53;
  }
  double log_uniform(double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  }
  double sign() { return uniform(0, 1) < 0.5 ? -1 : 1; }
  /// Of either sign. Calls of dice in one expression would be drawn in an order of the compiler's.
  double signed_uniform(double low, double high) {
    const double side = sign();
    return side * uniform(low, high);
  }
  int below(int n) { return static_cast<int>(uniform(0, n)); }

 private:
  std::mt19937_64 engine_;
};

/// amplitude sin(2 pi t/period + phase)
struct Wave {
  double amplitude = 0;
  double period = 1;
  double phase = 0;
  [[nodiscard]] double operator()(double t) const {
    return amplitude * std::sin(2 * std::numbers::pi * t / period + phase);
  }
  static Wave random(Dice& dice, double amplitude, double shortest, double longest) {
    return {amplitude, dice.log_uniform(shortest, longest), dice.uniform(0, 2 * std::numbers::pi)};
  }
};

/// scale exp(-t/time), or scale (1 + t/time)^-power
struct Decay {
  double scale = 0;
  double time = 1;
  double power = 0;
  [[nodiscard]] double operator()(double t) const {
    if (scale == 0) return 0;
    return scale * (power == 0 ? std::exp(-t / time) : std::pow(1 + t / time, -power));
  }
};

/// Motion without end, from `onset` on.
struct Drift {
  enum class Law { none, linear, quadratic, exponential, root, logarithm };
  Law law = Law::none;
  double onset = 0;
  double scale = 0;
  double time = 1;
  [[nodiscard]] double operator()(double t) const {
    const double s = t - onset;
    if (law == Law::none || s <= 0) return 0;
    switch (law) {
      case Law::linear:
        return scale * s;
      case Law::quadratic:
        return scale * s * s;
      case Law::exponential:
        return scale * std::expm1(s / time);
      case Law::root:
        return scale * (std::sqrt(s + time) - std::sqrt(time));
      default:
        return scale * std::log1p(s / time);
    }
  }
};

struct SyntheticPair {
  Kind kind = Kind::rests;
  double limit = 1;             ///< of dz without drift
  std::array<Decay, 2> decays;  ///< of dz towards the limit
  Wave oscillation;             ///< of dz, times its envelope and its beat
  Decay envelope{1, 1e9};
  Wave beat;
  Drift drift;                ///< of dz
  std::array<Wave, 4> noise;  ///< of dz: modulation, and the lattice's noise
  std::array<double, 2> x_limit{};
  std::array<Decay, 2> x_decay;
  std::array<double, 2> x_rate{};
  std::array<Wave, 2> x_wave;
  double interval = 0.05;
  double end = 100;
  bool clean = false;  ///< little noise

  /// Without modulation and noise.
  [[nodiscard]] double smooth(double t) const {
    double value = limit + decays[0](t) + decays[1](t) + drift(t);
    if (oscillation.amplitude != 0) value += oscillation(t) * envelope(t) * (1 + beat(t));
    return value;
  }
  [[nodiscard]] double dz(double t) const {
    double value = smooth(t);
    for (const Wave& wave : noise) {
      if (wave.amplitude != 0) value += wave(t);
    }
    return value;
  }
  [[nodiscard]] double x(std::size_t body, double t) const {
    return x_limit[body] + x_decay[body](t) + x_rate[body] * t + x_wave[body](t);
  }
};

inline Drift random_drift(Dice& dice, double onset, double sign) {
  using enum Drift::Law;
  Drift drift;
  drift.onset = onset;
  switch (drift.law = std::array{linear, quadratic, exponential, root,
                                 logarithm}[static_cast<std::size_t>(dice.below(5))]) {
    case linear:
      drift.scale = dice.log_uniform(0.01, 0.2);
      break;
    case quadratic:
      drift.scale = dice.log_uniform(0.0005, 0.03);
      break;
    case exponential:
      drift.scale = dice.log_uniform(0.05, 0.3);
      drift.time = dice.uniform(8, 30);
      break;
    case root:
      drift.scale = dice.log_uniform(0.15, 1);
      drift.time = dice.uniform(1, 10);
      break;
    default:
      drift.scale = dice.log_uniform(0.6, 2);
      drift.time = dice.uniform(3, 10);
  }
  drift.scale *= sign;
  return drift;
}

/// A pair of that kind that rests: its limits, approach, noise and sampling.
inline SyntheticPair random_background(Kind kind, Dice& dice) {
  SyntheticPair p;
  p.kind = kind;
  p.interval = dice.log_uniform(0.05, 2);
  p.end = dice.uniform(60, 160);
  p.limit = dice.uniform(0.7, 4);
  p.clean = dice.uniform(0, 1) < 0.5;
  const double noise = p.clean ? 0.003 : 0.02;
  // A quarter of the noisy ones are modulated as the paper's B2 and B4.
  if (!p.clean && dice.below(4) == 0) {
    p.noise[0] = Wave::random(dice, dice.uniform(0.02, 0.07), 4, 12);
  }
  for (std::size_t i = 1; i < p.noise.size(); ++i) {
    p.noise[i] = Wave::random(dice, dice.uniform(0, noise / 2), 0.8, 13);
  }
  for (std::size_t body = 0; body < 2; ++body) {
    p.x_limit[body] = dice.uniform(-0.35, 0.35);
    p.x_decay[body] = {dice.uniform(-0.3, 0.3), dice.uniform(5, 15)};
    p.x_wave[body] = Wave::random(dice, dice.uniform(0, p.clean ? 0.003 : 0.02), 4, 12);
  }
  p.decays[0] = {dice.uniform(-0.8, 0.8), dice.uniform(2, 12)};
  return p;
}

inline SyntheticPair random_pair(Kind kind, Dice& dice) {
  SyntheticPair p = random_background(kind, dice);
  switch (kind) {
    case Kind::rests:
      break;
    case Kind::overshoots:
      p.decays[0] = {dice.uniform(0.2, 0.8), dice.uniform(15, 40)};
      p.decays[1] = {-dice.uniform(1, 2), dice.uniform(2, 6)};
      break;
    case Kind::approaches:
      p.decays[0] = {dice.signed_uniform(0.4, 4), dice.uniform(15, 40)};
      if (dice.below(4) == 0) {
        p.decays[0] = {dice.signed_uniform(0.4, 2), dice.uniform(5, 20), dice.uniform(0.5, 3)};
      }
      p.limit = std::max(p.limit, 0.7 - p.decays[0].scale);
      break;
    case Kind::decays:
      p.oscillation = Wave::random(dice, dice.uniform(0.3, 1.5), 6, 15);
      p.envelope = {1, dice.uniform(8, 60)};
      p.limit = std::max(p.limit, p.oscillation.amplitude);
      break;
    case Kind::lasts:
    case Kind::wobbles:
      p.oscillation = Wave::random(dice, dice.uniform(0.17, 1), 6, 15);
      if (kind == Kind::wobbles) p.beat = Wave::random(dice, dice.uniform(0.05, 0.25), 15, 40);
      break;
    case Kind::parts:
      p.drift = {Drift::Law::quadratic, dice.uniform(0, 35), dice.log_uniform(0.01, 0.2), 1};
      if (dice.below(2) == 0) {
        p.drift = {Drift::Law::linear, dice.uniform(0, 20), dice.uniform(0.3, 1), 1};
      }
      p.drift.scale *= dice.below(5) == 0 ? -1 : 1;
      break;
    case Kind::grows:
      p.drift = random_drift(dice, dice.uniform(0, 35), 1);
      break;
    case Kind::shrinks:
      p.limit = dice.uniform(2, 6);
      p.drift = random_drift(dice, dice.uniform(0, 35), -1);
      break;
    case Kind::wanders:
      p.oscillation = Wave::random(dice, dice.uniform(0.1, 1), 6, 15);
      if (dice.below(3) == 0) {
        p.envelope = {dice.uniform(0.3, 1), -dice.uniform(15, 60)};
      } else {
        if (dice.below(2) == 0) p.envelope = {1, dice.uniform(8, 60)};
        const double onset = dice.uniform(0, 35);
        p.drift = random_drift(dice, onset, dice.sign());
        p.limit = dice.uniform(2, 5);
      }
      break;
    case Kind::migrates:
      p.x_rate[static_cast<std::size_t>(dice.below(2))] = dice.signed_uniform(0.003, 0.006);
      break;
    case Kind::leaves: {
      const double onset = dice.uniform(30, 45);
      p.drift = random_drift(dice, onset, dice.sign());
      p.limit = dice.uniform(1, 5);
      break;
    }
  }
  return p;
}

/// By how much dz has left, by time t, what would be a fixed place or an oscillation that lasts.
inline double departure(const SyntheticPair& p, double t) {
  const double swing = p.envelope.time < 0 ? 2 * p.oscillation.amplitude * p.envelope(t) : 0;
  return std::abs(p.drift(t)) + swing;
}

/// Swings of at least `least` in the smooth part of dz, not counting the first, from the start.
inline int count_swings(const SyntheticPair& p, double least) {
  int count = -1;
  double low = p.smooth(0);
  double high = low;
  int direction = 0;
  for (int i = 0; i < 4000; ++i) {
    const double value = p.smooth(0.05 * i);
    low = std::min(low, value);
    high = std::max(high, value);
    if (direction >= 0 && high - value >= least) {
      direction = -1;
      low = value;
      ++count;
    } else if (direction <= 0 && value - low >= least) {
      direction = 1;
      high = value;
      ++count;
    }
  }
  return std::max(0, count - 1);  // the leg under way at the end is no swing
}

/// Verdicts that are right at time t, apart from `undecided`, which always is. Before it has left
/// its place by a pronounced swing, dz may be called what it has been until then.
inline std::vector<PairClass> right_verdicts(const SyntheticPair& p, double t) {
  using enum PairClass;
  switch (p.kind) {
    case Kind::rests:
    case Kind::overshoots:
    case Kind::approaches:
      return {stable};
    case Kind::decays:
      // What is neither clearly above nor clearly below what makes a damped pair may be either.
      if (count_swings(p, 1.6 * rules::pronounced) >= rules::damped_extrema - 1) return {damped};
      if (count_swings(p, 0.6 * rules::reversal) < rules::damped_extrema - 1) return {stable};
      return {damped, stable};
    case Kind::lasts:
    case Kind::wobbles:
      return {bounded};
    case Kind::parts:
    case Kind::grows:
    case Kind::wanders:
    case Kind::leaves:
      if (departure(p, t) < rules::pronounced) return {unstable, stable, damped, bounded};
      return {unstable};
    case Kind::shrinks:
      if (departure(p, t) < rules::pronounced) return {stable};
      return p.smooth(t) < 0 ? std::vector{unstable} : std::vector<PairClass>{};
    case Kind::migrates:
      break;
  }
  return {};
}

}  // namespace ductile::drivers
