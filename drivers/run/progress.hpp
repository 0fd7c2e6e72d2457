// The live line of a run.
#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>

namespace ductile::drivers {

/// Shows simulated time, percent, million lattice updates a second and the time left: on a terminal
/// one line, rewritten in place; otherwise whole lines, at intervals that double from 10 seconds to
/// 5 minutes. Between two showings update() reads the clock and returns.
class Progress {
 public:
  /// A clock in seconds, from any zero.
  using Clock = std::function<double()>;
  static double steady_seconds();

  /// `end_time` [W^2/nu]: when the run ends, if nothing ends it before. `nodes`: lattice updates of
  /// a step. `out` must outlive this object; whether it is a terminal is asked of the system.
  Progress(double end_time, std::int64_t nodes, std::FILE* out = stderr);
  /// The same with everything given, for tests.
  Progress(double end_time, std::int64_t nodes, std::FILE* out, bool terminal, Clock clock);

  /// A short text to show along, such as the distance of the pair.
  void note(std::string text) { note_ = std::move(text); }
  /// Call after each step, with the simulated time [W^2/nu] and the number of steps so far. The
  /// first call sets the zero of all rates.
  void update(double time, std::int64_t step);
  /// Shows the last state and ends the line. Call before anything else is printed.
  void finish();

 private:
  void show();

  double end_time_;
  double nodes_;
  std::FILE* out_;
  bool terminal_;
  Clock clock_;
  std::string note_;

  struct State {
    double clock = 0;
    double time = 0;
    std::int64_t step = 0;
  };
  State first_;
  State shown_;
  State now_;
  bool started_ = false;
  int decimals_;  // of times
  double interval_;
  double rate_ = 0;  // million updates a second, over the last interval
};

}  // namespace ductile::drivers
