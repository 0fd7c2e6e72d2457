// Where a slowly varying quantity is heading.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace ductile::drivers {

/// A quantity against time, resampled by a cubic spline onto a uniform grid that starts with the
/// first sample: what is concluded from it does not depend on how often the run was sampled.
class UniformSeries {
 public:
  static constexpr double step = 0.1;  ///< of the grid [W^2/nu]; bodies move on scales of 1 and up

  /// Throws std::invalid_argument unless time increases and both numbers are finite.
  void add(double time, double value);

  [[nodiscard]] std::size_t size() const { return values_.size(); }
  /// So many of the values are final: those up to the last sample but two. Later samples still bend
  /// the spline beyond.
  [[nodiscard]] std::size_t firm() const { return firm_; }
  [[nodiscard]] double operator[](std::size_t i) const { return values_[i]; }
  [[nodiscard]] double time(std::size_t i) const { return start_ + static_cast<double>(i) * step; }
  /// Number of grid steps in `duration`.
  static std::size_t steps(double duration);

  /// Mean over [first, last], both included.
  [[nodiscard]] double mean(std::size_t first, std::size_t last) const;
  /// Mean over the `window` that ends at `last`, weighted by a raised cosine (Hann): a plain mean
  /// would carry a fraction of every oscillation whose period does not divide the window.
  [[nodiscard]] double smooth_mean(std::size_t last, double window) const;

 private:
  /// A sample, and its row of the spline's tridiagonal system after elimination:
  /// curvature + upper * (the next knot's curvature) = right.
  struct Knot {
    double time;
    double value;
    double upper;
    double right;
  };
  void eliminate();
  void fill(const Knot& a, const Knot& b, double curvature_a, double curvature_b);

  double start_ = 0;
  std::size_t firm_ = 0;
  std::vector<Knot> knots_;
  std::vector<double> values_;
};

/// How settled a quantity must be to be called so. Where `relative`, the tolerances are fractions
/// of the quantity's mean, which counts as at least `floor`.
struct Settling {
  double window = 0;       ///< of the smooth means [W^2/nu]
  double long_window = 0;  ///< the same for another try, if this does not settle; 0: none
  double shift = 0;        ///< between successive means [W^2/nu]
  double rest = 0;         ///< change per shift that counts as none
  double remaining = 0;    ///< change still to come that may be ignored
  double error = 0;        ///< largest error of a limit at which it rests
  double dying_error = 0;  ///< ... and of one that it approaches
  double departure = 0;    ///< from the range of values before, and a fifth of that range
  bool relative = false;
  double floor = 0;

  /// Time needed before anything can be said.
  [[nodiscard]] constexpr double span() const { return window + 2 * shift; }
};

/// An exponential approach is recognised by means that change by a constant ratio q = change now
/// / change before; above this q the drift is not dying out.
constexpr double dying_ratio = 0.9;
/// Part of a window, its latest, in which a departure from the course is looked for.
constexpr double recent_part = 0.4;
/// Fraction of the range of the values before that those in it may go beyond.
constexpr double departure_fraction = 0.2;

/// Where a quantity is heading, from smooth means at the ends of the present window (m0), of that a
/// shift before (m1), and of that two shifts before (m2). Its course is the exponential through
/// them, or, where it rests, the straight line through m1 and m0.
struct Outlook {
  enum class State {
    resting,  ///< |m0 - m1| and |m1 - m2| <= rest
    dying,    ///< else, drift that decays by a ratio of certainly no more than dying_ratio
    moving    ///< anything else
  };
  State state = State::moving;
  double level = 0;      ///< m0
  double rate = 0;       ///< (m0 - m1)/shift
  double limit = 0;      ///< dying: m0 + (m0 - m1) q/(1 - q) (Aitken); else m0
  double remaining = 0;  ///< dying: the most that is to come; else 0
  bool settled = false;  ///< resting or dying, and all that Settling asks for
  double error = 0;      ///< resting, dying: the limit is within so much of `limit`
  double misfit = 0;     ///< by which the means halfway between m0, m1 and m2 miss the course
  double band = 0;       ///< resting, dying: range about the course of the window's earlier values
  double departure = 0;  ///< ... and how far the latest values leave that range
  bool on_course = false;  ///< departure within the tolerance
};

/// The outlook at grid point `last`; nothing where the history is shorter than settling.span(). It
/// is that of the long window where only that finds the quantity settled: oscillations of a period
/// near the window's own look like a drift.
std::optional<Outlook> outlook(const UniformSeries& series, std::size_t last,
                               const Settling& settling);

}  // namespace ductile::drivers
