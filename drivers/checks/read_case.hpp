// From a scenario file to a case that can be run.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/document.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Reads `text` with the overrides applied in their order, plans it once, and validates it. `file`
/// is what messages call the text. Throws InputError, with line and column.
Case parse_case(std::string_view text, const std::string& file,
                const std::vector<Override>& overrides = {});

/// parse_case() of a file. Throws InputError also if it cannot be read.
Case load_case(const std::filesystem::path& file, const std::vector<Override>& overrides = {});

}  // namespace ductile::drivers
