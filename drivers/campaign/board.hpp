// The live table of a campaign.
#pragma once

#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

namespace ductile::drivers {

/// A case under way, as the table shows it.
struct BoardRow {
  std::string name;
  std::optional<double> time;  ///< [W^2/nu]
  double time_limit = 0;
  std::optional<double> dz;
  std::string verdict;         ///< so far
  std::optional<double> left;  ///< seconds until the time limit
};

/// How many cases there are.
struct BoardCounts {
  std::size_t all = 0;
  std::size_t ended = 0;
  std::size_t waiting = 0;
  std::optional<double> left;  ///< seconds until all have ended
};

/// On a terminal, the cases under way, rewritten in place below what is told of those that have
/// ended; else the counts alone, at intervals that double from 10 seconds to 5 minutes.
class Board {
 public:
  /// `width`: columns of the terminal.
  Board(std::FILE* out, bool terminal, std::size_t width)
      : out_(out), terminal_(terminal), width_(width) {}

  /// Once a second or so; `now` in seconds, from any zero.
  void show(double now, const std::vector<BoardRow>& rows, const BoardCounts& counts);
  /// A line that stays.
  void tell(const std::string& line);
  /// Takes the rows away.
  void finish();

 private:
  void clear();

  std::FILE* out_;
  bool terminal_;
  std::size_t width_;
  std::size_t shown_ = 0;  // lines below those that stay
  std::optional<double> next_;
  double interval_ = 10;
};

/// "7 of 20 cases have ended, 2 are under way, 11 wait; about 14 min left"
std::string counts_text(const BoardCounts& counts, std::size_t under_way);

}  // namespace ductile::drivers
