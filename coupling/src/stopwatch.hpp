// The time of a step, part by part.
#pragma once

#include <chrono>
#include <cstddef>

#include "ductile/coupling/profile.hpp"

namespace ductile::coupling {

/// Divides the time of a step into laps: each ends where the next begins, so none is lost.
class Stopwatch {
 public:
  void start() { last_ = Clock::now(); }
  /// The time since the lap before goes to `part`.
  void lap(Part part) {
    const Clock::time_point now = Clock::now();
    profile.seconds[static_cast<std::size_t>(part)] +=
        std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

  Profile profile;

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_;
};

}  // namespace ductile::coupling
