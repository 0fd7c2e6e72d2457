// `ductile compare`: one scenario, run with several membrane integrators.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "commands/arguments.hpp"
#include "commands/command.hpp"
#include "run/exit_code.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

class CompareCommand final : public Command {
 public:
  struct Request {
    /// By name, the scenario with all its capsules taking that integrator.
    std::vector<std::pair<std::string, Case>> cases;
    std::filesystem::path directory;
  };
  CLI::App* declare(CLI::App& program) override;
  /// What the options ask for. Throws InputError. Rank 0.
  [[nodiscard]] Request prepare() const;
  /// Runs the cases one after the other, each into a directory of its own, then prints the
  /// comparison and writes compare.json beside them. A signal ends the run at hand and leaves out
  /// those still to come. A run that blew up or ended by a contact is a result: the exit
  /// code says so only if all did.
  int execute(MPI_Comm comm, Afterwards& afterwards) override;

 private:
  std::string file_;
  std::string integrators_;
  ScenarioArguments scenario_;
  OutputArguments output_;
  FormatArgument format_;
};

}  // namespace ductile::drivers
