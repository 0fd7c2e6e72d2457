// A run: the loop around the time step, and what it writes.
#pragma once

#include <mpi.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "ductile/suspension/sample.hpp"
#include "output/say.hpp"
#include "output/summary.hpp"
#include "run/exit_code.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

struct RunOptions {
  std::filesystem::path directory;
  std::string scenario_text;  ///< resolved; written to scenario.toml
  bool force = false;         ///< a run of before in the directory is replaced
  bool resume = false;        ///< the run in the directory goes on
  /// Seconds since the program started, after which the run writes a checkpoint and ends.
  std::optional<double> max_walltime = {};
  bool profile = false;                    ///< the summary holds the time by part
  std::vector<std::string> warnings = {};  ///< of before the run, for the summary
  /// Names of options of PETSc that something has read before the run, or reads in another one:
  /// they are not reported as read by nothing.
  std::set<std::string> read_options = {};
};

/// What came of a run.
struct RunResult {
  ExitCode exit_code = exit_success;  ///< the same on all ranks
  bool interrupted = false;           ///< by a signal or its time; the same on all ranks
  /// On rank 0, unless the run could not be done: the summary as written, and the rows of
  /// trajectory.csv.
  std::optional<Summary> summary;
  std::vector<suspension::Sample> samples;
  std::shared_ptr<const Log> log;  ///< of the run, as long as this is kept
};

/// Call when the program starts, on every rank: the time allowed begins.
void start_clock();

/// Runs the case until it is decided, over, or fails, and writes the run directory. Rank 0 prints
/// progress and what stands in the way of a run, not what came of it. Signal handlers and PETSc's
/// options are afterwards what they were before. Collective.
RunResult run_case(const Case& given, const RunOptions& options, MPI_Comm comm);

}  // namespace ductile::drivers
