#include "commands/check.hpp"

#include <cstdio>
#include <limits>

#include "checks/read_case.hpp"
#include "checks/report.hpp"
#include "checks/speed.hpp"
#include "commands/input.hpp"
#include "output/say.hpp"

namespace ductile::drivers {

CLI::App* CheckCommand::declare(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("check", "Validate a scenario file and say what the run would be");
  command->add_option("FILE", file_, "The scenario, TOML")->required()->type_name("");
  command->add_flag("--thorough", thorough_,
                    "Predict the stability of capsules also where that takes more than 0.3 s");
  scenario_.declare(*command);
  return command;
}

Case CheckCommand::prepare() const {
  return load_case(file_, scenario_.overrides());
}

int CheckCommand::execute(MPI_Comm comm, Afterwards& /*afterwards*/) {
  return with_input(comm, [this] {
    const double patience = thorough_ ? std::numeric_limits<double>::infinity() : usual_patience;
    say(stdout, report(prepare(), core_count(), known_speed(), patience));
  });
}

}  // namespace ductile::drivers
