// A run as its rows show it while it is under way.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>

#include "analysis/verdict.hpp"

namespace ductile::drivers {

/// Reads the rows that a run appends to its trajectory.csv, and judges them as the run does. Rows
/// that a run going on takes back come again, the same.
class RunWatch {
 public:
  RunWatch(std::filesystem::path trajectory, double stop_distance)
      : file_(std::move(trajectory)), judge_(stop_distance) {}

  /// Reads what is new.
  void look();
  /// Of the last row; nothing before the first.
  [[nodiscard]] std::optional<double> time() const { return time_; }
  /// Of a pair.
  [[nodiscard]] std::optional<double> dz() const { return dz_; }
  /// Of a pair, so far.
  [[nodiscard]] const Verdict& verdict() const { return judge_.verdict(); }

 private:
  void take_header(const std::string& line);
  void take_row(const std::string& line);

  std::filesystem::path file_;
  std::size_t read_ = 0;  // bytes
  bool header_ = false;
  // Columns, of a pair.
  std::optional<std::size_t> dz_column_, lead_, lag_;
  std::optional<double> time_, dz_;
  PairJudge judge_;
};

}  // namespace ductile::drivers
