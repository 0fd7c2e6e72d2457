#include "scenario/vocabulary.hpp"

#include <fmt/format.h>

#include <cctype>

#include "scenario/text.hpp"

namespace ductile::drivers {

const std::map<std::string_view, std::vector<std::string_view>>& known_keys() {
  static const std::map<std::string_view, std::vector<std::string_view>> known = {
      {"channel", names_of(channel_keys())},
      {"fluid", names_of(fluid_keys())},
      {"membrane", names_of(membrane_keys())},
      {"rigid", names_of(rigid_keys())},
      {"body",
       names_of(body_keys(), capsule_keys(), rigid_body_keys(), membrane_keys(), rigid_keys())},
      {"run", names_of(run_keys())},
      {"output", names_of(output_keys())},
      {"petsc", {}}};  // PETSc's own
  return known;
}

std::string shown_key(std::string_view key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
  return shortened(bare ? std::string(key) : in_quotes(key), 60);
}

std::string home_of(std::string_view key) {
  std::string home;
  for (const auto& [table, keys] : known_keys()) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) {
      if (table != "body") return fmt::format(" it belongs in [{}]", table);
      home = " it belongs in [[body]]";
    }
  }
  return home;
}

std::string unknown_at_top(std::string_view name, bool is_table) {
  std::vector<std::string_view> tables;
  for (const auto& [table, keys] : known_keys()) tables.push_back(table);
  std::vector<std::string_view> known = tables;
  if (!is_table)
    for (const std::string_view key : names_of(root_keys())) known.push_back(key);
  std::string hint = suggestion(name, known);
  if (hint.empty()) hint = home_of(name);
  if (hint.empty()) hint = " the tables are " + joined(tables);
  return fmt::format("unknown {};{}", is_table ? "table" : "key", hint);
}

}  // namespace ductile::drivers
