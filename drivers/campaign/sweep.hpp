// A campaign file: which scenarios to run, and which values their keys take.
//
//     scenario = "M2"                      # a pair of the paper, or a file; or several
//     set.channel.nodes = 24               # in all cases
//
//     [[axis]]                             # axes multiply
//     key = "body.lag.x"
//     values = [-0.2, 0, 0.2]              # a list
//
//     [[axis]]
//     key = "channel.reynolds"
//     from = 5                             # a range
//     to = 20
//     count = 4
//
//     [[axis]]                             # keys that change together
//     keys = ["body.lead.laplace", "body.lag.laplace"]
//     values = [[10, 100], [100, 10]]      # or [10, 100]: the same for all keys
//     names = ["soft-lead", "soft-lag"]    # in the cases' names
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scenario/document.hpp"

namespace ductile::drivers {

/// A case as the campaign file describes it.
struct SweptCase {
  std::string name;      ///< unique; stands in file names
  std::string scenario;  ///< as the file calls it
  std::string text;      ///< of the scenario
  std::string file;      ///< what messages call that text
  std::vector<Override> overrides;
  /// Of the swept keys, in the order of Sweep::axes; TOML.
  std::vector<std::string> values;
};

struct Sweep {
  std::string name;
  /// The keys that take several values.
  std::vector<std::string> axes;
  std::vector<SweptCase> cases;
};

/// Most cases that a campaign may have.
constexpr std::size_t most_cases = 10000;

/// Reads the text of a campaign file and lays out its cases, the last axis fastest; whether the
/// scenarios are good is not looked at. `file` is what messages call it, and where paths are
/// relative to. Throws InputError, with line and column.
Sweep parse_sweep(std::string_view text, const std::filesystem::path& file);

}  // namespace ductile::drivers
