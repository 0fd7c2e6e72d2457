// What the fuzzers feed, and the tests that feed the corpus again. Each function takes any bytes
// and returns: what the program refuses is fine, a crash, a hang or a leak is not.
#pragma once

#include <string_view>

namespace ductile::drivers::fuzz {

/// A scenario file.
void scenario(std::string_view bytes);
/// Arguments, a line each; of `pair` what it makes of them too.
void command_line(std::string_view bytes);
/// A campaign file, its cases and the scenario of one of them. Throws std::logic_error if a case
/// could not have a directory of its name.
void campaign(std::string_view bytes);
/// A checkpoint, of which everything is read that a run reads. Throws std::logic_error if bytes
/// that no run has written pass for one.
void checkpoint(std::string_view bytes);

}  // namespace ductile::drivers::fuzz
