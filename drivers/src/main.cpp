// The program: brings up MPI and PETSc, lets rank 0 read the user's input, and runs on all ranks
// what it says.
#include <mpi.h>
#include <petscsys.h>

#include <array>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "check.hpp"
#include "command_line.hpp"
#include "errors.hpp"
#include "plot.hpp"
#include "scenario.hpp"
#include "simulation.hpp"
#include "units.hpp"

namespace {

using namespace ductile::drivers;

void require(int mpi_code, const char* what) {
  if (mpi_code != MPI_SUCCESS) throw std::runtime_error(std::string(what) + " failed");
}

/// Rank 0's text, on every rank. Collective.
void broadcast(std::string& text, MPI_Comm comm) {
  auto size = static_cast<unsigned long long>(text.size());
  require(MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG_LONG, 0, comm), "MPI_Bcast");
  text.resize(size);
  require(MPI_Bcast(text.data(), static_cast<int>(size), MPI_CHAR, 0, comm), "MPI_Bcast");
}

/// What rank 0 has decided: an exit code, or a run.
struct Decision {
  int exit_code = exit_success;
  bool run = false;
  bool force = false;
  std::string directory;
  std::string scenario;  ///< resolved TOML
};

/// Reads the user's input, and does at once what takes no run. Rank 0 only.
Decision decide(const std::vector<std::string>& arguments) {
  Decision decision;
  try {
    const Command command = parse_command_line(arguments);
    if (command.action == Command::Action::print) {
      std::fputs(command.text.c_str(), stdout);
      return decision;
    }
    const LatticeSetup setup = lattice_setup(command.scenario);
    if (command.action == Command::Action::check) {
      const int cores = static_cast<int>(std::thread::hardware_concurrency());
      std::fputs(report(command.scenario, setup, cores).c_str(), stdout);
      return decision;
    }
    for (const std::string& note : notes(command.scenario, setup))
      std::fprintf(stderr, "note: %s\n", note.c_str());
    for (const std::string& warning : warnings(command.scenario, setup))
      std::fprintf(stderr, "warning: %s\n", warning.c_str());
    decision.run = true;
    decision.force = command.force;
    decision.directory = command.directory.string();
    decision.scenario = resolved_toml(command.scenario);
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    decision.exit_code = exit_bad_input;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ductile: %s\n", error.what());
    decision.exit_code = exit_failure;
  }
  return decision;
}

void petsc(PetscErrorCode code, const char* call) {
  if (code != 0) throw std::runtime_error(std::string("PETSc: ") + call + " failed");
}

/// Gives PETSc what the scenario's [petsc] says.
void set_petsc_options(const Scenario& scenario) {
  for (const auto& [name, value] : scenario.petsc) {
    petsc(PetscOptionsSetValue(nullptr, ("-" + name).c_str(),
                               value.empty() ? nullptr : value.c_str()),
          "PetscOptionsSetValue");
  }
  // PetscFinalize() prints the log; to have one takes a start.
  PetscBool log = PETSC_FALSE;
  petsc(PetscOptionsHasName(nullptr, nullptr, "-log_view", &log), "PetscOptionsHasName");
  if (log == PETSC_TRUE) petsc(PetscLogDefaultBegin(), "PetscLogDefaultBegin");
}

/// Collective. `finished` is set on rank 0 to the directory of a run that has left results.
int run_program(const std::vector<std::string>& arguments, MPI_Comm comm, std::string& finished) {
  int rank = 0;
  require(MPI_Comm_rank(comm, &rank), "MPI_Comm_rank");
  Decision decision;
  if (rank == 0) decision = decide(arguments);
  std::array<int, 3> flags{decision.exit_code, decision.run ? 1 : 0, decision.force ? 1 : 0};
  require(MPI_Bcast(flags.data(), static_cast<int>(flags.size()), MPI_INT, 0, comm), "MPI_Bcast");
  if (flags[1] == 0) return flags[0];
  broadcast(decision.directory, comm);
  broadcast(decision.scenario, comm);
  // All ranks, the first too, run the resolved text: what is in the run directory is what was run.
  const Scenario scenario = parse_scenario(decision.scenario, "scenario.toml");
  const LatticeSetup setup = lattice_setup(scenario);
  int ranks = 1;
  require(MPI_Comm_size(comm, &ranks), "MPI_Comm_size");
  if (ranks > setup.nodes[2]) {
    if (rank == 0) {
      std::fprintf(stderr, "ductile: %d ranks cannot share %d planes of nodes: use fewer ranks\n",
                   ranks, setup.nodes[2]);
    }
    return exit_bad_input;
  }
  set_petsc_options(scenario);
  const RunOptions options{decision.directory, decision.scenario, flags[2] != 0};
  const int exit_code = run_simulation(scenario, setup, options, comm);
  if (rank == 0 && (exit_code == exit_success || exit_code == exit_blow_up)) {
    finished = decision.directory;
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  // PETSc gets none of the user's arguments, and leaves signals alone.
  std::string name = "ductile";
  std::string option = "-no_signal_handler";
  std::array<char*, 3> petsc_arguments{name.data(), option.data(), nullptr};
  int petsc_count = 2;
  char** petsc_argv = petsc_arguments.data();
  if (PetscInitialize(&petsc_count, &petsc_argv, nullptr, nullptr) != 0) return exit_failure;
  int exit_code = exit_failure;
  std::string finished;
  try {
    exit_code = run_program({argv + 1, argv + argc}, PETSC_COMM_WORLD, finished);
  } catch (const std::exception& error) {
    // The other ranks may be waiting for this one.
    std::fprintf(stderr, "ductile: %s\n", error.what());
    MPI_Abort(PETSC_COMM_WORLD, exit_failure);
  }
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (PetscFinalize() != 0) return exit_failure;
  // Starting a process is safe only now that MPI is down.
  if (!finished.empty()) plot_trajectory(finished);
  // mpirun ends the job at the first rank that does not return 0, and rank 0 may still be drawing.
  return rank == 0 ? exit_code : exit_success;
}
