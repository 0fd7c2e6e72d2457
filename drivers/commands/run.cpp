#include "commands/run.hpp"

#include <fmt/format.h>

#include <set>
#include <string>

#include "checks/read_case.hpp"
#include "commands/input.hpp"
#include "output/outcome.hpp"
#include "output/plot.hpp"
#include "run/petsc_options.hpp"
#include "run/run.hpp"
#include "scenario/errors.hpp"
#include "scenario/text.hpp"
#include "scenario/writer.hpp"

namespace ductile::drivers {

std::optional<double> walltime_of(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const std::optional<double> seconds = parsed_duration(text);
  constexpr double least = 5;  // a checkpoint, summary and picture take of it
  if (!seconds || !(*seconds >= least)) {
    throw InputError(
        fmt::format("--max-walltime {}: must be a time of at least 5s, such as 90s, 30m, "
                    "11.5h, 2d or 11:30:00",
                    text));
  }
  return seconds;
}

void SingleRun::declare_run(CLI::App& command) {
  command.add_flag("--profile", profile_,
                   "Show the time by part of every rank, and put it into summary.json");
  command
      .add_option(
          "--max-walltime", max_walltime_,
          "Time on the clock after which the run writes a checkpoint and ends with exit code "
          "6: 90s, 30m, 11.5h, 2d, or HH:MM:SS; counted from the start of the program")
      ->type_name("TIME");
  format_.declare(command, "Of the picture at the end, trajectory.FORMAT: png by default");
}

void SingleRun::declare_shared(CLI::App& command, const std::string& usual_directory) {
  scenario_.declare(command);
  output_.declare(command, usual_directory);
  declare_run(command);
}

int SingleRun::execute(MPI_Comm comm, Afterwards& afterwards) {
  std::string scenario;
  std::filesystem::path directory;     // rank 0's
  std::set<std::string> read_options;  // rank 0's
  std::vector<std::string> warnings;   // rank 0's
  const Ranks ranks = ranks_of(comm);
  const int code = with_input(comm, [&] {
    static_cast<void>(max_walltime());  // refused here if at all
    const Request request = prepare();
    require_memory(request.given, ranks);
    read_options = try_petsc_options(request.given);
    warnings = advise({{"", request.given}}).front();
    directory = request.directory;
    scenario = resolved_toml(request.given.scenario);
  });
  if (code != exit_success) return code;
  const Case given = shared_case(scenario, comm);
  if (!enough_planes(given, comm)) return exit_bad_input;
  const RunResult result = run_case(
      given,
      {directory, scenario, force(), resumes(), max_walltime(), profile(), warnings, read_options},
      comm);
  if (result.summary) {
    print_outcome(*result.summary, directory);
    // Without bodies there is nothing to draw. Who sent a signal may send a last one soon.
    if (result.interrupted && !given.plan.bodies.empty()) {
      plot_trajectory(directory, format_.format_or_usual());
    } else if (!given.plan.bodies.empty()) {
      afterwards.trajectories.push_back(directory);
      afterwards.format = format_.format_or_usual();
    }
  }
  return result.exit_code;
}

CLI::App* RunCommand::declare(CLI::App& program) {
  CLI::App* command = program.add_subcommand("run", "Run a scenario file");
  command->add_option("FILE", file_, "The scenario, TOML; see ductile keys")
      ->required()
      ->type_name("");
  declare_shared(*command, "runs/NAME by default, with what --set has changed");
  return command;
}

SingleRun::Request RunCommand::prepare() const {
  const std::vector<Override> overrides = scenario().overrides();
  Request request{load_case(file_, overrides), {}};
  const Scenario& resolved = request.given.scenario;
  request.directory = output().directory(std::filesystem::path("runs") /
                                         run_name(resolved.name, resolved, overrides));
  return request;
}

}  // namespace ductile::drivers
