// The scenario's [petsc]: options for the solvers.
#pragma once

#include <mpi.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Takes PETSc's own sources of options out of its sight, for results come from the scenario alone:
/// PETSC_OPTIONS and PETSC_OPTIONS_YAML of the environment, and .petscrc in the home directory,
/// .petscrc and petscrc in the working one, which PETSc leaves out given the option -skip_petscrc.
/// Gives the names of those that there are. Call before PetscInitialize().
std::vector<std::string> ignored_petsc_sources();

/// While it lives, PETSc has the scenario's options on this rank, for all solvers made from now on;
/// then it has again those that it had before.
class PetscOptions {
 public:
  /// Throws membrane::PetscFailure.
  explicit PetscOptions(const std::vector<PetscOption>& options);
  ~PetscOptions();
  PetscOptions(const PetscOptions&) = delete;
  PetscOptions& operator=(const PetscOptions&) = delete;

  /// The names of those that no solver on any rank has read, on every rank. Collective.
  [[nodiscard]] std::vector<std::string> unread(MPI_Comm comm) const;
  /// Prints the log that -log_view asks for, if it does. Collective over PETSC_COMM_WORLD.
  void view_log() const;

 private:
  struct Entry {
    std::string name;
    std::optional<std::string> before;  ///< its value, if PETSc had one
  };
  void restore() noexcept;

  std::vector<Entry> entries_;
};

/// Lets each integrator of the case take a step with a small capsule in a still fluid under the
/// scenario's options, so that an option that PETSc does not understand is the user's to mend
/// before a run. Gives the names of those that are read; does nothing without options. Throws
/// InputError.
std::set<std::string> try_petsc_options(const Case& given);

}  // namespace ductile::drivers
