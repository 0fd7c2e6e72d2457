// Whether a run fits into memory, before it is taken.
#pragma once

#include <mpi.h>

#include <string>

#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Bytes of a run, on all ranks together: the populations, forces and velocities around bodies, the
/// bodies themselves, and what rank 0 gathers to write a frame or a checkpoint.
double memory_needed(const Case& given);

/// Bytes that this process may still take: of what is free on the machine, what its control group
/// allows and the limit of its address space (ulimit -v), the least.
double memory_free();

/// What there is to say if a share of the run, of the ranks that are on this machine, does not fit;
/// else nothing.
std::string memory_lacks(const Case& given, double share);

/// The part of all ranks that are on this rank's machine. Collective.
double share_of_machine(MPI_Comm comm);

}  // namespace ductile::drivers
