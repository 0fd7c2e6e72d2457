// Whether a run fits into memory, before it is taken.
#pragma once

#include <mpi.h>

#include <string>

#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Bytes of a run.
struct MemoryNeed {
  double shared = 0;    ///< on all ranks together: populations, and all that is around bodies
  double gathered = 0;  ///< on rank 0, to write a frame or a checkpoint
  [[nodiscard]] double total() const { return shared + gathered; }
};
MemoryNeed memory_needed(const Case& given);

/// The ranks of a job, and how many of them are on this machine.
struct Ranks {
  int all = 1;
  int here = 1;
};
/// Collective.
Ranks ranks_of(MPI_Comm comm);

/// Bytes of this machine that a run may take: the least of what is free and what its control group
/// leaves; infinity if neither can be told.
double free_memory();

/// What there is to say if the run does not fit into the memory of rank 0's machine, else nothing.
/// What it may take is the least of what is free, what its control group leaves, and the limit of
/// address space (ulimit -v), which each rank has for itself. On rank 0.
std::string memory_lacks(const Case& given, const Ranks& ranks);

}  // namespace ductile::drivers
