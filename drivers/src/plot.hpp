// trajectory.png, drawn by plot_trajectory.py.
#pragma once

#include <filesystem>

namespace ductile::drivers {

/// Draws DIRECTORY/trajectory.png from trajectory.csv and, if there, summary.json, with the
/// system's /usr/bin/python3, numpy and matplotlib. Starts a process: call after MPI_Finalize. The
/// script is found beside the installed program (../share/ductile), else in the source directory.
/// A run does not fail for its picture: false, and one line of warning on stderr.
bool plot_trajectory(const std::filesystem::path& directory);

}  // namespace ductile::drivers
