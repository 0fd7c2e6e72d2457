// How a run ended: the class of a pair after the paper's Fig. 3, and whether a single body and a
// capsule's strain energy have settled. The rules are explained in doc/verdict.md.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "analysis/series.hpp"
#include "ductile/suspension/sample.hpp"

namespace ductile::drivers {

/// Every number that the rules use; lengths in W, times in W^2/nu.
namespace rules {

/// The rules look at the pair once in this time.
constexpr double look_interval = 1;
/// Reversal of dz that makes an extremum. Well above the 0.02 by which a soft capsule wanders at
/// the centre of a coarse lattice, well below what one sees in the paper's plots.
constexpr double reversal = 0.1;
/// Swing between two extrema that counts as an oscillation of the pair: half a particle radius.
/// The paper calls pairs stable whose dz shows "modulations with small amplitudes" (B2) or
/// "fluctuates only little" (B4).
constexpr double pronounced = 0.2;
/// After its last pronounced swing dz must have been quiet for this long ...
constexpr double quiet_time = 20;
/// ... and for this multiple of the longest time between two extrema: by then an oscillation that
/// goes on would have turned.
constexpr double quiet_intervals = 1.5;
/// dz: means over two of the oscillation periods met (8 to 14); less than 0.002 per unit of time is
/// rest (10 W would take 5000); a quarter of the initial distance may still be to come.
constexpr Settling distance{20, 10, 0.02, 0.25, false, 0};
/// x: as dz; a twentieth of W may still be to come (migration takes e-folding times of 12 to 15).
constexpr Settling lateral{20, 10, 0.02, 0.05, false, 0};
/// E_s: 5% in 5 units of time is rest, 10% may be to come. Strain that the kernel cannot see grows
/// several-fold in that time. The floor is 1% of a capsule of La = 100 at its place off the centre.
constexpr Settling strain{10, 5, 0.05, 0.10, true, 2e-5};

/// Full periods compared, one by one, to tell a decaying from a lasting oscillation.
constexpr int periods = 3;
/// Damped: each swing under this fraction of the swing one period before ...
constexpr double damped_ratio = 0.8;
/// ... and the last one under this fraction of the largest.
constexpr double damped_fraction = 0.5;
/// Extrema (the start is none) that make a pair which has settled a damped one.
constexpr int damped_extrema = 3;
/// Bounded: each swing within this factor of that one period before ...
constexpr double lasting_factor = 1.1;
/// ... or, for an irregular (tumbling, wobbling) pair, the mean of this many swings within
/// `irregular_factor` of the mean of as many before.
constexpr int irregular_swings = 4;
constexpr double irregular_factor = 1.25;
/// Change of the mean over a period, as a fraction of the swing (dz) or in W (x), that an
/// oscillation about a fixed place may show.
constexpr double midline_fraction = 0.25;
constexpr double lateral_midline = 0.05;
/// No pair is called stable or bounded before; the paper's unstable ones show it by 35.
constexpr double minimum_time = 40;
/// Unstable before dz reaches the stop distance: dz grows by a shift's mean change of at least ...
constexpr double parting = 0.1;
/// ... that in each shift is at least this fraction of the one before: over three of them a drift
/// that does not die out.
constexpr double parting_ratio = 0.95;
constexpr double parting_time = distance.window + 3 * distance.shift;

}  // namespace rules

enum class PairClass { undecided, stable, damped, bounded, unstable };
std::string_view to_string(PairClass pair_class);

/// A class, the time at which it was found [W^2/nu], and a sentence that says why.
struct Verdict {
  PairClass pair_class = PairClass::undecided;
  double time = 0;
  std::string reason;
  [[nodiscard]] bool decided() const { return pair_class != PairClass::undecided; }
};

/// Watches a pair and decides its class as soon as the rules allow; the decision is then final.
class PairJudge {
 public:
  /// `stop_distance` [W]: |dz| at which the pair is unstable (the paper's 10, close to its
  /// channel's length). Throws std::invalid_argument unless positive.
  explicit PairJudge(double stop_distance = 10);

  /// Takes the next sample. Cheap: the rules are looked at once in `rules::look_interval`.
  /// Throws std::invalid_argument if time does not increase, or a number is not finite.
  void update(double time, double dz, double x_lead, double x_lag);
  /// The same from a sample of two bodies, the leading one first.
  void update(const suspension::Sample& sample);

  /// The verdict so far: at the end of the run, the verdict.
  [[nodiscard]] const Verdict& verdict() const { return verdict_; }

 private:
  double stop_distance_;
  UniformSeries dz_;
  std::array<UniformSeries, 2> x_;
  std::size_t next_look_ = 0;
  Verdict verdict_{PairClass::undecided, 0, "no data"};
};

/// What the rules say of a pair's whole history, |dz| < stop_distance throughout: the judge's
/// opinion at one look, without its memory.
Verdict judge(const UniformSeries& dz, const std::array<UniformSeries, 2>& x, double stop_distance);

/// Watches one quantity of one body (a lateral position, a strain energy).
class SettlingWatch {
 public:
  explicit SettlingWatch(const Settling& settling) : settling_(settling) {}
  /// Throws std::invalid_argument if time does not increase, or a number is not finite.
  void update(double time, double value) { series_.add(time, value); }
  /// The outlook at the last sample; nothing where the run is too short to tell.
  [[nodiscard]] std::optional<Outlook> outlook() const {
    if (series_.size() == 0) return std::nullopt;
    return drivers::outlook(series_, series_.size() - 1, settling_);
  }

 private:
  Settling settling_;
  UniformSeries series_;
};

}  // namespace ductile::drivers
