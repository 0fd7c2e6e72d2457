// `ductile keys`: the keys of a scenario file.
#pragma once

#include "commands/command.hpp"

namespace ductile::drivers {

class KeysCommand final : public Command {
 public:
  CLI::App* declare(CLI::App& program) override;
  int execute(MPI_Comm comm, Afterwards& afterwards) override;
};

}  // namespace ductile::drivers
