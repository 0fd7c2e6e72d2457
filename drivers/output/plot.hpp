// Pictures of results, drawn by the package in drivers/python.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace ductile::drivers {

/// The formats of pictures, and endings of their files; the first is the usual one.
constexpr std::array<std::string_view, 3> picture_formats = {"png", "pdf", "svg"};

/// A picture: of one directory of a run, a comparison or a campaign, or of several runs over each
/// other.
struct Picture {
  std::vector<std::filesystem::path> directories;
  std::string format;            ///< empty: that of the file's ending, or else png
  std::filesystem::path file{};  ///< empty: in the one directory, or overlay.FORMAT
  bool map = false;              ///< of a campaign: what came of each case
};

/// Draws it by the script plot.py, with numpy and matplotlib, and prints where it is on stdout; it
/// goes on if this program is killed. Starts a process: see run_script(). Gives the program's exit
/// code, 2 where the directories are not what they should be, and says in one line on stderr what
/// went wrong.
int draw(const Picture& picture);

/// Draws DIRECTORY/trajectory.FORMAT from trajectory.csv and, if there, summary.json, in the same
/// way. A run does not fail for its picture: false, and one line of warning on stderr.
bool plot_trajectory(const std::filesystem::path& directory,
                     std::string_view format = picture_formats[0]);

/// Draws DIRECTORY/compare.FORMAT from compare.json and the runs' trajectories, likewise.
bool plot_comparison(const std::filesystem::path& directory,
                     std::string_view format = picture_formats[0]);

}  // namespace ductile::drivers
