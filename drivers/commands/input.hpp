// From the user's files to cases on all ranks.
#pragma once

#include <mpi.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "checks/advice.hpp"
#include "checks/memory.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Rank 0 does what needs the user's input; the exit code is every rank's. What it throws is said
/// in one line: an InputError is the user's to mend, anything else the system's. Collective.
int with_input(MPI_Comm comm, const std::function<void()>& work);

/// Prints what there is to note and to warn of some cases: what is said of several, once, and where
/// it is not said of all, with the names of those that it is about. Gives the warnings of each
/// case. Predictions of stability may take `patience` seconds for each. Rank 0.
std::vector<std::vector<std::string>> advise(const std::vector<std::pair<std::string, Case>>& cases,
                                             double patience = patience_of_a_run);

/// Rank 0's resolved scenario as a case on every rank, the first too: what is in the run directory
/// is what was run. Collective.
Case shared_case(std::string& scenario, MPI_Comm comm);

/// Throws InputError if the run does not fit into memory. Rank 0.
void require_memory(const Case& given, const Ranks& ranks);

/// Whether the channel has a plane for each rank; else says so, on rank 0. Collective.
bool enough_planes(const Case& given, MPI_Comm comm);

}  // namespace ductile::drivers
