// What rank 0 does alone, and how the others learn of it.
#pragma once

#include <mpi.h>

#include <functional>
#include <string>

namespace ductile::drivers {

/// Rank 0 does the work; its result is every rank's. Work that throws gives `failed`, and a line on
/// stderr says why: a full disk stops all ranks alike. Collective.
int on_root(MPI_Comm comm, int failed, const std::function<int()>& work);

/// Rank 0's text, on every rank. Collective.
void broadcast(std::string& text, MPI_Comm comm);

/// Rank in a communicator.
int rank_in(MPI_Comm comm);

}  // namespace ductile::drivers
