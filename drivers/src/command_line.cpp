#include "command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <sstream>
#include <string_view>

#include "ductile/membrane/integrator.hpp"
#include "errors.hpp"
#include "keys.hpp"
#include "pairs.hpp"
#include "version.hpp"

namespace ductile::drivers {
namespace {

constexpr std::string_view about =
    "Particles and capsules in inertial microfluidics: a lattice-Boltzmann fluid, elastic capsules "
    "and rigid bodies, coupled by the immersed-boundary method.";

constexpr std::string_view footer =
    "Exit codes: 0 success, 1 the run could not be done, 2 wrong input (nothing is written),\n"
    "3 the fluid or a body became unstable (of compare: with every integrator).\n"
    "Under mpirun the channel is shared among the ranks; results do not depend on their number.\n"
    "`ductile COMMAND --help` tells more about a command.";

std::string version_text() {
  std::string text;
  for (const auto& [name, version] : versions()) text += fmt::format("{} {}\n", name, version);
  return text;
}

Override parsed_set(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw InputError(
        fmt::format("--set {}: must be KEY=VALUE, such as --set channel.nodes=48 or "
                    "--set body.lag.x=0.1",
                    argument));
  }
  return {argument.substr(0, equals), argument.substr(equals + 1), "--set " + argument};
}

/// `-name value -flag ...` as entries of [petsc]; values without blanks.
std::vector<Override> parsed_petsc(const std::string& argument) {
  std::istringstream words(argument);
  std::vector<Override> entries;
  for (std::string word; words >> word;) {
    const bool name = word.size() > 1 && word[0] == '-' &&
                      (std::isalpha(static_cast<unsigned char>(word[1])) != 0);
    if (name) {
      entries.push_back(
          {"petsc." + word.substr(1), "true", fmt::format("--petsc \"{}\": {}", argument, word)});
    } else if (!entries.empty() && entries.back().value == "true") {
      entries.back().value = in_quotes(word);
    } else {
      throw InputError(fmt::format(
          "--petsc \"{}\": {} is neither an option nor an option's value: write as for PETSc, "
          "such as --petsc \"-membrane_ksp_type bcgs -log_view\"",
          argument, word));
    }
  }
  return entries;
}

void require_free(const std::filesystem::path& directory, bool force) {
  std::error_code error;
  if (!std::filesystem::exists(directory, error)) return;
  if (!std::filesystem::is_directory(directory, error)) {
    throw InputError(
        fmt::format("{}: is not a directory: choose another with -o", directory.string()));
  }
  if (!force && !std::filesystem::is_empty(directory, error)) {
    throw InputError(fmt::format(
        "{}: is not empty: add --force to replace the run in it, or choose another with -o",
        directory.string()));
  }
}

std::string_view pair_scenario(const std::string& name) {
  std::vector<std::string_view> names;
  for (const auto& [known, text] : pair_scenarios()) {
    if (known == name) return text;
    names.push_back(known);
  }
  const std::string hint = suggestion(name, names);
  throw InputError(
      fmt::format("ductile pair {}: unknown pair;{}", name,
                  hint.empty() ? fmt::format(" the pairs are {}", fmt::join(names, ", ")) : hint));
}

std::vector<std::string> parsed_integrators(const std::string& argument) {
  const std::vector<std::string_view> known = membrane::integrator_names();
  std::vector<std::string> names(1);
  for (const char c : argument) {
    if (c == ',') {
      names.emplace_back();
    } else {
      names.back() += c;
    }
  }
  const auto refuse = [&argument](const std::string& complaint) {
    throw InputError(fmt::format("--integrators {}: {}", argument, complaint));
  };
  for (auto name = names.begin(); name != names.end(); ++name) {
    if (std::find(known.begin(), known.end(), *name) == known.end()) {
      const std::string hint = suggestion(*name, known);
      refuse(fmt::format(
          "unknown integrator {};{}", in_quotes(*name),
          hint.empty() ? fmt::format(" the integrators are {}", fmt::join(known, ", ")) : hint));
    }
    if (std::find(names.begin(), name, *name) != name) refuse(*name + " is there twice");
  }
  if (names.size() < 2) {
    refuse(fmt::format("name at least two, with commas between: the integrators are {}",
                       fmt::join(known, ", ")));
  }
  return names;
}

/// The file's scenario, all of its capsules with the integrator of that name.
Scenario with_integrator(const std::string& file, std::vector<Override> overrides,
                         const std::vector<BodyOptions>& bodies, const std::string& name) {
  const std::string origin = "--integrators " + name;
  overrides.push_back({"membrane.integrator", name, origin});
  for (const BodyOptions& body : bodies) {
    if (body.kind == BodyKind::capsule)
      overrides.push_back({"body." + body.name + ".integrator", name, origin});
  }
  return load_scenario(file, overrides);
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

}  // namespace

Command parse_command_line(const std::vector<std::string>& arguments) {
  CLI::App app{std::string(about), "ductile"};
  app.footer(std::string(footer));
  bool version = false;
  app.add_flag("--version", version, "Versions of the program, the compiler and the libraries");

  std::string file;
  std::vector<std::string> sets;
  std::vector<std::string> petsc;
  std::string directory;
  Command command;
  const auto add_set = [&sets, &petsc](CLI::App* sub) {
    sub->add_option("--set", sets,
                    "Another value for a key: --set channel.nodes=48, --set body.lag.x=0.1; may be "
                    "repeated")
        ->type_name("KEY=VALUE")
        ->take_all()
        ->allow_extra_args(false);
    sub->add_option(
           "--petsc", petsc,
           "Options of PETSc, as in [petsc]: --petsc \"-membrane_ksp_type bcgs -log_view\"; "
           "may be repeated")
        ->type_name("OPTIONS")
        ->take_all()
        ->allow_extra_args(false);
  };
  const auto add_output = [&](CLI::App* sub, const std::string& usual) {
    sub->add_option("-o,--output", directory, "Directory of the results; " + usual)
        ->type_name("DIR");
    sub->add_flag("--force", command.force, "Replace the results that are in the directory");
  };
  const auto add_profile = [&command](CLI::App* sub) {
    sub->add_flag("--profile", command.profile,
                  "Show the time by part of every rank, and put it into summary.json");
  };

  CLI::App* run = app.add_subcommand("run", "Run a scenario file");
  run->add_option("FILE", file, "The scenario, TOML; see ductile keys")->required()->type_name("");
  add_set(run);
  add_output(run, "runs/NAME by default");
  add_profile(run);

  CLI::App* pair = app.add_subcommand("pair", "Run one of the paper's pairs");
  std::string pair_name;
  std::string case_names;
  for (const auto& [name, text] : pair_scenarios())
    case_names += (case_names.empty() ? "" : ", ") + std::string(name);
  pair->add_option("CASE", pair_name, "The pair: " + case_names)->required()->type_name("");
  struct Shorthand {
    std::string option;
    std::string key;
    std::string meaning;
    std::string value;
  };
  std::vector<Shorthand> shorthands = {
      {"--x-lag", "body.lag.x", "Where the lagging particle starts across the channel, in W", ""},
      {"--nodes", "channel.nodes", "Nodes across the channel", ""},
      {"--tau", "fluid.tau", "Relaxation time", ""},
      {"--length", "channel.length", "Length of the channel, in W", ""},
      {"--time-limit", "run.time_limit", "When to stop at the latest, in W^2/nu", ""}};
  for (Shorthand& shorthand : shorthands) {
    pair->add_option(shorthand.option, shorthand.value,
                     fmt::format("{} ({})", shorthand.meaning, shorthand.key))
        ->type_name("NUMBER")
        ->required(shorthand.option == "--x-lag");
  }
  add_set(pair);
  add_output(pair, "runs/CASE_x-lag_X by default");
  add_profile(pair);

  CLI::App* compare = app.add_subcommand(
      "compare", "Run a scenario file with several membrane integrators, side by side");
  compare->add_option("FILE", file, "The scenario, TOML")->required()->type_name("");
  std::string integrators;
  compare
      ->add_option(
          "--integrators", integrators,
          fmt::format("What to compare, with commas between; all capsules take it, whatever "
                      "the file says: {}",
                      fmt::join(membrane::integrator_names(), ", ")))
      ->required()
      ->type_name("NAME,NAME,...");
  add_set(compare);
  add_output(compare, "runs/NAME_compare by default, with a directory for each integrator");

  CLI::App* check =
      app.add_subcommand("check", "Validate a scenario file and say what the run would be");
  check->add_option("FILE", file, "The scenario, TOML")->required()->type_name("");
  add_set(check);

  CLI::App* bench = app.add_subcommand(
      "bench", "Measure what this machine's memory allows, and how near the program comes to it");
  bench->add_option("--nodes", command.bench.nodes, "Nodes across the channel, 90 by default")
      ->type_name("NUMBER")
      ->check(CLI::Range(24, 400));
  bench->add_option("--repeats", command.bench.repeats, "Of each measurement, 9 by default")
      ->type_name("NUMBER")
      ->check(CLI::Range(1, 1000));
  bench->add_flag("--json", command.bench.json, "Print JSON, with every repeat");
  bench->footer(
      "Takes one to two minutes; run it under mpirun, on a machine that does nothing else. With\n"
      "the default --nodes it keeps the speed of the run with two capsules, from which\n"
      "`ductile check` estimates durations.");

  CLI::App* keys = app.add_subcommand(
      "keys", "All keys of a scenario file: default, type, bounds, unit and meaning");

  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::CallForHelp&) {
    command.text = app.help();
    return command;
  } catch (const CLI::ParseError& error) {
    throw InputError(usage_error(app, error));
  }
  if (version || keys->parsed()) {
    command.text = version ? version_text() : describe_keys();
    return command;
  }

  std::vector<Override> overrides;
  for (const Shorthand& shorthand : shorthands) {
    if (pair->count(shorthand.option) > 0) {
      overrides.push_back(
          {shorthand.key, shorthand.value, shorthand.option + " " + shorthand.value});
    }
  }
  for (const std::string& set : sets) overrides.push_back(parsed_set(set));
  for (const std::string& options : petsc) {
    const std::vector<Override> entries = parsed_petsc(options);
    overrides.insert(overrides.end(), entries.begin(), entries.end());
  }

  if (bench->parsed()) {
    command.action = Command::Action::bench;
    return command;
  }
  if (check->parsed()) {
    command.action = Command::Action::check;
    command.scenario = load_scenario(file, overrides);
    return command;
  }
  command.action = Command::Action::run;
  if (run->parsed()) {
    command.scenario = load_scenario(file, overrides);
    command.directory = std::filesystem::path("runs") / command.scenario.name;
  } else if (pair->parsed()) {
    command.scenario = parse_scenario(pair_scenario(pair_name), pair_name + ".toml", overrides);
    command.directory =
        std::filesystem::path("runs") /
        fmt::format("{}_x-lag_{}", command.scenario.name, command.scenario.bodies.at(1).x);
  } else if (compare->parsed()) {
    command.action = Command::Action::compare;
    const std::vector<std::string> names = parsed_integrators(integrators);
    command.scenario = load_scenario(file, overrides);
    const std::vector<BodyOptions>& bodies = command.scenario.bodies;
    if (std::none_of(bodies.begin(), bodies.end(),
                     [](const BodyOptions& body) { return body.kind == BodyKind::capsule; })) {
      throw InputError(file + ": has no capsule, and nothing else has a membrane to advance");
    }
    for (const std::string& name : names)
      command.integrators.emplace_back(name, with_integrator(file, overrides, bodies, name));
    command.directory = std::filesystem::path("runs") / (command.scenario.name + "_compare");
  } else {
    throw InputError("ductile: no command given; see ductile --help");
  }
  if (!directory.empty()) command.directory = directory;
  require_free(command.directory, command.force);
  return command;
}

}  // namespace ductile::drivers
