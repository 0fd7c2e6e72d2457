#include "halo.hpp"

#include <utility>

namespace ductile::fluid {

template <class Real>
Halo<Real>::Halo(const Communicator& comm, const std::array<int, 2>& peers,
                 std::vector<std::size_t> ends)
    : peers_(peers), ends_(std::move(ends)) {
  for (std::size_t turn = 0; turn < 2; ++turn) {
    receives_[turn].assign(2 * ends_.size(), MPI_REQUEST_NULL);
    sends_[turn].assign(2 * ends_.size(), MPI_REQUEST_NULL);
    for (std::size_t side = 0; side < 2; ++side) {
      if (peers_[side] == MPI_PROC_NULL) continue;
      out_[turn][side].resize(ends_.back());
      if (peers_[side] == comm.rank()) {
        // Its own neighbour: what leaves on one side arrives on the other.
        in_[1 - turn][1 - side] = out_[turn][side].data();
        continue;
      }
      remote_ = true;
      received_[turn][side].resize(ends_.back());
      in_[turn][side] = received_[turn][side].data();
      std::size_t begin = 0;
      for (std::size_t part = 0; part < ends_.size(); begin = ends_[part++]) {
        const int bytes = static_cast<int>((ends_[part] - begin) * sizeof(Real));
        // With two ranks both sides are the same peer: tags tell them apart.
        const int tag = static_cast<int>(2 * part);
        mpi_check(MPI_Recv_init(received_[turn][side].data() + begin, bytes, MPI_BYTE, peers_[side],
                                tag + static_cast<int>(side), comm.get(),
                                &receives_[turn][2 * part + side]),
                  "MPI_Recv_init");
        mpi_check(MPI_Send_init(out_[turn][side].data() + begin, bytes, MPI_BYTE, peers_[side],
                                tag + static_cast<int>(1 - side), comm.get(),
                                &sends_[turn][2 * part + side]),
                  "MPI_Send_init");
      }
    }
  }
}

template <class Real>
Halo<Real>::~Halo() {
  for (auto* requests : {&receives_, &sends_}) {
    for (Requests& of_turn : *requests) {
      // A request under way cannot be freed with its buffer, so it is waited for. A destructor
      // cannot report an error.
      MPI_Waitall(static_cast<int>(of_turn.size()), of_turn.data(), MPI_STATUSES_IGNORE);
      for (MPI_Request& request : of_turn) {
        if (request != MPI_REQUEST_NULL) MPI_Request_free(&request);
      }
    }
  }
}

template <class Real>
void Halo<Real>::wait(Requests& requests, int first, int count) {
  if (!remote_) return;
  mpi_check(MPI_Waitall(count, requests.data() + first, MPI_STATUSES_IGNORE), "MPI_Waitall");
}

template <class Real>
void Halo<Real>::begin_step() {
  wait(sends_[turn_], 0, 2 * parts());
  for (MPI_Request& request : receives_[1 - turn_]) {
    if (request != MPI_REQUEST_NULL) mpi_check(MPI_Start(&request), "MPI_Start");
  }
}

template <class Real>
void Halo<Real>::await(int part) {
  wait(receives_[turn_], 2 * part, 2);
}

template <class Real>
void Halo<Real>::send(int part) {
  const auto p = static_cast<std::size_t>(part);
  const std::size_t begin = part == 0 ? 0 : ends_[p - 1];
  for (std::size_t side = 0; side < 2; ++side) {
    MPI_Request& request = sends_[turn_][2 * p + side];
    if (request == MPI_REQUEST_NULL) continue;
    mpi_check(MPI_Start(&request), "MPI_Start");
    bytes_sent_ += static_cast<std::int64_t>((ends_[p] - begin) * sizeof(Real));
  }
}

template <class Real>
void Halo<Real>::end_step() {
  turn_ = 1 - turn_;
  given_ = true;
}

template <class Real>
void Halo<Real>::progress() {
  if (!remote_) return;
  int done = 0;
  Requests& coming = receives_[1 - turn_];
  mpi_check(MPI_Testall(2 * parts(), coming.data(), &done, MPI_STATUSES_IGNORE), "MPI_Testall");
}

template <class Real>
void Halo<Real>::await_all() {
  wait(receives_[turn_], 0, 2 * parts());
}

template <class Real>
void Halo<Real>::reset() {
  await_all();
  given_ = false;
}

template <class Real>
std::size_t Halo<Real>::memory() const {
  std::size_t count = 0;
  for (const auto* buffers : {&out_, &received_}) {
    for (const auto& of_turn : *buffers) {
      for (const auto& of_side : of_turn) count += of_side.size();
    }
  }
  return count * sizeof(Real);
}

template class Halo<double>;
template class Halo<float>;

}  // namespace ductile::fluid
