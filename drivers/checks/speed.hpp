// What a run costs, and how fast this machine is as far as `ductile bench` has told.
#pragma once

#include <optional>
#include <string>

#include "ductile/suspension/plan.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Updates a second of a run with two capsules, by storage, and on how many ranks.
struct KnownSpeed {
  int ranks = 1;
  double double_precision = 0;
  double single_precision = 0;
};

/// Keeps the speed for known_speed(), in `ductile/bench.toml` under $XDG_CACHE_HOME or ~/.cache;
/// gives the file's path, or nothing if it could not be written.
std::optional<std::string> keep_speed(const KnownSpeed& speed);
/// What the last keep_speed() on this machine has kept; nothing if there is none that can be read.
std::optional<KnownSpeed> known_speed();

/// Bytes of the fluid's populations on all ranks.
double population_bytes(const suspension::Plan& plan);

/// Node updates a second on so many cores: the share of what is known of this machine, or a
/// cautious guess.
double expected_speed(const suspension::Plan& plan, int cores,
                      const std::optional<KnownSpeed>& known);
/// Seconds until the time limit at that speed.
double estimated_seconds(const Case& given, double speed);

}  // namespace ductile::drivers
