#include "commands/bench.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "checks/speed.hpp"
#include "run/exit_code.hpp"
#include "run/root.hpp"

namespace ductile::drivers {

CLI::App* BenchCommand::declare(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "bench", "Measure what this machine's memory allows, and how near the program comes to it");
  command->add_option("--nodes", options_.nodes, "Nodes across the channel, 90 by default")
      ->type_name("NUMBER")
      ->check(CLI::Range(24, 400));
  command->add_option("--repeats", options_.repeats, "Of each measurement, 9 by default")
      ->type_name("NUMBER")
      ->check(CLI::Range(1, 1000));
  command->add_flag("--json", options_.json, "Print JSON, with every repeat");
  command->footer(
      "Takes about two minutes; run it under mpirun, on a machine that does nothing else. With\n"
      "the default --nodes it keeps the speed of the fluid and what bodies cost, from\n"
      "which `ductile check` estimates durations.");
  return command;
}

int BenchCommand::execute(MPI_Comm comm, Afterwards& /*afterwards*/) {
  const BenchResult result = measure(options_, comm);
  if (rank_in(comm) != 0) return exit_success;
  std::fputs((options_.json ? json(result) : table(result)).c_str(), stdout);
  if (!is_representative(result)) {
    fmt::print(stderr,
               "not kept for `ductile check`: that takes the default --nodes, and no more "
               "ranks than cores\n");
  } else if (const auto file = keep_speed(speed_of(result))) {
    fmt::print(stderr, "kept for `ductile check` in {}\n", *file);
  } else {
    fmt::print(stderr, "warning: the speed could not be kept for `ductile check`\n");
  }
  return exit_success;
}

}  // namespace ductile::drivers
