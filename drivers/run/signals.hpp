// Signals that ask a run to end.
#pragma once

#include <array>
#include <csignal>

namespace ductile::drivers {

/// While it lives, the first SIGTERM, SIGINT or SIGUSR1 is noted instead of obeyed; a second one
/// ends the program at once. The handlers that were there before come back at the end. One may live
/// inside another, as a run does in a comparison: the outer one's note is then the inner one's too.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  /// Whether one has come to this rank.
  [[nodiscard]] bool received() const;

 private:
  static constexpr std::array<int, 3> signals = {SIGTERM, SIGINT, SIGUSR1};
  std::array<struct sigaction, signals.size()> before_{};
};

}  // namespace ductile::drivers
