#include "commands/keys.hpp"

#include <cstdio>

#include "commands/input.hpp"
#include "output/say.hpp"
#include "scenario/writer.hpp"

namespace ductile::drivers {

CLI::App* KeysCommand::declare(CLI::App& program) {
  return program.add_subcommand(
      "keys", "All keys of a scenario file: default, type, bounds, unit and meaning");
}

int KeysCommand::execute(MPI_Comm comm, Afterwards& /*afterwards*/) {
  return with_input(comm, [] { say(stdout, describe_keys()); });
}

}  // namespace ductile::drivers
