// How a run ended: the class of a pair after the paper's Fig. 3, and whether a single body and a
// capsule's strain energy have settled. The rules are explained in doc/verdict.md.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "analysis/series.hpp"
#include "ductile/suspension/sample.hpp"

namespace ductile::drivers {

/// Every number that the rules use; lengths in W, times in W^2/nu.
namespace rules {

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// No pair is called anything but unstable before; the paper's unstable ones show it by 35.
constexpr double minimum_time = 40;
/// From then on the rules look at the pair once in this time.
constexpr double look_interval = 1;
/// Samples further apart than this show too little of a swing.
constexpr double longest_sampling = 2;

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

/// dz: means over two of the oscillation periods met (8 to 14), or three; less than 0.003 per unit
/// of time is rest (10 W would take 3000); a quarter of the initial distance may still be to come;
/// a limit is known to one and a half of a particle's radius, or where it is approached to a little
/// less, since a drift that slows down looks like an approach.
constexpr Settling distance{.window = 20,
                            .long_window = 30,
                            .shift = 10,
                            .rest = 0.03,
                            .remaining = 0.25,
                            .error = 0.6,
                            .dying_error = 0.52,
                            .departure = 0.01};
/// x: as dz; a third of the drift is rest, and a twentieth of W may still be to come (migration
/// takes e-folding times of 12 to 15).
constexpr Settling lateral{.window = 20,
                           .long_window = 30,
                           .shift = 10,
                           .rest = 0.01,
                           .remaining = 0.05,
                           .error = unlimited,
                           .dying_error = unlimited,
                           .departure = 0.01};
/// E_s: 5% in 5 units of time is rest, 10% may be to come. Strain that the kernel cannot see grows
/// several-fold in that time. The floor is 1% of a capsule of La = 100 at its place off the centre.
constexpr Settling strain{.window = 10,
                          .long_window = 0,
                          .shift = 5,
                          .rest = 0.05,
                          .remaining = 0.10,
                          .error = unlimited,
                          .dying_error = unlimited,
                          .departure = unlimited,
                          .relative = true,
                          .floor = 2e-5};

/// An oscillation decays or lasts if its swings have an e-folding time certainly below, or
/// certainly above, this one: that of a drift which keeps 0.9 (`dying_ratio`) of its speed in 10.
constexpr double lasting_time = 100;
/// Damped: seen over so many periods, which overlap by half: five extrema ...
constexpr int damped_periods = 3;
/// ... with the last swing under this fraction of the largest.
constexpr double damped_fraction = 0.5;
/// Extrema (the start is none) that make a pair which has settled a damped one ...
constexpr int damped_extrema = 3;
/// ... if the swings between them are at least this multiple of the range that dz still has.
constexpr double damped_contrast = 2;
/// Bounded: seen over at least so many periods, which overlap by half: six extrema ...
constexpr int lasting_periods = 4;
/// ... and all those in this latest part of the time.
constexpr double lasting_part = 2.0 / 3;
/// The midline of dz may move, in the last period of a decaying oscillation, by at most this
/// fraction of the last swing and at this rate [nu/W], since it settles along with the swings ...
constexpr double midline_fraction = 0.35;
constexpr double settling_midline = 0.0075;
/// ... and at this rate for certain in one that lasts.
constexpr double lasting_midline = 0.005;
/// The same for x, in either [nu/W].
constexpr double lateral_drift = 0.003;

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
  /// Of dz, where it comes to rest, or is on a course that does.
  std::optional<Outlook> distance{};
  [[nodiscard]] bool decided() const { return pair_class != PairClass::undecided; }
};

/// Watches a pair and decides its class as soon as the rules allow; the decision is then final.
class PairJudge {
 public:
  /// `stop_distance` [W]: |dz| at which the pair has parted (the paper's 10, close to its
  /// channel's length). Throws std::invalid_argument unless positive.
  explicit PairJudge(double stop_distance = 10);

  /// Takes the next sample. Cheap: the rules are looked at once in `rules::look_interval`, at times
  /// that do not depend on the samples', each when two more samples have come.
  /// Throws std::invalid_argument if time does not increase, or a number is not finite.
  void update(double time, double dz, double x_lead, double x_lag);
  /// The same from a sample of two bodies, the leading one first.
  void update(const suspension::Sample& sample);

  /// The verdict so far: at the end of the run, the verdict.
  [[nodiscard]] const Verdict& verdict() const { return verdict_; }
  /// Whether |dz| has come to the stop distance from below. A pair that starts beyond it, as two
  /// that are to pass each other in a short channel, parts where |dz| has grown by
  /// `rules::pronounced`. Independent of what has been decided before.
  [[nodiscard]] bool parted() const { return parted_; }

 private:
  double stop_distance_;
  UniformSeries dz_;
  std::array<UniformSeries, 2> x_;
  double last_time_ = 0;
  double nearest_ = 0;  // |dz| so far
  bool parted_ = false;
  bool sparse_ = false;  // samples too far apart have come
  std::size_t next_look_;
  Verdict verdict_{PairClass::undecided, 0, "no data"};
};

/// What the rules say of a pair's history up to grid point `now`, |dz| < stop_distance throughout:
/// the judge's opinion at one look, without its memory.
Verdict judge(const UniformSeries& dz, const std::array<UniformSeries, 2>& x, std::size_t now,
              double stop_distance);

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
