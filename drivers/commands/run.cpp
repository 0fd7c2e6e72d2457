#include "commands/run.hpp"

#include <set>
#include <string>

#include "checks/read_case.hpp"
#include "commands/input.hpp"
#include "output/outcome.hpp"
#include "run/petsc_options.hpp"
#include "run/run.hpp"
#include "scenario/writer.hpp"

namespace ductile::drivers {

void SingleRun::declare_shared(CLI::App& command, const std::string& usual_directory) {
  scenario_.declare(command);
  output_.declare(command, usual_directory);
  command.add_flag("--profile", profile_,
                   "Show the time by part of every rank, and put it into summary.json");
}

int SingleRun::execute(MPI_Comm comm, Pictures& pictures) {
  std::string scenario;
  std::filesystem::path directory;     // rank 0's
  std::set<std::string> read_options;  // rank 0's
  std::vector<std::string> warnings;   // rank 0's
  const int code = with_input(comm, [&] {
    const Request request = prepare();
    read_options = try_petsc_options(request.given);
    warnings = advise({{"", request.given}}).front();
    directory = request.directory;
    scenario = resolved_toml(request.given.scenario);
  });
  if (code != exit_success) return code;
  const Case given = shared_case(scenario, comm);
  if (!enough_planes(given, comm)) return exit_bad_input;
  const RunResult result =
      run_case(given, {directory, scenario, force(), profile(), warnings, read_options}, comm);
  if (result.summary) {
    print_outcome(*result.summary, directory);
    // Without bodies there is nothing to draw.
    if (!given.plan.bodies.empty()) pictures.trajectories.push_back(directory);
  }
  return result.exit_code;
}

CLI::App* RunCommand::declare(CLI::App& program) {
  CLI::App* command = program.add_subcommand("run", "Run a scenario file");
  command->add_option("FILE", file_, "The scenario, TOML; see ductile keys")
      ->required()
      ->type_name("");
  declare_shared(*command, "runs/NAME by default");
  return command;
}

SingleRun::Request RunCommand::prepare() const {
  Request request{load_case(file_, scenario().overrides()), {}};
  request.directory =
      output().directory(std::filesystem::path("runs") / request.given.scenario.name);
  return request;
}

}  // namespace ductile::drivers
