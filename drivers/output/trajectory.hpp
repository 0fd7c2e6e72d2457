// trajectory.csv: where the bodies are, over time.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ductile/suspension/sample.hpp"

namespace ductile::drivers {

/// Writes one line a sample, after a header that gives each column's unit, NAME_QUANTITY[unit]:
///     t[W^2/nu]
///     position and velocity of each body: the first motion_quantities of suspension::quantities()
///     dz[W] = z_lead - z_lag, of a pair
///     the other quantities that apply, of each body
/// Numbers have the fewest digits that read back as the same double, so equal runs give equal
/// files. Each line is handed to the system at once: what was written survives a crash.
class Trajectory {
 public:
  /// Creates or overwrites `file`. Throws OutputError, or std::invalid_argument for a name that
  /// cannot stand in a header.
  Trajectory(std::filesystem::path file, std::vector<std::string> names);

  /// Appends a line. The bodies are those of `names`, in their order. Throws OutputError, or
  /// std::invalid_argument if their number, or which of them are capsules, is not that of before.
  void write(const suspension::Sample& sample);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void write_line(std::string line);

  std::filesystem::path file_;
  std::vector<std::string> names_;
  std::optional<std::vector<bool>> capsules_;  // which bodies are; once the header is written
  std::unique_ptr<std::FILE, Close> out_;
};

}  // namespace ductile::drivers
