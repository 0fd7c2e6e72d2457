// What a user is told of a run when it is over.
#pragma once

#include <filesystem>

#include "output/summary.hpp"

namespace ductile::drivers {

/// Verdict or final positions, warnings, speed, and the time by part where it was kept, on stdout;
/// a blow-up on stderr.
void print_outcome(const Summary& summary, const std::filesystem::path& directory);

}  // namespace ductile::drivers
