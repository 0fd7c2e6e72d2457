// The directory that a run writes into, and the ways in which its files are written.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "output/file.hpp"

namespace ductile::drivers {

/// Throws InputError if results may not go into `directory`: it is none, or it is not empty and the
/// run in it is not to be replaced.
void require_free(const std::filesystem::path& directory, bool force);

/// A directory that one program at a time writes into. The system takes the lock from one that has
/// died; the file `lock` in it says whose it is.
class DirectoryLock {
 public:
  /// `what` is what it is locked for: a "run". Throws InputError if another one has it, OutputError
  /// if the directory cannot be opened. Where the file system knows no locks it says so.
  DirectoryLock(const std::filesystem::path& directory, std::string_view what);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

 private:
  int descriptor_ = -1;
};

/// Whether a program that lives has the lock of the directory, as far as the file system knows.
bool is_locked(const std::filesystem::path& directory);

/// A run's directory: scenario.toml, trajectory.csv, run.h5, run.xdmf, frames/, summary.json,
/// trajectory.png (or .pdf, .svg), checkpoint.h5, checkpoint-before.h5, checkpoint-refused.h5,
/// log.txt; and `lock`, which the system takes from a run that has died.
class RunDirectory {
 public:
  /// Creates `path` and its parents where missing. One that exists must be empty, or `force` be
  /// given: then the files named above are removed, and no others. Throws InputError where it
  /// refuses, also because a run that lives writes there, OutputError where the system does.
  RunDirectory(std::filesystem::path path, bool force);
  /// That of a run which is to go on. Throws likewise.
  explicit RunDirectory(std::filesystem::path path);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path scenario() const { return path_ / "scenario.toml"; }
  [[nodiscard]] std::filesystem::path trajectory() const { return path_ / "trajectory.csv"; }
  [[nodiscard]] std::filesystem::path summary() const { return path_ / "summary.json"; }
  /// In every format that there may be.
  [[nodiscard]] std::vector<std::filesystem::path> plots() const;
  [[nodiscard]] std::filesystem::path checkpoint() const { return path_ / "checkpoint.h5"; }
  [[nodiscard]] std::filesystem::path checkpoint_before() const {
    return path_ / "checkpoint-before.h5";
  }
  [[nodiscard]] std::filesystem::path checkpoint_refused() const {
    return path_ / "checkpoint-refused.h5";
  }
  [[nodiscard]] std::filesystem::path log() const { return path_ / "log.txt"; }

  /// Writes scenario.toml.
  void write_scenario(std::string_view text) const {
    write_atomically(scenario(), text, Durability::system);
  }

 private:
  std::filesystem::path path_;
  std::optional<DirectoryLock> lock_;
};

}  // namespace ductile::drivers
