// Options that several commands share.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "scenario/document.hpp"

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

}  // namespace ductile::drivers
