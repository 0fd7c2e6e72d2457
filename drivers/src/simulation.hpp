// A run: fluid, bodies and coupler put together, and the loop around the time step.
#pragma once

#include <mpi.h>

#include <filesystem>
#include <string>

#include "ductile/fluid/fluid.hpp"
#include "scenario.hpp"
#include "units.hpp"

namespace ductile::drivers {

struct RunOptions {
  std::filesystem::path directory;
  std::string scenario_text;  ///< resolved; written to scenario.toml
  bool force = false;         ///< a run of before in the directory is replaced
};

/// The fluid of a scenario, in its initial state. Collective.
fluid::Fluid make_fluid(const Scenario& scenario, const LatticeSetup& setup, MPI_Comm comm);

/// Runs the scenario until it is decided, over, or fails, and writes the run directory. Progress
/// and outcome are printed by rank 0. Returns the same ExitCode on all ranks. Collective.
int run_simulation(const Scenario& scenario, const LatticeSetup& setup, const RunOptions& options,
                   MPI_Comm comm);

}  // namespace ductile::drivers
