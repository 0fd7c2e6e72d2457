#include "commands/plot.hpp"

#include "run/exit_code.hpp"
#include "run/root.hpp"

namespace ductile::drivers {

CLI::App* PlotCommand::declare(CLI::App& program) {
  CLI::App* command = program.add_subcommand("plot", "Draw results: a run, several, or a campaign");
  command
      ->add_option("DIR", directories_,
                   "Directories of results: one of a run, a comparison or a campaign, or several")
      ->required()
      ->type_name("");
  command->add_option("-o,--output", file_, "The picture; its ending may say the format")
      ->type_name("FILE");
  format_.declare(*command, "Of the picture; png by default");
  command->add_flag("--map", map_,
                    "Of a campaign: what came of each case, over the one or two keys it sweeps");
  command->footer(
      "One run gives DIR/trajectory.FORMAT, a comparison DIR/compare.FORMAT, a campaign\n"
      "DIR/overlay.FORMAT, its cases over each other, or with --map DIR/map.FORMAT. Several are\n"
      "drawn over each other into overlay.FORMAT, told apart by what differs in their scenarios.");
  return command;
}

int PlotCommand::execute(MPI_Comm comm, Afterwards& afterwards) {
  if (rank_in(comm) == 0) {
    afterwards.picture =
        Picture{{directories_.begin(), directories_.end()}, format_.format(), file_, map_};
  }
  return exit_success;
}

}  // namespace ductile::drivers
