// `ductile report`: a study laid beside the paper.
#pragma once

#include <string>

#include "commands/command.hpp"

namespace ductile::drivers {

class ReportCommand final : public Command {
 public:
  CLI::App* declare(CLI::App& program) override;
  /// Leaves the report to be made when MPI is down.
  int execute(MPI_Comm comm, Afterwards& afterwards) override;

 private:
  std::string directory_;
  std::string file_;
  bool without_films_ = false;
};

}  // namespace ductile::drivers
