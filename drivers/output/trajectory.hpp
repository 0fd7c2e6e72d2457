// trajectory.csv: where the bodies are, over time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ductile/suspension/sample.hpp"
#include "output/checksum.hpp"
#include "output/file.hpp"

namespace ductile::drivers {

/// Writes one line a sample, after a header that gives each column's unit, NAME_QUANTITY[unit]:
///     t[W^2/nu]
///     position and velocity of each body: the first motion_quantities of suspension::quantities()
///     dz[W] = z_lead - z_lag, of a pair
///     NAME_ahead[W], suspension::Sample::ahead, of more than two bodies
///     flow_rate[nu*W], suspension::Sample::flow_rate
///     the other quantities that apply, of each body
/// Numbers have the fewest digits that read back as the same double, so equal runs give equal
/// files. Each line is handed to the system at once: what was written survives a crash.
class Trajectory {
 public:
  /// So much of a file, and its checksum.
  struct Extent {
    std::uint64_t bytes = 0;
    std::string checksum;
  };

  /// `capsules` says which bodies are. Creates or overwrites `file`. Throws OutputError, or
  /// std::invalid_argument for a name that cannot stand in a header.
  Trajectory(std::filesystem::path file, std::vector<std::string> names,
             std::vector<bool> capsules);
  /// Goes on after `kept` of the file, and drops what comes after; samples <- those of its lines.
  /// Throws std::runtime_error, and leaves the file alone, if these bytes are not what they were.
  Trajectory(std::filesystem::path file, std::vector<std::string> names, std::vector<bool> capsules,
             const Extent& kept, std::vector<suspension::Sample>& samples);

  /// Whether a file is there that this run may have begun, or none is.
  static bool is_of(const std::filesystem::path& file, const std::vector<std::string>& names,
                    const std::vector<bool>& capsules);

  /// Appends a line. The bodies are those of `names`, in their order. Throws OutputError, or
  /// std::invalid_argument if their number, which of them are capsules, or how many have a distance
  /// to the next one ahead, is another.
  void write(const suspension::Sample& sample);
  /// Of all lines.
  [[nodiscard]] Extent extent() const;
  /// Brings all lines onto the disk. Throws OutputError.
  void flush() const { out_->flush(); }

 private:
  void check_names() const;
  void write_line(std::string line);
  [[nodiscard]] suspension::Sample parsed(std::string_view line) const;

  std::filesystem::path file_;
  std::vector<std::string> names_;
  std::vector<bool> capsules_;
  std::optional<AppendedFile> out_;
  Checksum checksum_;
};

}  // namespace ductile::drivers
