#include "run/root.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "ductile/fluid/mpi.hpp"
#include "output/say.hpp"

namespace ductile::drivers {

using fluid::mpi_check;

int rank_in(MPI_Comm comm) {
  int rank = 0;
  mpi_check(MPI_Comm_rank(comm, &rank), "MPI_Comm_rank");
  return rank;
}

int on_root(MPI_Comm comm, int failed, const std::function<int()>& work) {
  int result = failed;
  if (rank_in(comm) == 0) {
    try {
      result = work();
    } catch (const std::exception& error) {
      say(stderr, "ductile: {}\n", error.what());
    }
  }
  mpi_check(MPI_Bcast(&result, 1, MPI_INT, 0, comm), "MPI_Bcast");
  return result;
}

void broadcast(std::string& text, MPI_Comm comm) {
  auto size = static_cast<unsigned long long>(text.size());
  mpi_check(MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG_LONG, 0, comm), "MPI_Bcast");
  text.resize(size);
  mpi_check(MPI_Bcast(text.data(), static_cast<int>(size), MPI_CHAR, 0, comm), "MPI_Bcast");
}

}  // namespace ductile::drivers
