// Signals to a run.
#pragma once

#include <array>
#include <csignal>

namespace ductile::drivers {

/// While it lives, signals are noted instead of obeyed. SIGTERM, SIGINT and SIGUSR2 ask the run to
/// end; a second SIGTERM or SIGINT ends the program at once, and an ignored SIGINT stays so.
/// SIGUSR1 asks for a checkpoint. mpirun hands on SIGUSR1 and SIGUSR2 as they are; of a SIGTERM or
/// SIGINT that it gets itself it makes a SIGTERM, and a second later the end.
///
/// The handlers that were there before come back at the end. One may live inside another, as a
/// run's does in the program's: the outer one's notes are then the inner one's too.
class Signals {
 public:
  Signals();
  ~Signals();
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

  /// The signal that has asked this rank to end, or 0.
  [[nodiscard]] int stop() const;
  /// Whether this rank has been asked for a checkpoint since the last call.
  bool take_checkpoint();

 private:
  static constexpr std::array<int, 4> signals = {SIGTERM, SIGINT, SIGUSR1, SIGUSR2};
  std::array<struct sigaction, signals.size()> before_{};
};

/// For the very start of the program: writing into a closed pipe or too large a file is an error
/// like others.
void prepare_signals();

}  // namespace ductile::drivers
