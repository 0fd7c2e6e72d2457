// Where a slowly varying quantity is heading.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace ductile::drivers {

/// A quantity against time, resampled by linear interpolation onto a uniform grid that starts with
/// the first sample: what is concluded from it does not depend on how often the run was sampled.
class UniformSeries {
 public:
  static constexpr double step = 0.1;  ///< of the grid [W^2/nu]; bodies move on scales of 1 and up

  /// Throws std::invalid_argument unless time increases and both numbers are finite.
  void add(double time, double value);

  [[nodiscard]] std::size_t size() const { return values_.size(); }
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
  double start_ = 0;
  double last_time_ = 0;
  double last_value_ = 0;
  std::vector<double> values_;
};

/// How settled a quantity must be to be called so.
struct Settling {
  double window;     ///< of the smooth means [W^2/nu]
  double shift;      ///< between successive means [W^2/nu]
  double rest;       ///< change per shift that counts as none
  double remaining;  ///< change still to come that may be ignored
  bool relative;     ///< whether the last two are fractions of the quantity's mean...
  double floor;      ///< ... which counts as at least this

  /// Time needed before anything can be said.
  [[nodiscard]] constexpr double span() const { return window + 2 * shift; }
};

/// An exponential approach is recognised by means that change by a constant ratio q = change now
/// / change before; above this q the drift is not dying out.
constexpr double dying_ratio = 0.9;

/// Where a quantity is heading, from three means m2, m1, m0, the last of the present window, each
/// a shift after the one before.
struct Outlook {
  enum class State {
    resting,  ///< |m0 - m1| <= rest and |m1 - m2| <= 2 rest
    dying,    ///< else, drift that decays by a ratio q <= dying_ratio
    moving    ///< anything else
  };
  State state = State::moving;
  double level = 0;      ///< m0
  double rate = 0;       ///< (m0 - m1)/shift
  double limit = 0;      ///< dying: m0 + (m0 - m1) q/(1 - q) (Aitken); else m0
  double remaining = 0;  ///< dying: of the limit, what is to come after the present; else 0
  bool settled = false;  ///< resting, or dying with |remaining| within the tolerance
};

/// The outlook at grid point `last`; nothing where the history is shorter than settling.span().
std::optional<Outlook> outlook(const UniformSeries& series, std::size_t last,
                               const Settling& settling);

}  // namespace ductile::drivers
