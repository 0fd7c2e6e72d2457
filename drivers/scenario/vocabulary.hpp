// The words of a scenario file: its tables, the keys that each knows, and what to say of a word
// that is none.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/keys.hpp"

namespace ductile::drivers {

/// The names of some keys, each once.
template <class... T>
std::vector<std::string_view> names_of(const std::vector<Key<T>>&... keys) {
  std::vector<std::string_view> names;
  const auto add = [&names](const auto& some) {
    for (const auto& key : some)
      if (std::find(names.begin(), names.end(), key.name) == names.end()) names.push_back(key.name);
  };
  (add(keys), ...);
  return names;
}

/// Tables and the keys each knows; [petsc] knows PETSc's own.
const std::map<std::string_view, std::vector<std::string_view>>& known_keys();

/// A key as it stands in a file, in quotes only where it needs them.
std::string shown_key(std::string_view key);

/// Where a key that is in the wrong table belongs: " it belongs in [fluid]", or "".
std::string home_of(std::string_view key);

/// What to say of a name at the top level that is neither table nor key.
std::string unknown_at_top(std::string_view name, bool is_table);

}  // namespace ductile::drivers
