// What the ranks of a run agree on between its steps: whether to write a checkpoint, and to end.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <optional>

#include "run/signals.hpp"

namespace ductile::drivers {

/// Looks at signals and at rank 0's clock about ten times a second, after steps that all ranks
/// agree on beforehand: a step costs a comparison.
class Poll {
 public:
  using Clock = std::function<double()>;  ///< seconds

  struct Finding {
    int signal = 0;           ///< that asks the run to end, on any rank
    bool walltime = false;    ///< the time allowed is used up
    bool checkpoint = false;  ///< one is due, or asked for
    [[nodiscard]] bool stop() const { return signal != 0 || walltime; }
  };

  /// `begin`: when the time allowed, `max_walltime`, began; both and `checkpoint_every`, 0 for
  /// never, in seconds, and rank 0's alone.
  Poll(MPI_Comm comm, Clock clock, double begin, std::optional<double> max_walltime,
       double checkpoint_every);

  /// Call after every step. Collective.
  Finding after_step();
  /// A checkpoint has been written, since `begun` on the clock: room for another is kept at the end
  /// of the time allowed.
  void checkpoint_written(double begun);

 private:
  MPI_Comm comm_;
  Clock clock_;
  double end_;
  double checkpoint_every_;
  Signals signals_;
  double last_checkpoint_;
  double checkpoint_cost_ = 0;
  double last_look_;
  int steps_between_ = 1;  // two looks
  int steps_left_ = 1;
};

}  // namespace ductile::drivers
