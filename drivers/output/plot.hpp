// Pictures of results, drawn by the scripts in drivers/python.
#pragma once

#include <filesystem>

namespace ductile::drivers {

/// Draws DIRECTORY/trajectory.png from trajectory.csv and, if there, summary.json, with the
/// system's /usr/bin/python3, numpy and matplotlib. Starts a process, which MPI does not like while
/// it is up: call after MPI_Finalize unless there is no time for that. The process is in a session
/// of its own, and goes on if this one is killed. The script is found beside the installed program
/// (../share/ductile), else in the source directory. A run does not fail for its picture: false,
/// and one line of warning on stderr.
bool plot_trajectory(const std::filesystem::path& directory);

/// Draws DIRECTORY/compare.png from compare.json and the runs' trajectories, in the same way.
bool plot_comparison(const std::filesystem::path& directory);

}  // namespace ductile::drivers
