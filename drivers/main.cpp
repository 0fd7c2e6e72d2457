// The program: brings up MPI and PETSc, and runs a command on all ranks.
#include <mpi.h>
#include <petscsys.h>

#include <array>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "commands/program.hpp"
#include "ductile/fluid/mpi.hpp"
#include "ductile/membrane/petsc.hpp"
#include "output/plot.hpp"
#include "output/process.hpp"
#include "output/say.hpp"
#include "run/exit_code.hpp"
#include "run/petsc_options.hpp"
#include "run/run.hpp"
#include "run/signals.hpp"

int main(int argc, char** argv) {
  using namespace ductile::drivers;
  open_missing_streams();
  prepare_signals();
  // From the first moment to the last, of what runs; other commands end as any program does.
  std::optional<Signals> signals;
  for (const std::string_view command : {"run", "pair", "resume", "compare", "campaign"})
    if (argc > 1 && command == argv[1]) signals.emplace();
  start_clock();
  keep_environment();
  // PETSc gets none of the user's arguments, reads no file, and leaves signals alone.
  const std::vector<std::string> ignored = ignored_petsc_sources();
  std::string name = "ductile";
  std::string no_signals = "-no_signal_handler";
  std::string no_files = "-skip_petscrc";
  std::array<char*, 4> petsc_arguments{name.data(), no_signals.data(), no_files.data(), nullptr};
  int petsc_count = 3;
  char** petsc_argv = petsc_arguments.data();
  if (PetscInitialize(&petsc_count, &petsc_argv, nullptr, nullptr) != 0) return exit_failure;
  int exit_code = exit_failure;
  int rank = 0;
  Afterwards afterwards;
  try {
    ductile::membrane::quieten_petsc();
    const ductile::fluid::Communicator world(PETSC_COMM_WORLD);
    rank = world.rank();
    for (const std::string& source : ignored) {
      if (rank != 0) break;
      say(stderr,
          "warning: {} is ignored: options of PETSc belong into the scenario's [petsc] or into "
          "--petsc\n",
          source);
    }
    exit_code = run_program({argv + 1, argv + argc}, world.get(), afterwards);
  } catch (const std::exception& error) {
    // The other ranks may be waiting for this one.
    say(stderr, "ductile: {}\n", error.what());
    MPI_Abort(PETSC_COMM_WORLD, exit_failure);
  }
  // PETSc ends without a word if stdout takes nothing any more.
  if (rank == 0 && stdout_lost()) {
    say(stderr, "ductile: not all that was to be said on stdout could be written there\n");
    if (exit_code == exit_success) exit_code = exit_failure;
    if (std::freopen("/dev/null", "w", stdout) == nullptr) return exit_code;
  }
  if (PetscFinalize() != 0) return exit_failure;
  // Starting a process is safe only now that MPI is down.
  if (afterwards.work) {
    try {
      exit_code = afterwards.work();
    } catch (const std::exception& error) {
      say(stderr, "ductile: {}\n", error.what());
      exit_code = exit_failure;
    }
  }
  for (const auto& directory : afterwards.trajectories)
    plot_trajectory(directory, afterwards.format);
  for (const auto& directory : afterwards.comparisons)
    plot_comparison(directory, afterwards.format);
  if (afterwards.picture) exit_code = draw(*afterwards.picture);
  // mpirun ends the job at the first rank that does not return 0, and rank 0 may still be drawing.
  return rank == 0 ? exit_code : exit_success;
}
