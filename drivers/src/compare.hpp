// `ductile compare`: one scenario, run with several membrane integrators.
#pragma once

#include <mpi.h>

#include <filesystem>
#include <string>
#include <vector>

#include "errors.hpp"

namespace ductile::drivers {

/// A run that is to be compared.
struct Variant {
  std::string integrator;
  std::string scenario;  ///< resolved TOML
};

/// What came of a comparison; the same on all ranks.
struct ComparisonResult {
  /// A run that blew up is a result: exit_blow_up only if all did.
  ExitCode exit_code = exit_success;
  /// Integrators whose runs have left results, whose directories are called after them. Without
  /// compare.json if a run could not be done.
  std::vector<std::string> finished;
};

/// Runs the variants one after the other, each into a directory of its own in `directory`, then
/// prints the comparison and writes compare.json beside them. A signal ends the run at hand and
/// leaves out those still to come. Collective.
ComparisonResult compare_integrators(const std::vector<Variant>& variants,
                                     const std::filesystem::path& directory, bool force,
                                     MPI_Comm comm);

}  // namespace ductile::drivers
