#include "planes.hpp"

#include <algorithm>

#include "ductile/fluid/mpi.hpp"
#include "gather.hpp"

namespace ductile::suspension {

using fluid::mpi_check;

Planes::Planes(const fluid::Fluid& fluid, MPI_Comm comm)
    : fluid_(fluid),
      comm_(comm),
      columns_(static_cast<std::size_t>(fluid.options().nodes[0]) *
               static_cast<std::size_t>(fluid.options().nodes[1])),
      planes_(static_cast<std::size_t>(fluid.options().nodes[2])) {
  mpi_check(MPI_Comm_rank(comm, &rank_), "MPI_Comm_rank");
  mpi_check(MPI_Comm_size(comm, &ranks_), "MPI_Comm_size");
}

std::size_t Planes::size_of(int rank) const {
  return columns_ * static_cast<std::size_t>(fluid_.slab(rank).size());
}

std::vector<double> Planes::gathered(std::span<const double> own) const {
  const Gather gather(comm_);
  std::vector<double> whole(rank_ == 0 ? whole_size() : 0);
  for (int r = 0; r < ranks_; ++r) {
    if (rank_ != 0 && rank_ != r) continue;
    const std::vector<double> part = gather.from(r, own);
    if (rank_ != 0) continue;
    const fluid::Range slab = fluid_.slab(r);
    const auto count = static_cast<std::size_t>(slab.size());
    for (std::size_t column = 0; column < columns_; ++column) {
      std::copy_n(&part[column * count], count,
                  &whole[column * planes_ + static_cast<std::size_t>(slab.begin)]);
    }
  }
  return whole;
}

void Planes::scatter(std::span<const double> whole, std::span<double> own) const {
  if (rank_ != 0) {
    mpi_check(MPI_Recv(own.data(), static_cast<int>(own.size()), MPI_DOUBLE, 0, 0, comm_,
                       MPI_STATUS_IGNORE),
              "MPI_Recv");
    return;
  }
  std::vector<double> part;
  for (int r = ranks_ - 1; r >= 0; --r) {  // rank 0's own comes last
    const fluid::Range slab = fluid_.slab(r);
    const auto count = static_cast<std::size_t>(slab.size());
    part.resize(size_of(r));
    for (std::size_t column = 0; column < columns_; ++column) {
      std::copy_n(&whole[column * planes_ + static_cast<std::size_t>(slab.begin)], count,
                  &part[column * count]);
    }
    if (r > 0) {
      mpi_check(MPI_Send(part.data(), static_cast<int>(part.size()), MPI_DOUBLE, r, 0, comm_),
                "MPI_Send");
    }
  }
  std::ranges::copy(part, own.begin());
}

}  // namespace ductile::suspension
