// The command line, as far as deciding what to do.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bench.hpp"
#include "scenario.hpp"

namespace ductile::drivers {

struct Command {
  enum class Action {
    print,    ///< `text`
    check,    ///< report on `scenario`
    run,      ///< run `scenario` into `directory`
    compare,  ///< run `scenario` with each of `integrators`, each into a directory in `directory`
    bench     ///< measure the machine as `bench` says
  };
  Action action = Action::print;
  std::string text;
  Scenario scenario;
  /// By name, the scenario with all its capsules taking that integrator.
  std::vector<std::pair<std::string, Scenario>> integrators;
  std::filesystem::path directory;
  bool force = false;    ///< replace a run that is in the directory
  bool profile = false;  ///< show the time by part
  BenchOptions bench;
};

/// What the arguments (without the program's name) ask for. Reads scenario files, writes nothing.
/// Throws InputError, also where a run would go into a directory that is not empty.
Command parse_command_line(const std::vector<std::string>& arguments);

}  // namespace ductile::drivers
