#include "commands/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <set>

#include "checks/read_case.hpp"
#include "commands/input.hpp"
#include "ductile/membrane/integrator.hpp"
#include "output/comparison.hpp"
#include "output/plot.hpp"
#include "output/run_directory.hpp"
#include "output/say.hpp"
#include "run/petsc_options.hpp"
#include "run/root.hpp"
#include "run/run.hpp"
#include "run/signals.hpp"
#include "scenario/errors.hpp"
#include "scenario/text.hpp"
#include "scenario/writer.hpp"

namespace ductile::drivers {
namespace {

constexpr const char* comparison_file = "compare.json";
constexpr const char* comparison_plot = "compare.";

std::vector<std::string> parsed_integrators(const std::string& argument) {
  const std::vector<std::string_view> known = membrane::integrator_names();
  std::vector<std::string> names(1);
  for (const char c : argument) {
    if (c == ',') {
      names.emplace_back();
    } else {
      names.back() += c;
    }
  }
  const auto refuse = [&argument](const std::string& complaint) {
    throw InputError(fmt::format("--integrators {}: {}", argument, complaint));
  };
  for (auto name = names.begin(); name != names.end(); ++name) {
    if (std::find(known.begin(), known.end(), *name) == known.end()) {
      const std::string hint = suggestion(*name, known);
      refuse(fmt::format("unknown integrator {};{}", in_quotes(*name),
                         hint.empty() ? " the integrators are " + joined(known) : hint));
    }
    if (std::find(names.begin(), name, *name) != name) refuse(*name + " is there twice");
  }
  if (names.size() < 2) {
    refuse(fmt::format("name at least two, with commas between: the integrators are {}",
                       fmt::join(known, ", ")));
  }
  return names;
}

/// The text's case, all of its capsules with the integrator of that name.
Case with_integrator(const std::string& text, const std::string& file,
                     std::vector<Override> overrides, const std::vector<BodyOptions>& bodies,
                     const std::string& name) {
  const std::string origin = "--integrators " + name;
  overrides.push_back({"membrane.integrator", name, origin});
  for (const BodyOptions& body : bodies) {
    if (body.kind == BodyKind::capsule)
      overrides.push_back({"body." + body.name + ".integrator", name, origin});
  }
  return parse_case(text, file, overrides);
}

void remove_old_comparison(const std::filesystem::path& directory) {
  std::vector<std::string> names = {comparison_file};
  for (const std::string_view format : picture_formats)
    names.push_back(fmt::format("{}{}", comparison_plot, format));
  for (const std::string& name : names) {
    std::error_code error;
    std::filesystem::remove(directory / name, error);
    if (error) {
      throw OutputError(fmt::format("cannot remove the old results in {}: {}", directory.string(),
                                    error.message()));
    }
  }
}

/// What to compare, resolved: names on all ranks, and the directory on rank 0.
struct Variants {
  std::vector<std::string> integrators;
  std::vector<std::string> scenarios;
  std::filesystem::path directory;
  std::vector<std::vector<std::string>> warnings;  ///< of before the runs; on rank 0
  std::set<std::string> read_options;              ///< of PETSc, by any of them; on rank 0
};

/// What came of the runs.
struct Results {
  /// Of a run that could not be done; else of all runs, where they end in the same way.
  int exit_code = exit_success;
  std::vector<std::string> finished;  ///< integrators whose runs have left results
  std::vector<Contender> contenders;  ///< rank 0's
};

/// Whether a run that ends so has something to compare.
bool has_results(int exit_code) {
  return exit_code == exit_success || exit_code == exit_blow_up || exit_code == exit_contact ||
         exit_code == exit_interrupted;
}

Results run_all(Variants& variants, bool force, MPI_Comm comm) {
  Results results;
  std::set<int> codes;
  for (std::size_t n = 0; n < variants.integrators.size(); ++n) {
    const std::string& integrator = variants.integrators[n];
    const bool root = rank_in(comm) == 0;
    if (root) say(stderr, "{}, {} of {}\n", integrator, n + 1, variants.integrators.size());
    const Case given = shared_case(variants.scenarios[n], comm);
    RunResult run = run_case(given,
                             {.directory = variants.directory / integrator,
                              .scenario_text = variants.scenarios[n],
                              .force = force,
                              .profile = true,
                              .warnings = root ? variants.warnings[n] : std::vector<std::string>(),
                              .read_options = variants.read_options},
                             comm);
    if (!has_results(run.exit_code)) {
      results.exit_code = run.exit_code;
      return results;
    }
    results.finished.push_back(integrator);
    codes.insert(run.exit_code);
    if (run.summary) {
      say(stderr, "{}: {}, {}\n", integrator, to_string(run.summary->status),
          duration_text(run.summary->wall_time));
      results.contenders.push_back({integrator, *std::move(run.summary), std::move(run.samples)});
    }
    if (run.interrupted) {
      results.exit_code = run.exit_code;
      return results;
    }
  }
  if (codes.size() == 1) results.exit_code = *codes.begin();
  return results;
}

int write_comparison(const Results& results, const Variants& variants, MPI_Comm comm) {
  return on_root(comm, exit_failure, [&]() -> int {
    say(stdout, "{}", table(results.contenders));
    for (std::size_t n = results.finished.size(); n < variants.integrators.size(); ++n)
      say(stdout, "{}: not run, since a signal came before\n", variants.integrators[n]);
    write_atomically(variants.directory / comparison_file, to_json(results.contenders));
    say(stdout, "results in {}\n", variants.directory.string());
    return exit_success;
  });
}

}  // namespace

CLI::App* CompareCommand::declare(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "compare", "Run a scenario file with several membrane integrators, side by side");
  command->add_option("FILE", file_, "The scenario, TOML")->required()->type_name("");
  command
      ->add_option("--integrators", integrators_,
                   fmt::format("What to compare, with commas between; all capsules take it, "
                               "whatever the file says: {}",
                               joined(membrane::integrator_names())))
      ->required()
      ->type_name("NAME,NAME,...");
  scenario_.declare(*command);
  output_.declare(*command, "runs/NAME_compare by default, with a directory for each integrator");
  format_.declare(*command,
                  "Of the pictures, compare.FORMAT and trajectory.FORMAT: png by default");
  return command;
}

CompareCommand::Request CompareCommand::prepare() const {
  const std::vector<std::string> names = parsed_integrators(integrators_);
  const std::vector<Override> overrides = scenario_.overrides();
  const std::string text = read_text(file_);
  const Scenario scenario = parse_case(text, file_, overrides).scenario;
  const bool any_capsule = std::ranges::any_of(
      scenario.bodies, [](const BodyOptions& body) { return body.kind == BodyKind::capsule; });
  if (!any_capsule)
    throw InputError(file_ + ": has no capsule, and nothing else has a membrane to advance");
  Request request;
  for (const std::string& name : names) {
    request.cases.emplace_back(name,
                               with_integrator(text, file_, overrides, scenario.bodies, name));
  }
  request.directory = output_.directory(
      std::filesystem::path("runs") / (run_name(scenario.name, scenario, overrides) + "_compare"));
  return request;
}

int CompareCommand::execute(MPI_Comm comm, Afterwards& afterwards) {
  Variants variants;
  const Ranks ranks = ranks_of(comm);
  const int code = with_input(comm, [&] {
    const Request request = prepare();
    for (const auto& [name, given] : request.cases) {
      require_memory(given, ranks);
      variants.read_options.merge(try_petsc_options(given));
      variants.scenarios.push_back(resolved_toml(given.scenario));
    }
    variants.warnings = advise(request.cases);
    variants.directory = request.directory;
  });
  if (code != exit_success) return code;
  variants.integrators = parsed_integrators(integrators_);
  variants.scenarios.resize(variants.integrators.size());
  // All have the same lattice.
  if (!enough_planes(shared_case(variants.scenarios.front(), comm), comm)) return exit_bad_input;
  const int removed = on_root(comm, exit_failure, [&]() -> int {
    remove_old_comparison(variants.directory);
    return exit_success;
  });
  if (removed != exit_success) return removed;
  const Signals signals;  // also between two runs of a caller that has none
  Results results = run_all(variants, output_.force(), comm);
  if (has_results(results.exit_code)) {
    const int written = write_comparison(results, variants, comm);
    if (written != exit_success) results.exit_code = written;
  }
  if (rank_in(comm) == 0) {
    afterwards.format = format_.format_or_usual();
    for (const std::string& name : results.finished)
      afterwards.trajectories.push_back(variants.directory / name);
    if (has_results(results.exit_code)) afterwards.comparisons.push_back(variants.directory);
  }
  return results.exit_code;
}

}  // namespace ductile::drivers
