// A run: fluid, bodies and coupler put together, and the loop around the time step.
#pragma once

#include <mpi.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "errors.hpp"
#include "sample.hpp"
#include "scenario.hpp"
#include "summary.hpp"
#include "units.hpp"

namespace ductile::drivers {

struct RunOptions {
  std::filesystem::path directory;
  std::string scenario_text;  ///< resolved; written to scenario.toml
  bool force = false;         ///< a run of before in the directory is replaced
  bool profile = false;       ///< the summary holds the time by part
};

/// What came of a run.
struct RunResult {
  ExitCode exit_code = exit_success;  ///< the same on all ranks
  bool interrupted = false;           ///< by a signal; the same on all ranks
  /// On rank 0, unless the run could not be done: the summary as written, and the rows of
  /// trajectory.csv.
  std::optional<Summary> summary;
  std::vector<Sample> samples;
};

/// Runs the scenario until it is decided, over, or fails, and writes the run directory. Rank 0
/// prints progress and what stands in the way of a run, not what came of it. Collective.
RunResult run_simulation(const Scenario& scenario, const LatticeSetup& setup,
                         const RunOptions& options, MPI_Comm comm);

}  // namespace ductile::drivers
