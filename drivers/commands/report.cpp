#include "commands/report.hpp"

#include <vector>

#include "output/script.hpp"
#include "run/exit_code.hpp"
#include "run/root.hpp"

namespace ductile::drivers {

CLI::App* ReportCommand::declare(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "report", "Lay the paper's study, as `ductile.sh reproduce` computes it, beside the paper");
  command->add_option("DIR", directory_, "Directory of the study, all computed or in part")
      ->required()
      ->type_name("");
  command->add_option("-o,--output", file_, "The report, HTML; report.html in DIR by default")
      ->type_name("FILE");
  command->add_flag("--no-films", without_films_, "Draw neither films nor shapes");
  command->footer(
      "Writes DIR/paper.json too, all numbers of the report, and DIR/figures. Takes Debian's\n"
      "packages python3-vtk9, xvfb, ffmpeg and python3-jinja2.");
  return command;
}

int ReportCommand::execute(MPI_Comm comm, Afterwards& afterwards) {
  if (rank_in(comm) != 0) return exit_success;
  std::vector<std::string> words;
  if (!file_.empty()) words.push_back("--output=" + file_);
  if (without_films_) words.emplace_back("--no-films");
  words.insert(words.end(), {"--", directory_});
  afterwards.work = [words] { return carry_out("report.py", words); };
  return exit_success;
}

}  // namespace ductile::drivers
