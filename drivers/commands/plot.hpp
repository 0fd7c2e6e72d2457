// `ductile plot`: pictures of results.
#pragma once

#include <string>
#include <vector>

#include "commands/arguments.hpp"
#include "commands/command.hpp"

namespace ductile::drivers {

class PlotCommand final : public Command {
 public:
  CLI::App* declare(CLI::App& program) override;
  /// Leaves the picture to be drawn when MPI is down.
  int execute(MPI_Comm comm, Afterwards& afterwards) override;

 private:
  std::vector<std::string> directories_;
  std::string file_;
  FormatArgument format_;
  bool map_ = false;
};

}  // namespace ductile::drivers
