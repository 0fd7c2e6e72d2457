#include "commands/pair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "checks/read_case.hpp"
#include "scenario/pairs.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {
namespace {

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

}  // namespace

PairCommand::PairCommand()
    : shorthands_{{"--x-lag", "body.lag.x",
                   "Where the lagging particle starts across the channel, in W", ""},
                  {"--nodes", "channel.nodes", "Nodes across the channel", ""},
                  {"--tau", "fluid.tau", "Relaxation time", ""},
                  {"--length", "channel.length", "Length of the channel, in W", ""},
                  {"--time-limit", "run.time_limit", "When to stop at the latest, in W^2/nu", ""}} {
}

CLI::App* PairCommand::declare(CLI::App& program) {
  CLI::App* command = program.add_subcommand("pair", "Run one of the paper's pairs");
  std::vector<std::string_view> names;
  for (const auto& [name, text] : pair_scenarios()) names.push_back(name);
  command->add_option("CASE", pair_, "The pair: " + joined(names))->required()->type_name("");
  for (Shorthand& shorthand : shorthands_) {
    shorthand.given = command
                          ->add_option(shorthand.option, shorthand.value,
                                       fmt::format("{} ({})", shorthand.meaning, shorthand.key))
                          ->type_name("NUMBER")
                          ->required(shorthand.option == "--x-lag");
  }
  declare_shared(*command, "runs/CASE_x-lag_X by default, with what else was changed");
  return command;
}

SingleRun::Request PairCommand::prepare() const {
  std::vector<Override> overrides;
  for (const Shorthand& shorthand : shorthands_) {
    if (shorthand.given->count() > 0) {
      overrides.push_back(
          {shorthand.key, shorthand.value, shorthand.option + " " + shorthand.value});
    }
  }
  const std::vector<Override> short_ones = overrides;
  for (Override& override : scenario().overrides()) {
    const auto same = std::ranges::find(short_ones, override.key, &Override::key);
    if (same != short_ones.end()) {
      throw InputError(
          fmt::format("{} and {}: give {} once", same->origin, override.origin, override.key));
    }
    overrides.push_back(std::move(override));
  }
  Request request{parse_case(pair_scenario(pair_), pair_ + ".toml", overrides), {}};
  const Scenario& resolved = request.given.scenario;
  const std::string name = fmt::format("{}_x-lag_{}", resolved.name, resolved.bodies.at(1).x);
  std::erase_if(overrides, [](const Override& given) { return given.key == "body.lag.x"; });
  request.directory =
      output().directory(std::filesystem::path("runs") / run_name(name, resolved, overrides));
  return request;
}

}  // namespace ductile::drivers
