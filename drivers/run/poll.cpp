#include "run/poll.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "ductile/fluid/mpi.hpp"
#include "run/root.hpp"

namespace ductile::drivers {
namespace {

constexpr double interval = 0.1;  // seconds between two looks
// What ends a run in time needs: the time of two checkpoints, of the steps until the next look, and
// of summary and picture [s].
constexpr double checkpoints_kept = 2;
constexpr double end_kept = 3;

}  // namespace

Poll::Poll(MPI_Comm comm, Clock clock, double begin, std::optional<double> max_walltime,
           double checkpoint_every)
    : comm_(comm),
      clock_(std::move(clock)),
      end_(max_walltime ? begin + *max_walltime : std::numeric_limits<double>::infinity()),
      checkpoint_every_(checkpoint_every),
      last_checkpoint_(clock_()),
      last_look_(last_checkpoint_) {}

Poll::Finding Poll::after_step() {
  if (--steps_left_ > 0) return {};
  std::array<int, 4> said = {signals_.stop(), 0, signals_.take_checkpoint() ? 1 : 0, 0};
  if (rank_in(comm_) == 0) {
    const double now = clock_();
    const double until_next_look = 2 * (now - last_look_);
    if (now + checkpoints_kept * checkpoint_cost_ + until_next_look + end_kept >= end_) said[1] = 1;
    // One at the start shows what one costs.
    if (end_ < std::numeric_limits<double>::infinity() && checkpoint_cost_ == 0) said[2] = 1;
    if (checkpoint_every_ > 0 && now - last_checkpoint_ >= checkpoint_every_) said[2] = 1;
    const double step = std::max((now - last_look_) / steps_between_, 1e-9);
    said[3] = static_cast<int>(std::clamp(interval / step, 1.0, 1e6));
    last_look_ = now;
  }
  fluid::mpi_check(MPI_Allreduce(MPI_IN_PLACE, said.data(), static_cast<int>(said.size()), MPI_INT,
                                 MPI_MAX, comm_),
                   "MPI_Allreduce");
  steps_between_ = steps_left_ = std::min(said[3], 2 * steps_between_);
  return {said[0], said[1] != 0, said[2] != 0};
}

void Poll::checkpoint_written(double begun) {
  last_checkpoint_ = last_look_ = clock_();
  checkpoint_cost_ = std::max(checkpoint_cost_, last_checkpoint_ - begun);
}

}  // namespace ductile::drivers
