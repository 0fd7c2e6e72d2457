// The messages that cross the ends of a slab in each step.
#pragma once

#include <mpi.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ductile/fluid/mpi.hpp"

namespace ductile::fluid {

/// The messages between a slab and those below (side 0) and above it (side 1). In each step a slab
/// gives each of them one number a slot, the same slots every time, and what is given in one step
/// is used in the next: a message has a whole sweep over the slab to arrive in. The slots are
/// ordered as the sweep goes and cut into parts, each sent as soon as it is complete.
template <class Real>
class Halo {
 public:
  /// `peers`: the ranks below and above, this rank for itself, MPI_PROC_NULL for none. `ends`:
  /// slots up to the end of each part, the same on all ranks. `comm` outlives the halo.
  Halo(const Communicator& comm, const std::array<int, 2>& peers, std::vector<std::size_t> ends);
  ~Halo();
  Halo(const Halo&) = delete;
  Halo& operator=(const Halo&) = delete;

  /// In this order, in each step:
  void begin_step();
  void await(int part);  ///< part of the arrivals, of both sides; any number of times
  void send(int part);   ///< part of the departures, once
  void end_step();
  /// Lets messages progress; as often as one likes in a step.
  void progress();

  /// At any time: waits for all arrivals.
  void await_all();
  /// Between steps: nothing has been given.
  void reset();

  [[nodiscard]] int parts() const { return static_cast<int>(ends_.size()); }
  [[nodiscard]] bool exists(int side) const {
    return peers_[static_cast<std::size_t>(side)] != MPI_PROC_NULL;
  }
  /// What that side gave in the step before, where it has been awaited; null if nothing was given.
  [[nodiscard]] const Real* arrivals(int side) const {
    return given_ ? in_[turn_][static_cast<std::size_t>(side)] : nullptr;
  }
  /// What this step gives to that side; null if there is none.
  [[nodiscard]] Real* departures(int side) {
    return out_[turn_][static_cast<std::size_t>(side)].data();
  }

  /// To other ranks, since construction.
  [[nodiscard]] std::int64_t bytes_sent() const { return bytes_sent_; }
  [[nodiscard]] std::size_t memory() const;

 private:
  // Requests of one part on one side are null unless its peer is another rank.
  using Requests = std::vector<MPI_Request>;
  void wait(Requests& requests, int first, int count);

  std::array<int, 2> peers_;
  bool remote_ = false;  // any peer is another rank
  std::vector<std::size_t> ends_;
  // Buffers and requests alternate between steps: while one set is used, the other is under way.
  std::size_t turn_ = 0;
  bool given_ = false;
  std::array<std::array<std::vector<Real>, 2>, 2> out_;       // [turn][side]
  std::array<std::array<std::vector<Real>, 2>, 2> received_;  // from other ranks
  std::array<std::array<const Real*, 2>, 2> in_{};  // received_, or out_ of the turn before
  std::array<Requests, 2> receives_;                // [turn][2 part + side]
  std::array<Requests, 2> sends_;
  std::int64_t bytes_sent_ = 0;
};

extern template class Halo<double>;
extern template class Halo<float>;

}  // namespace ductile::fluid
