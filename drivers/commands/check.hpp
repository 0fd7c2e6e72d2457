// `ductile check`: what a scenario would be when run.
#pragma once

#include <string>

#include "commands/arguments.hpp"
#include "commands/command.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

class CheckCommand final : public Command {
 public:
  CLI::App* declare(CLI::App& program) override;
  /// What the options ask about. Throws InputError. Rank 0.
  [[nodiscard]] Case prepare() const;
  int execute(MPI_Comm comm, Afterwards& afterwards) override;

 private:
  std::string file_;
  bool thorough_ = false;
  ScenarioArguments scenario_;
};

}  // namespace ductile::drivers
