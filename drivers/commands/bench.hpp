// `ductile bench`: measures the machine.
#pragma once

#include "commands/bench_measure.hpp"
#include "commands/command.hpp"

namespace ductile::drivers {

class BenchCommand final : public Command {
 public:
  CLI::App* declare(CLI::App& program) override;
  int execute(MPI_Comm comm, Afterwards& afterwards) override;

 private:
  BenchOptions options_;
};

}  // namespace ductile::drivers
