#include "gather.hpp"

#include "ductile/fluid/mpi.hpp"

namespace ductile::suspension {

using fluid::mpi_check;

Gather::Gather(MPI_Comm comm) : comm_(comm) {
  mpi_check(MPI_Comm_rank(comm, &rank_), "MPI_Comm_rank");
}

std::vector<double> Gather::from(int owner, std::span<const double> values) const {
  std::vector<double> result(values.begin(), values.end());
  if (owner == 0) return result;
  if (rank_ == owner) {
    mpi_check(MPI_Send(result.data(), static_cast<int>(result.size()), MPI_DOUBLE, 0, 0, comm_),
              "MPI_Send");
  } else if (rank_ == 0) {
    MPI_Status status;
    int count = 0;
    mpi_check(MPI_Probe(owner, 0, comm_, &status), "MPI_Probe");
    mpi_check(MPI_Get_count(&status, MPI_DOUBLE, &count), "MPI_Get_count");
    result.resize(static_cast<std::size_t>(count));
    mpi_check(MPI_Recv(result.data(), count, MPI_DOUBLE, owner, 0, comm_, MPI_STATUS_IGNORE),
              "MPI_Recv");
  }
  return result;
}

}  // namespace ductile::suspension
