// The program: brings up MPI and PETSc, lets rank 0 read the user's input, and runs on all ranks
// what it says.
#include <fmt/format.h>
#include <mpi.h>
#include <petscsys.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "bench.hpp"
#include "check.hpp"
#include "command_line.hpp"
#include "compare.hpp"
#include "ductile/membrane/petsc.hpp"
#include "errors.hpp"
#include "outcome.hpp"
#include "petsc_options.hpp"
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

/// What rank 0 has decided: an exit code, or what to run.
struct Decision {
  int exit_code = exit_success;
  Command::Action action = Command::Action::print;  ///< print: nothing is left to do
  bool force = false;
  bool profile = false;
  std::string directory;
  std::vector<Variant> variants;  ///< of a single run, without an integrator's name
  BenchOptions bench;
};

/// Rank 0's decision, on every rank. Collective.
void broadcast(Decision& decision, MPI_Comm comm) {
  std::array<int, 7> numbers{
      decision.exit_code,       static_cast<int>(decision.action),          decision.force ? 1 : 0,
      decision.profile ? 1 : 0, static_cast<int>(decision.variants.size()), decision.bench.nodes,
      decision.bench.repeats};
  require(MPI_Bcast(numbers.data(), static_cast<int>(numbers.size()), MPI_INT, 0, comm),
          "MPI_Bcast");
  decision.exit_code = numbers[0];
  decision.action = static_cast<Command::Action>(numbers[1]);
  decision.force = numbers[2] != 0;
  decision.profile = numbers[3] != 0;
  decision.variants.resize(static_cast<std::size_t>(numbers[4]));
  decision.bench.nodes = numbers[5];
  decision.bench.repeats = numbers[6];
  broadcast(decision.directory, comm);
  for (Variant& variant : decision.variants) {
    broadcast(variant.integrator, comm);
    broadcast(variant.scenario, comm);
  }
}

/// Notes and warnings, one line each: what is said of several scenarios, once, and what is not said
/// of all, with the integrators that it is about.
void advise(const std::vector<std::pair<std::string, Scenario>>& scenarios) {
  std::vector<std::pair<std::string, std::vector<std::string>>> lines;
  for (const auto& [integrator, scenario] : scenarios) {
    const LatticeSetup setup = lattice_setup(scenario);
    std::vector<std::string> said;
    for (const std::string& note : notes(scenario, setup)) said.push_back("note: " + note);
    for (const std::string& warning : warnings(scenario, setup))
      said.push_back("warning: " + warning);
    for (const std::string& line : said) {
      auto known = std::find_if(lines.begin(), lines.end(),
                                [&line](const auto& entry) { return entry.first == line; });
      if (known == lines.end()) known = lines.insert(lines.end(), {line, {}});
      known->second.push_back(integrator);
    }
  }
  for (const auto& [line, integrators] : lines) {
    const std::string about = integrators.size() == scenarios.size()
                                  ? ""
                                  : fmt::format(" (of {})", fmt::join(integrators, ", "));
    fmt::print(stderr, "{}{}\n", line, about);
  }
}

/// Reads the user's input, and does at once what takes no run. Rank 0 only.
Decision decide(const std::vector<std::string>& arguments) {
  Decision decision;
  try {
    const Command command = parse_command_line(arguments);
    if (command.action == Command::Action::print) {
      std::fputs(command.text.c_str(), stdout);
      return decision;
    }
    if (command.action == Command::Action::check) {
      const int cores = static_cast<int>(std::thread::hardware_concurrency());
      const LatticeSetup setup = lattice_setup(command.scenario);
      std::fputs(report(command.scenario, setup, cores, known_speed()).c_str(), stdout);
      return decision;
    }
    if (command.action == Command::Action::bench) {
      decision.action = command.action;
      decision.bench = command.bench;
      return decision;
    }
    const bool compare = command.action == Command::Action::compare;
    const auto scenarios =
        compare ? command.integrators
                : std::vector<std::pair<std::string, Scenario>>{{"", command.scenario}};
    for (const auto& [integrator, scenario] : scenarios) try_petsc_options(scenario);
    advise(scenarios);
    for (const auto& [integrator, scenario] : scenarios)
      decision.variants.push_back({integrator, resolved_toml(scenario)});
    decision.action = command.action;
    decision.force = command.force;
    decision.profile = command.profile;
    decision.directory = command.directory.string();
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    decision.exit_code = exit_bad_input;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ductile: %s\n", error.what());
    decision.exit_code = exit_failure;
  }
  return decision;
}

/// What to draw when MPI is down: directories, filled on rank 0.
struct Pictures {
  std::vector<std::filesystem::path> trajectories;
  std::vector<std::filesystem::path> comparisons;
};

bool has_results(int exit_code) {
  return exit_code == exit_success || exit_code == exit_blow_up;
}

/// Collective.
int run_bench(const BenchOptions& options, MPI_Comm comm) {
  int rank = 0;
  require(MPI_Comm_rank(comm, &rank), "MPI_Comm_rank");
  try {
    const BenchResult result = measure(options, comm);
    if (rank != 0) return exit_success;
    std::fputs((options.json ? json(result) : table(result)).c_str(), stdout);
    if (!is_representative(result)) {
      fmt::print(stderr,
                 "not kept for `ductile check`: that takes the default --nodes, and no more "
                 "ranks than cores\n");
    } else if (const auto file = keep_speed(result)) {
      fmt::print(stderr, "kept for `ductile check` in {}\n", *file);
    } else {
      fmt::print(stderr, "warning: the speed could not be kept for `ductile check`\n");
    }
  } catch (const InputError& error) {
    if (rank == 0) std::fprintf(stderr, "%s\n", error.what());
    return exit_bad_input;
  }
  return exit_success;
}

/// Collective.
int run_program(const std::vector<std::string>& arguments, MPI_Comm comm, Pictures& pictures) {
  int rank = 0;
  require(MPI_Comm_rank(comm, &rank), "MPI_Comm_rank");
  Decision decision;
  if (rank == 0) decision = decide(arguments);
  broadcast(decision, comm);
  if (decision.action == Command::Action::print) return decision.exit_code;
  if (decision.action == Command::Action::bench) return run_bench(decision.bench, comm);
  // All ranks, the first too, run the resolved text: what is in the run directory is what was run.
  const Scenario scenario = parse_scenario(decision.variants.front().scenario, "scenario.toml");
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
  const std::filesystem::path directory = decision.directory;
  if (decision.action == Command::Action::compare) {
    const ComparisonResult result =
        compare_integrators(decision.variants, directory, decision.force, comm);
    if (rank == 0) {
      for (const std::string& name : result.finished)
        pictures.trajectories.push_back(directory / name);
      if (has_results(result.exit_code)) pictures.comparisons.push_back(directory);
    }
    return result.exit_code;
  }
  const RunOptions options{directory, decision.variants.front().scenario, decision.force,
                           decision.profile};
  const RunResult result = run_simulation(scenario, setup, options, comm);
  if (result.summary) {
    print_outcome(*result.summary, directory);
    pictures.trajectories.push_back(directory);
  }
  return result.exit_code;
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
  Pictures pictures;
  try {
    ductile::membrane::quieten_petsc();
    exit_code = run_program({argv + 1, argv + argc}, PETSC_COMM_WORLD, pictures);
  } catch (const std::exception& error) {
    // The other ranks may be waiting for this one.
    std::fprintf(stderr, "ductile: %s\n", error.what());
    MPI_Abort(PETSC_COMM_WORLD, exit_failure);
  }
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (PetscFinalize() != 0) return exit_failure;
  // Starting a process is safe only now that MPI is down.
  for (const auto& directory : pictures.trajectories) plot_trajectory(directory);
  for (const auto& directory : pictures.comparisons) plot_comparison(directory);
  // mpirun ends the job at the first rank that does not return 0, and rank 0 may still be drawing.
  return rank == 0 ? exit_code : exit_success;
}
