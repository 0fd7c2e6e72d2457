// What the tests of the input side share.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "checks/read_case.hpp"
#include "scenario/errors.hpp"

namespace ductile::drivers {

/// The message with which a scenario is refused, or "" if it is not.
inline std::string refusal(std::string_view text, const std::vector<Override>& overrides = {}) {
  try {
    parse_case(text, "case.toml", overrides);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

inline Override set(const std::string& key, const std::string& value) {
  return {key, value, "--set " + key + "=" + value};
}

/// Two capsules of the paper, far enough apart.
constexpr std::string_view pair_text = R"(
[[body]]
name = "lead"
laplace = 10
x = 0.2
z = 0.5

[[body]]
name = "lag"
laplace = 100
x = -0.2
z = -0.5
)";

}  // namespace ductile::drivers
