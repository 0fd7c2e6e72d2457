#include "compare.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <functional>
#include <stdexcept>
#include <utility>

#include "comparison.hpp"
#include "progress.hpp"
#include "run_directory.hpp"
#include "scenario.hpp"
#include "simulation.hpp"
#include "units.hpp"

namespace ductile::drivers {
namespace {

constexpr const char* comparison_file = "compare.json";
constexpr const char* comparison_plot = "compare.png";

/// Rank 0 does the work, which may fail; every rank learns whether it did.
ExitCode on_root(MPI_Comm comm, const std::function<void()>& work) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  int code = exit_success;
  if (rank == 0) {
    try {
      work();
    } catch (const std::exception& error) {
      fmt::print(stderr, "ductile: {}\n", error.what());
      code = exit_failure;
    }
  }
  if (MPI_Bcast(&code, 1, MPI_INT, 0, comm) != MPI_SUCCESS)
    throw std::runtime_error("MPI: MPI_Bcast failed");
  return static_cast<ExitCode>(code);
}

void remove_old_comparison(const std::filesystem::path& directory) {
  for (const char* name : {comparison_file, comparison_plot}) {
    std::error_code error;
    std::filesystem::remove(directory / name, error);
    if (error) {
      throw OutputError(fmt::format("cannot remove the old results in {}: {}", directory.string(),
                                    error.message()));
    }
  }
}

}  // namespace

ComparisonResult compare_integrators(const std::vector<Variant>& variants,
                                     const std::filesystem::path& directory, bool force,
                                     MPI_Comm comm) {
  ComparisonResult result;
  result.exit_code = on_root(comm, [&] { remove_old_comparison(directory); });
  if (result.exit_code != exit_success) return result;

  std::vector<Contender> contenders;  // rank 0's
  std::size_t failures = 0;
  for (const Variant& variant : variants) {
    const std::size_t number = result.finished.size() + 1;
    on_root(comm, [&] {
      fmt::print(stderr, "{}, {} of {}\n", variant.integrator, number, variants.size());
    });
    const Scenario scenario = parse_scenario(variant.scenario, "scenario.toml");
    const LatticeSetup setup = lattice_setup(scenario);
    const RunOptions options{directory / variant.integrator, variant.scenario, force, true};
    RunResult run = run_simulation(scenario, setup, options, comm);
    if (run.exit_code != exit_success && run.exit_code != exit_blow_up) {
      result.exit_code = run.exit_code;
      return result;
    }
    result.finished.push_back(variant.integrator);
    if (run.exit_code == exit_blow_up) ++failures;
    if (run.summary) {
      contenders.push_back({variant.integrator, *std::move(run.summary), std::move(run.samples)});
      const Summary& summary = contenders.back().summary;
      fmt::print(stderr, "{}: {}, {}\n", variant.integrator, to_string(summary.status),
                 duration_text(summary.wall_time));
    }
    if (run.interrupted) break;
  }
  if (failures == result.finished.size()) result.exit_code = exit_blow_up;
  const ExitCode written = on_root(comm, [&] {
    fmt::print("{}", table(contenders));
    for (std::size_t n = result.finished.size(); n < variants.size(); ++n)
      fmt::print("{}: not run, since a signal came before\n", variants[n].integrator);
    write_atomically(directory / comparison_file, to_json(contenders));
    fmt::print("results in {}\n", directory.string());
  });
  if (written != exit_success) result.exit_code = written;
  return result;
}

}  // namespace ductile::drivers
