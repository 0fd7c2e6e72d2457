// `ductile film`: films of bodies in the channel.
#pragma once

#include <optional>
#include <string>

#include "commands/command.hpp"

namespace ductile::drivers {

class FilmCommand final : public Command {
 public:
  CLI::App* declare(CLI::App& program) override;
  /// Leaves the film to be made when MPI is down.
  int execute(MPI_Comm comm, Afterwards& afterwards) override;

 private:
  std::string directory_;
  std::string file_;
  std::string colour_;
  std::string size_;
  std::optional<double> rate_;
  std::optional<double> from_;
  std::optional<double> to_;
  std::optional<double> speed_;
};

}  // namespace ductile::drivers
