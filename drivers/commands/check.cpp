#include "commands/check.hpp"

#include <cstdio>
#include <thread>

#include "checks/read_case.hpp"
#include "checks/report.hpp"
#include "commands/input.hpp"

namespace ductile::drivers {

CLI::App* CheckCommand::declare(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("check", "Validate a scenario file and say what the run would be");
  command->add_option("FILE", file_, "The scenario, TOML")->required()->type_name("");
  scenario_.declare(*command);
  return command;
}

Case CheckCommand::prepare() const {
  return load_case(file_, scenario_.overrides());
}

int CheckCommand::execute(MPI_Comm comm, Pictures& /*pictures*/) {
  return with_input(comm, [this] {
    const int cores = static_cast<int>(std::thread::hardware_concurrency());
    std::fputs(report(prepare(), cores, known_speed()).c_str(), stdout);
  });
}

}  // namespace ductile::drivers
