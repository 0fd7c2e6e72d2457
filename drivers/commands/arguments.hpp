// Options that several commands share.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "scenario/document.hpp"
#include "scenario/scenario.hpp"

namespace ductile::drivers {

/// --set and --petsc: values for keys of the scenario.
class ScenarioArguments {
 public:
  void declare(CLI::App& command);
  /// In the order of application. Throws InputError.
  [[nodiscard]] std::vector<Override> overrides() const;

 private:
  std::vector<std::string> sets_;
  std::vector<std::string> petsc_;
};

/// What a run's usual directory is called: NAME, and behind it the keys of the system that were
/// given another value and what that is, such as NAME_nodes_24_lag-x_0.1, so that two runs of one
/// scenario do not meet; [run], [output] and [petsc] make it no other system. Throws InputError if
/// the name gets too long for a file.
std::string run_name(const std::string& name, const Scenario& scenario,
                     const std::vector<Override>& overrides);

/// -o and --force: where results go.
class OutputArguments {
 public:
  /// `usual` says where they go without -o.
  void declare(CLI::App& command, const std::string& usual);
  /// Where they go: as given, or else `usual`. Throws InputError if they may not.
  [[nodiscard]] std::filesystem::path directory(const std::filesystem::path& usual) const;
  [[nodiscard]] bool force() const { return force_; }

 private:
  std::string directory_;
  bool force_ = false;
};

/// --format: of pictures.
class FormatArgument {
 public:
  /// `meaning` says of which, and what is usual.
  void declare(CLI::App& command, const std::string& meaning);
  /// Empty unless it is given.
  [[nodiscard]] const std::string& format() const { return format_; }
  /// As given, or else the usual one.
  [[nodiscard]] std::string format_or_usual() const;

 private:
  std::string format_;
};

}  // namespace ductile::drivers
