#include "commands/film.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "output/script.hpp"
#include "run/exit_code.hpp"
#include "run/root.hpp"

namespace ductile::drivers {

CLI::App* FilmCommand::declare(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("film", "Make films of bodies in the channel, in three dimensions");
  command
      ->add_option("DIR", directory_,
                   "Directory of a run, or of a campaign, of whose runs each gets its film")
      ->required()
      ->type_name("");
  command->add_option("-o,--output", file_, "The film of a run, an MP4; film.mp4 in DIR by default")
      ->type_name("FILE");
  command
      ->add_option("--colour", colour_,
                   "What colours show: body, the usual; speed, of the surface against the body's "
                   "mean; force, on the fluid by area; x, the place across the channel")
      ->type_name("WHAT");
  command->add_option("--fps", rate_, "Pictures a second; 20 by default")->type_name("N");
  command->add_option("--size", size_, "In pixels, even numbers; 800x300 by default")
      ->type_name("WxH");
  command->add_option("--from", from_, "W^2/nu: First time that is shown")->type_name("T");
  command->add_option("--to", to_, "W^2/nu: Last time that is shown")->type_name("T");
  command
      ->add_option("--speed", speed_,
                   "W^2/nu: What a second shows; by default each frame is shown once")
      ->type_name("S");
  command->footer(
      "The frames are those of run.h5, output.surfaces_every apart. Takes Debian's packages\n"
      "python3-vtk9, xvfb and ffmpeg.");
  return command;
}

int FilmCommand::execute(MPI_Comm comm, Afterwards& afterwards) {
  if (rank_in(comm) != 0) return exit_success;
  std::vector<std::string> words;
  for (const auto& [option, text] :
       {std::pair("output", file_), std::pair("colour", colour_), std::pair("size", size_)}) {
    if (!text.empty()) words.push_back(fmt::format("--{}={}", option, text));
  }
  for (const auto& [option, number] : {std::pair("fps", rate_), std::pair("from", from_),
                                       std::pair("to", to_), std::pair("speed", speed_)}) {
    if (number) words.push_back(fmt::format("--{}={}", option, *number));
  }
  words.insert(words.end(), {"--", directory_});
  afterwards.work = [words] { return carry_out("film.py", words); };
  return exit_success;
}

}  // namespace ductile::drivers
