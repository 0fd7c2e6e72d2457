// The directory that a run writes into, and the ways in which its files are written.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace ductile::drivers {

/// Output that could not be written; names the file and the system's reason.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Replaces `file` by one that holds `text`: at any moment, also if the program dies, it holds
/// either the old text or the new. Throws OutputError.
void write_atomically(const std::filesystem::path& file, std::string_view text);

/// Throws InputError if results may not go into `directory`: it is none, or it is not empty and the
/// run in it is not to be replaced.
void require_free(const std::filesystem::path& directory, bool force);

/// A run's directory: scenario.toml, trajectory.csv, run.h5, run.xdmf, summary.json and
/// trajectory.png.
class RunDirectory {
 public:
  /// Creates `path` and its parents where missing. One that exists must be empty, or `force` be
  /// given: then the files named above are removed, and no others. Throws InputError where it
  /// refuses, OutputError where the system does.
  RunDirectory(std::filesystem::path path, bool force);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path scenario() const { return path_ / "scenario.toml"; }
  [[nodiscard]] std::filesystem::path trajectory() const { return path_ / "trajectory.csv"; }
  [[nodiscard]] std::filesystem::path summary() const { return path_ / "summary.json"; }
  [[nodiscard]] std::filesystem::path plot() const { return path_ / "trajectory.png"; }

  /// Writes scenario.toml.
  void write_scenario(std::string_view text) const { write_atomically(scenario(), text); }

 private:
  std::filesystem::path path_;
};

}  // namespace ductile::drivers
