#include "commands/arguments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "output/plot.hpp"
#include "output/run_directory.hpp"
#include "scenario/text.hpp"
#include "scenario/writer.hpp"

namespace ductile::drivers {
namespace {

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

}  // namespace

void ScenarioArguments::declare(CLI::App& command) {
  command
      .add_option("--set", sets_,
                  "Another value for a key: --set channel.nodes=48, --set body.lag.x=0.1; may be "
                  "repeated")
      ->type_name("KEY=VALUE")
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--petsc", petsc_,
                  "Options of PETSc, as in [petsc]: --petsc \"-membrane_ksp_type bcgs -log_view\"; "
                  "may be repeated")
      ->type_name("OPTIONS")
      ->take_all()
      ->allow_extra_args(false);
}

std::vector<Override> ScenarioArguments::overrides() const {
  std::vector<Override> overrides;
  for (const std::string& set : sets_) overrides.push_back(parsed_set(set));
  for (const std::string& options : petsc_) {
    const std::vector<Override> entries = parsed_petsc(options);
    overrides.insert(overrides.end(), entries.begin(), entries.end());
  }
  return overrides;
}

std::string run_name(const std::string& name, const Scenario& scenario,
                     const std::vector<Override>& overrides) {
  const auto values = parameters(scenario);
  std::string all = name;
  for (const auto& [key, value] : values) {
    const bool given = std::ranges::find(overrides, key, &Override::key) != overrides.end();
    if (!given || key.find('.') == std::string::npos || key.starts_with("run.") ||
        key.starts_with("output.") || key.starts_with("petsc."))
      continue;
    all += '_' + short_name(key) + '_' + short_value(value);
  }
  constexpr std::size_t longest = 200;  // of 255 that a file's name may have
  if (all.size() > longest) {
    throw InputError(fmt::format("{}: too long for a directory's name: choose one with -o",
                                 shortened(all, longest)));
  }
  return all;
}

void OutputArguments::declare(CLI::App& command, const std::string& usual) {
  command.add_option("-o,--output", directory_, "Directory of the results; " + usual)
      ->type_name("DIR");
  command.add_flag("--force", force_, "Replace the results that are in the directory");
}

std::filesystem::path OutputArguments::directory(const std::filesystem::path& usual) const {
  std::filesystem::path chosen = directory_.empty() ? usual : std::filesystem::path(directory_);
  require_free(chosen, force_);
  return chosen;
}

void FormatArgument::declare(CLI::App& command, const std::string& meaning) {
  command.add_option("--format", format_, meaning)
      ->type_name("FORMAT")
      ->check(
          CLI::IsMember(std::vector<std::string>(picture_formats.begin(), picture_formats.end())));
}

std::string FormatArgument::format_or_usual() const {
  return format_.empty() ? std::string(picture_formats[0]) : format_;
}

}  // namespace ductile::drivers
