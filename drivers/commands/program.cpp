#include "commands/program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string_view>
#include <utility>

#include "commands/bench.hpp"
#include "commands/campaign.hpp"
#include "commands/check.hpp"
#include "commands/compare.hpp"
#include "commands/film.hpp"
#include "commands/keys.hpp"
#include "commands/pair.hpp"
#include "commands/plot.hpp"
#include "commands/report.hpp"
#include "commands/resume.hpp"
#include "commands/run.hpp"
#include "output/say.hpp"
#include "output/version.hpp"
#include "run/exit_code.hpp"
#include "run/root.hpp"
#include "scenario/errors.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {
namespace {

constexpr std::string_view about =
    "Particles and capsules in inertial microfluidics: a lattice-Boltzmann fluid, elastic capsules "
    "and rigid bodies, coupled by the immersed-boundary method.";

constexpr std::string_view footer =
    "Exit codes: 0 success, 1 the run could not be done, 2 wrong input (nothing is written),\n"
    "3 the fluid or a body became unstable (of compare: with every integrator),\n"
    "4 surfaces of bodies crossed, or a body came to a wall, 5 a signal ended the run,\n"
    "6 --max-walltime did; `ductile resume` goes on after 5 and 6, and after 4 where surfaces of\n"
    "bodies crossed and run.stop_at_contact is false now.\n"
    "Under mpirun the channel is shared among the ranks; results do not depend on their number.\n"
    "`ductile COMMAND --help` tells more about a command.";

std::string version_text() {
  std::string text;
  for (const auto& [name, version] : versions()) text += fmt::format("{} {}\n", name, version);
  return text;
}

/// CLI11's complaint as one line, with the option or command that may have been meant.
std::string usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = &app;
  std::string name = "ductile";
  if (!app.get_subcommands().empty()) {
    command = app.get_subcommands().front();
    name += " " + command->get_name();
  }
  const std::vector<std::string> extras = app.remaining(true);
  if (!extras.empty()) {
    std::vector<std::string> known;
    for (const CLI::Option* option : command->get_options())
      for (const std::string& word : option->get_lnames()) known.push_back("--" + word);
    for (const CLI::App* sub : command->get_subcommands(nullptr)) known.push_back(sub->get_name());
    std::string hint = suggestion(extras.front(), {known.begin(), known.end()});
    return fmt::format("{} {}: not understood;{}", name, extras.front(),
                       hint.empty() ? fmt::format(" see {} --help", name) : hint);
  }
  std::string what = error.what();
  std::replace(what.begin(), what.end(), '\n', ' ');
  return fmt::format("{}: {}; see {} --help", name, what, name);
}

/// Rank 0's arguments, on every rank. Collective.
std::vector<std::string> broadcast_arguments(const std::vector<std::string>& arguments,
                                             MPI_Comm comm) {
  std::string packed;
  for (const std::string& argument : arguments) packed += argument + '\0';
  broadcast(packed, comm);
  std::vector<std::string> all;
  for (std::size_t begin = 0; begin < packed.size(); begin = packed.find('\0', begin) + 1)
    all.push_back(packed.substr(begin, packed.find('\0', begin) - begin));
  return all;
}

}  // namespace

std::vector<std::unique_ptr<Command>> all_commands() {
  std::vector<std::unique_ptr<Command>> commands;
  commands.push_back(std::make_unique<RunCommand>());
  commands.push_back(std::make_unique<PairCommand>());
  commands.push_back(std::make_unique<ResumeCommand>());
  commands.push_back(std::make_unique<CompareCommand>());
  commands.push_back(std::make_unique<CampaignCommand>());
  commands.push_back(std::make_unique<PlotCommand>());
  commands.push_back(std::make_unique<FilmCommand>());
  commands.push_back(std::make_unique<ReportCommand>());
  commands.push_back(std::make_unique<CheckCommand>());
  commands.push_back(std::make_unique<BenchCommand>());
  commands.push_back(std::make_unique<KeysCommand>());
  return commands;
}

CommandLine::CommandLine(const std::vector<std::string>& arguments)
    : program_(std::string(about), "ductile"), commands_(all_commands()) {
  program_.footer(std::string(footer));
  bool version = false;
  program_.add_flag("--version", version,
                    "Versions of the program, the compiler and the libraries");
  program_.require_subcommand(0, 1);
  std::vector<CLI::App*> declared;
  for (const auto& command : commands_) declared.push_back(command->declare(program_));
  try {
    program_.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::CallForHelp&) {
    text_ = program_.help();
    return;
  } catch (const CLI::ParseError& error) {
    throw InputError(usage_error(program_, error));
  }
  if (version) {
    text_ = version_text();
    return;
  }
  const auto parsed = std::ranges::find_if(declared, [](CLI::App* app) { return app->parsed(); });
  if (parsed == declared.end()) throw InputError("ductile: no command given; see ductile --help");
  // As from a variable of the shell that is not set: nothing is left to guess.
  for (const CLI::Option* option : (*parsed)->get_options()) {
    if (std::ranges::find(option->results(), "") != option->results().end()) {
      throw InputError(fmt::format("ductile {}: {} is empty: give it a value, or leave it out",
                                   (*parsed)->get_name(), option->get_name()));
    }
  }
  command_ = commands_[static_cast<std::size_t>(parsed - declared.begin())].get();
}

int run_program(const std::vector<std::string>& arguments, MPI_Comm comm, Afterwards& afterwards) {
  const bool root = rank_in(comm) == 0;
  try {
    const CommandLine line(broadcast_arguments(arguments, comm));
    if (line.command() != nullptr) return line.command()->execute(comm, afterwards);
    if (root) say(stdout, line.text());
    return exit_success;
  } catch (const InputError& error) {
    if (root) say(stderr, "{}\n", error.what());
    return exit_bad_input;
  }
}

}  // namespace ductile::drivers
