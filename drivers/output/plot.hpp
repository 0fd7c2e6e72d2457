// Pictures of results, drawn by the scripts in drivers/python.
#pragma once

#include <filesystem>

namespace ductile::drivers {

/// Draws DIRECTORY/trajectory.png from trajectory.csv and, if there, summary.json, with the
/// system's /usr/bin/python3, numpy and matplotlib. Starts a process: call after MPI_Finalize. The
/// script is found beside the installed program (../share/ductile), else in the source directory.
/// A run does not fail for its picture: false, and one line of warning on stderr.
bool plot_trajectory(const std::filesystem::path& directory);

/// Draws DIRECTORY/compare.png from compare.json and the runs' trajectories, in the same way.
bool plot_comparison(const std::filesystem::path& directory);

}  // namespace ductile::drivers
