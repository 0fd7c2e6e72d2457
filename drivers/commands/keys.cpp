#include "commands/keys.hpp"

#include <cstdio>

#include "commands/input.hpp"
#include "scenario/writer.hpp"

namespace ductile::drivers {

CLI::App* KeysCommand::declare(CLI::App& program) {
  return program.add_subcommand(
      "keys", "All keys of a scenario file: default, type, bounds, unit and meaning");
}

int KeysCommand::execute(MPI_Comm comm, Pictures& /*pictures*/) {
  return with_input(comm, [] { std::fputs(describe_keys().c_str(), stdout); });
}

}  // namespace ductile::drivers
