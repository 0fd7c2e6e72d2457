#include "failures.hpp"

#include <array>
#include <utility>

namespace ductile::coupling {

using fluid::mpi_check;

BodyFailure::BodyFailure(int body, Cause cause, std::optional<std::size_t> marker,
                         std::int64_t step, const std::string& reason)
    : std::runtime_error("body " + std::to_string(body) + ", step " + std::to_string(step) + ": " +
                         reason),
      body_(body),
      cause_(cause),
      marker_(marker),
      step_(step),
      reason_(reason) {}

void Failures::add(int body, BodyFailure::Cause cause, std::optional<std::size_t> marker,
                   const std::string& reason) {
  if (precede(body)) return;
  body_ = body;
  cause_ = cause;
  marker_ = marker;
  reason_ = reason;
}

void Failures::raise(const fluid::Communicator& comm, std::int64_t step) {
  std::array<int, 2> first = {std::exchange(body_, INT_MAX), comm.rank()};  // body, its owner
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, first.data(), 1, MPI_2INT, MPI_MINLOC, comm.get()),
            "MPI_Allreduce");
  const auto [body, owner] = first;
  constexpr int none = -1;
  std::array<int, 3> header = {static_cast<int>(cause_), static_cast<int>(reason_.size()),
                               marker_ ? static_cast<int>(*marker_) : none};
  mpi_check(MPI_Bcast(header.data(), 3, MPI_INT, owner, comm.get()), "MPI_Bcast");
  const auto [cause, length, marker] = header;
  reason_.resize(static_cast<std::size_t>(length));
  mpi_check(MPI_Bcast(reason_.data(), length, MPI_CHAR, owner, comm.get()), "MPI_Bcast");
  marker_ =
      marker == none ? std::nullopt : std::optional<std::size_t>(static_cast<std::size_t>(marker));
  throw BodyFailure(body, static_cast<BodyFailure::Cause>(cause), marker_, step, reason_);
}

}  // namespace ductile::coupling
