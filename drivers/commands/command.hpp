// What the program can be told to do: one file a command, which holds its options and its
// execution.
#pragma once

#include <mpi.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "output/plot.hpp"

namespace ductile::drivers {

/// What is left to do when MPI is down, for it takes processes of their own: pictures, and the rest
/// of a command. Filled on rank 0.
struct Afterwards {
  std::vector<std::filesystem::path> trajectories;  ///< pictures of runs in these directories
  std::vector<std::filesystem::path> comparisons;
  std::string format;              ///< of all these
  std::optional<Picture> picture;  ///< that was asked for, and whose failure is the program's
  std::function<int()> work;       ///< gives the exit code
};

class Command {
 public:
  Command() = default;
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;
  virtual ~Command() = default;

  /// Adds the subcommand with its options, which are then members of this object. All ranks parse
  /// the same arguments; files are rank 0's to read.
  virtual CLI::App* declare(CLI::App& program) = 0;
  /// Does it; the exit code is the same on all ranks. Collective.
  virtual int execute(MPI_Comm comm, Afterwards& afterwards) = 0;
};

/// Those of the program, in the order in which its help lists them: program.cpp has one line for
/// each.
std::vector<std::unique_ptr<Command>> all_commands();

}  // namespace ductile::drivers
