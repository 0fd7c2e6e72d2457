// The command line, as far as deciding which command it asks for.
#pragma once

#include <mpi.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "commands/command.hpp"

namespace ductile::drivers {

/// The program's arguments (without its name), parsed.
class CommandLine {
 public:
  /// Throws InputError. Reads and writes nothing.
  explicit CommandLine(const std::vector<std::string>& arguments);

  /// What --help or --version print; then there is no command.
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] Command* command() const { return command_; }

 private:
  CLI::App program_;
  std::vector<std::unique_ptr<Command>> commands_;
  std::string text_;
  Command* command_ = nullptr;
};

/// Does what the arguments of rank 0 ask for; the exit code is the same on all ranks. Collective.
int run_program(const std::vector<std::string>& arguments, MPI_Comm comm, Afterwards& afterwards);

}  // namespace ductile::drivers
