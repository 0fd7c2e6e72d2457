// The program: brings up MPI and PETSc, and runs a command on all ranks.
#include <mpi.h>
#include <petscsys.h>

#include <array>
#include <cstdio>
#include <exception>
#include <string>

#include "commands/program.hpp"
#include "ductile/fluid/mpi.hpp"
#include "ductile/membrane/petsc.hpp"
#include "output/plot.hpp"
#include "run/exit_code.hpp"

int main(int argc, char** argv) {
  using namespace ductile::drivers;
  // PETSc gets none of the user's arguments, and leaves signals alone.
  std::string name = "ductile";
  std::string option = "-no_signal_handler";
  std::array<char*, 3> petsc_arguments{name.data(), option.data(), nullptr};
  int petsc_count = 2;
  char** petsc_argv = petsc_arguments.data();
  if (PetscInitialize(&petsc_count, &petsc_argv, nullptr, nullptr) != 0) return exit_failure;
  int exit_code = exit_failure;
  int rank = 0;
  Pictures pictures;
  try {
    ductile::membrane::quieten_petsc();
    const ductile::fluid::Communicator world(PETSC_COMM_WORLD);
    rank = world.rank();
    exit_code = run_program({argv + 1, argv + argc}, world.get(), pictures);
  } catch (const std::exception& error) {
    // The other ranks may be waiting for this one.
    std::fprintf(stderr, "ductile: %s\n", error.what());
    MPI_Abort(PETSC_COMM_WORLD, exit_failure);
  }
  if (PetscFinalize() != 0) return exit_failure;
  // Starting a process is safe only now that MPI is down.
  for (const auto& directory : pictures.trajectories) plot_trajectory(directory);
  for (const auto& directory : pictures.comparisons) plot_comparison(directory);
  // mpirun ends the job at the first rank that does not return 0, and rank 0 may still be drawing.
  return rank == 0 ? exit_code : exit_success;
}
