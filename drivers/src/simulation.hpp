// A run: fluid, bodies and coupler put together, and the loop around the time step.
#pragma once

#include <mpi.h>

#include <filesystem>
#include <string>

#include "scenario.hpp"
#include "units.hpp"

namespace ductile::drivers {

struct RunOptions {
  std::filesystem::path directory;
  std::string scenario_text;
  bool force = false;
};

int run_simulation(const Scenario& scenario, const LatticeSetup& setup, const RunOptions& options,
                   MPI_Comm comm);

}  // namespace ductile::drivers
