// How names, values and durations are written for people, and how names are recognised.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ductile::drivers {

/// A string as TOML, in quotes, on one line.
std::string in_quotes(std::string_view text);

/// At most `limit` bytes of a text, cut between UTF-8 characters.
std::string shortened(std::string text, std::size_t limit);

/// Whether a text may name a run or a body: names stand in file names, column headings, HDF5 paths,
/// XML and --set paths.
bool is_name(std::string_view text);
constexpr std::string_view name_rule = "a name of 1 to 64 letters, digits, '-' or '_'";
/// A name for what stands in a file: that of the file, with '-' for what names may not have.
std::string name_from(const std::string& file);

/// A key of a scenario as a part of a file's name: "nodes" of "channel.nodes", "lag-x" of
/// "body.lag.x"; and a value in TOML likewise: 24.0 is "24", "trt" has no quotes, and what is no
/// letter, digit, '.', '-' or '_' is a '-'.
std::string short_name(std::string_view key);
std::string short_value(std::string_view value);

/// ` did you mean "nodes"?` for the known name nearest to `given`, or "" if none is near.
std::string suggestion(std::string_view given, const std::vector<std::string_view>& known);

/// "a, b, c"
std::string joined(const std::vector<std::string_view>& names);

/// The first few names: "a, b, c, d, e and 12 more".
std::string some_of(const std::vector<std::string>& names);

/// "8 s", "3 min 20 s", "2 h 05 min", "3.1 days".
std::string duration_text(double seconds);
/// Seconds of "90s", "30m", "11.5h", "2d", "MM:SS", "HH:MM:SS" or "D-HH:MM:SS"; nothing of anything
/// else.
std::optional<double> parsed_duration(std::string_view text);

}  // namespace ductile::drivers
