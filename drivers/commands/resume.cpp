#include "commands/resume.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <vector>

#include "checks/read_case.hpp"
#include "scenario/errors.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {

CLI::App* ResumeCommand::declare(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "resume", "Go on with a run that has ended, however it has, on any number of ranks");
  command->add_option("DIR", directory_, "The directory of its results")->required()->type_name("");
  until_given_ =
      command
          ->add_option(
              "--until", until_,
              "Go on to this time, in W^2/nu, also if the verdict is certain before: another "
              "run.time_limit, and run.until_decided = false")
          ->type_name("NUMBER");
  declare_run(*command);
  return command;
}

SingleRun::Request ResumeCommand::prepare() const {
  const std::filesystem::path scenario = std::filesystem::path(directory_) / "scenario.toml";
  std::error_code error;
  if (directory_.empty() || !std::filesystem::is_regular_file(scenario, error)) {
    throw InputError(
        fmt::format("{}: has no scenario.toml{}, and so no run to go on with: give the "
                    "directory of a run's results",
                    in_quotes(shortened(directory_, 200)),
                    error && error != std::errc::no_such_file_or_directory
                        ? fmt::format(" ({})", error.message())
                        : ""));
  }
  std::vector<Override> overrides;
  if (until_given_->count() > 0) {
    const std::string origin = "--until " + until_;
    overrides = {{"run.time_limit", until_, origin}, {"run.until_decided", "false", origin}};
  }
  return {load_case(scenario, overrides), directory_};
}

}  // namespace ductile::drivers
