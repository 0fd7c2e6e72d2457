#include "campaign/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <string_view>

#include "scenario/pairs.hpp"
#include "scenario/text.hpp"
#include "scenario/vocabulary.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {

/// One value of an axis: its keys' overrides, and what it is called.
struct Point {
  std::vector<Override> overrides;
  std::string name;
};

using Axis = std::vector<Point>;

/// Numbers with the fewest digits that read back as the same.
std::string toml_text(const toml::node& node) {
  if (const auto* number = node.as_floating_point(); number && std::isfinite(number->get())) {
    const std::string text = fmt::format("{}", number->get());
    return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
  }
  if (const auto* words = node.as_string()) return in_quotes(words->get());
  if (const auto* array = node.as_array()) {
    std::string text;
    for (const toml::node& element : *array)
      text += (text.empty() ? "" : ", ") + toml_text(element);
    return '[' + text + ']';
  }
  std::ostringstream text;
  node.visit([&text](const auto& value) { text << toml::toml_formatter{value}; });
  return text.str();
}

class Reader {
 public:
  Reader(std::string_view text, const fs::path& file)
      : document_(text, file.string()), folder_(file.parent_path()) {
    sweep_.name = name_from(file.string());
  }

  Sweep read() {
    check_keys(document_.root(), "", {"name", "scenario", "set", "axis"});
    if (const toml::node* node = document_.root().get("name")) {
      sweep_.name = text_of("name", *node);
      if (!is_name(sweep_.name)) document_.fail("name", *node, "must be " + std::string(name_rule));
    }
    read_scenarios();
    read_set();
    read_axes();
    multiply();
    return std::move(sweep_);
  }

 private:
  struct Base {
    std::string name;  // as the file calls it
    std::string label;
    std::string text;
    std::string file;
  };

  void check_keys(const toml::table& table, const std::string& path,
                  const std::vector<std::string_view>& known) const {
    for (const auto& [key, node] : table) {
      if (std::ranges::find(known, key.str()) != known.end()) continue;
      const std::string hint = suggestion(key.str(), known);
      document_.fail_key(path + shown_key(key.str()), key, node,
                         "unknown key;" + (hint.empty() ? " the keys are " + joined(known) : hint));
    }
  }

  [[nodiscard]] std::string text_of(const std::string& key, const toml::node& node) const {
    if (!node.is_string()) document_.fail(key, node, "must be a text in quotes");
    return node.value<std::string>().value_or("");
  }

  [[nodiscard]] const toml::array& array_of(const std::string& key, const toml::node& node) const {
    const toml::array* array = node.as_array();
    if (array == nullptr || array->empty())
      document_.fail(key, node, "must be an array, with an entry at least");
    return *array;
  }

  void read_scenarios() {
    const toml::node* node = document_.root().get("scenario");
    if (node == nullptr) {
      document_.fail("scenario", document_.root(),
                     "is missing: name a pair of the paper, or a scenario file");
    }
    if (node->is_array()) {
      for (const toml::node& element : array_of("scenario", *node)) add_base(element);
    } else {
      add_base(*node);
    }
  }

  void add_base(const toml::node& node) {
    Base base;
    base.name = text_of("scenario", node);
    std::vector<std::string_view> pairs;
    for (const auto& [name, text] : pair_scenarios()) {
      pairs.push_back(name);
      if (base.name != name) continue;
      base.text = text;
      base.file = base.name + ".toml";
    }
    if (base.text.empty()) {
      const fs::path file = folder_ / base.name;
      std::error_code error;
      if (!fs::exists(file, error)) {
        const std::string hint = suggestion(base.name, pairs);
        document_.fail("scenario", node,
                       fmt::format("there is no file {}, and no pair of that name;{}",
                                   in_quotes(file.string()),
                                   hint.empty() ? " the pairs are " + joined(pairs) : hint));
      }
      base.text = read_text(file);
      base.file = file.string();
    }
    base.label = short_value(fs::path(base.name).stem().string());
    for (const Base& other : bases_) {
      if (other.label == base.label)
        document_.fail("scenario", node, fmt::format("two scenarios are called {}", base.label));
    }
    bases_.push_back(std::move(base));
  }

  // By the name of the file alone: it is kept with the results, wherever those go.
  [[nodiscard]] std::string place(const toml::node& node) const {
    return fmt::format("{}:{}:{}", fs::path(document_.file()).filename().string(),
                       node.source().begin.line, node.source().begin.column);
  }

  // A scenario's key gets a value, of which messages say where it stands.
  Override override_of(const std::string& key, std::string value, const toml::node& at) const {
    std::string origin = fmt::format("{}: {} = {}", place(at), key, shortened(value, 60));
    return {key, std::move(value), std::move(origin)};
  }

  void take(const std::string& key, const toml::node& at) {
    if (!taken_.insert(key).second)
      document_.fail(key, at, "has a value already: name each key once");
  }

  // Tables within [set] come of keys with points.
  void read_set() {
    const toml::node* node = document_.root().get("set");
    if (node == nullptr) return;
    if (!node->is_table()) document_.fail("set", *node, "must be a table: write [set]");
    read_set(*node->as_table(), "");
  }
  void read_set(const toml::table& table, const std::string& path) {
    for (const auto& [key, node] : table) {
      const std::string name = path + std::string(key.str());
      if (const toml::table* inner = node.as_table()) {
        read_set(*inner, name + ".");
        continue;
      }
      take(name, node);
      set_.push_back(override_of(name, toml_text(node), node));
    }
  }

  void read_axes() {
    const toml::node* node = document_.root().get("axis");
    if (node == nullptr) return;
    if (!node->is_array_of_tables())
      document_.fail("axis", *node, "must be an array of tables: write [[axis]]");
    for (const toml::node& element : *node->as_array()) read_axis(*element.as_table());
  }

  void read_axis(const toml::table& table) {
    check_keys(table, "axis.", {"key", "keys", "values", "from", "to", "count", "names"});
    std::vector<std::string> keys;
    if (table.contains("key") == table.contains("keys"))
      document_.fail("axis", table, "must have either key or keys");
    if (const toml::node* key = table.get("key")) keys.push_back(text_of("axis.key", *key));
    if (const toml::node* list = table.get("keys")) {
      for (const toml::node& key : array_of("axis.keys", *list))
        keys.push_back(text_of("axis.keys", key));
    }
    for (const std::string& key : keys) take(key, table);
    if (table.contains("values") == table.contains("from"))
      document_.fail("axis", table, "must have either values, or from, to and count");
    const bool rows = table.contains("keys");
    Axis axis = table.contains("values") ? listed(table, keys, rows) : ranged(table, keys);
    give_names(axis, table, keys.size());
    sweep_.axes.insert(sweep_.axes.end(), keys.begin(), keys.end());
    axes_.push_back(std::move(axis));
  }

  // With `rows` an array has a value for each of the keys.
  [[nodiscard]] Axis listed(const toml::table& table, const std::vector<std::string>& keys,
                            bool rows) const {
    for (const char* key : {"to", "count"}) {
      if (const toml::node* node = table.get(key))
        document_.fail(fmt::format("axis.{}", key), *node, "goes with from, not with values");
    }
    Axis axis;
    for (const toml::node& value : array_of("axis.values", *table.get("values"))) {
      Point point;
      const toml::array* row = value.as_array();
      const bool each = rows && row != nullptr;
      if (each && row->size() != keys.size()) {
        document_.fail("axis.values", value,
                       fmt::format("must have {} values, one for each of the keys", keys.size()));
      }
      for (std::size_t k = 0; k < keys.size(); ++k) {
        const toml::node& own = each ? (*row)[k] : value;
        point.overrides.push_back(override_of(keys[k], toml_text(own), own));
      }
      axis.push_back(std::move(point));
    }
    return axis;
  }

  [[nodiscard]] double number(const toml::table& table, const char* key) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) document_.fail("axis", table, "must have from, to and count");
    const double value = node->value<double>().value_or(NAN);
    if (!node->is_number() || !std::isfinite(value))
      document_.fail(fmt::format("axis.{}", key), *node, "must be a number");
    return value;
  }

  [[nodiscard]] Axis ranged(const toml::table& table, const std::vector<std::string>& keys) const {
    const double from = number(table, "from");
    const double to = number(table, "to");
    const double count = number(table, "count");
    const toml::node& count_node = *table.get("count");
    constexpr double most = most_cases;
    if (!count_node.is_integer() || count < 2 || count > most) {
      document_.fail("axis.count", count_node,
                     fmt::format("must be a whole number from 2 to {}", most));
    }
    const bool whole = table.get("from")->is_integer() && table.get("to")->is_integer();
    Axis axis;
    for (int i = 0; i < static_cast<int>(count); ++i) {
      // Twelve digits: -0.4 to 0.4 in five has 0.2, and not its neighbour in binary.
      const double value = from + (to - from) * i / (count - 1);
      std::string text =
          fmt::format("{:.12g}", std::abs(value) < 1e-14 * std::abs(to - from) ? 0 : value);
      const bool integer = text.find_first_of(".en") == std::string::npos;
      if (integer && !whole) text += ".0";
      Point point;
      for (const std::string& key : keys)
        point.overrides.push_back(override_of(key, text, *table.get("from")));
      axis.push_back(std::move(point));
    }
    return axis;
  }

  void give_names(Axis& axis, const toml::table& table, std::size_t keys) const {
    const toml::node* names = table.get("names");
    if (names != nullptr && array_of("axis.names", *names).size() != axis.size()) {
      document_.fail("axis.names", *names,
                     fmt::format("must have {} names, one for each value", axis.size()));
    }
    for (std::size_t i = 0; i < axis.size(); ++i) {
      if (names != nullptr) {
        const toml::node& node = (*names->as_array())[i];
        axis[i].name = text_of("axis.names", node);
        if (!is_name(axis[i].name))
          document_.fail("axis.names", node, "must be " + std::string(name_rule));
        continue;
      }
      // Keys that have one value between them are named once.
      const std::vector<Override>& given = axis[i].overrides;
      const bool alike = std::ranges::all_of(
          given, [&](const Override& other) { return other.value == given.front().value; });
      for (std::size_t k = 0; k < (alike ? 1 : keys); ++k) {
        if (k > 0) axis[i].name += '_';
        axis[i].name += short_name(given[k].key) + '_' + short_value(given[k].value);
      }
    }
  }

  void multiply() {
    double count = static_cast<double>(bases_.size());
    for (const Axis& axis : axes_) count *= static_cast<double>(axis.size());
    if (count > static_cast<double>(most_cases)) {
      throw InputError(fmt::format("{}: {:.0f} cases: at most {} in a campaign", document_.file(),
                                   count, most_cases));
    }
    std::set<std::string> names;
    for (const Base& base : bases_) {
      for (std::size_t n = 0; n < static_cast<std::size_t>(count) / bases_.size(); ++n) {
        SweptCase swept = case_of(base, n);
        if (!names.insert(swept.name).second) {
          throw InputError(
              fmt::format("{}: two cases are called {}: give their axis names of its own",
                          document_.file(), swept.name));
        }
        constexpr std::size_t longest = 200;  // of 255 that a file's name may have
        if (swept.name.size() > longest) {
          throw InputError(
              fmt::format("{}: {}: too long for a directory's name: give the axes names",
                          document_.file(), shortened(swept.name, longest)));
        }
        sweep_.cases.push_back(std::move(swept));
      }
    }
  }

  // The n-th, the last axis fastest.
  [[nodiscard]] SweptCase case_of(const Base& base, std::size_t n) const {
    SweptCase swept{"", base.name, base.text, base.file, set_, {}};
    std::vector<const Point*> points(axes_.size());
    for (std::size_t a = axes_.size(); a-- > 0;) {
      points[a] = &axes_[a][n % axes_[a].size()];
      n /= axes_[a].size();
    }
    if (bases_.size() > 1 || axes_.empty()) swept.name = base.label;
    for (const Point* point : points) {
      if (!swept.name.empty()) swept.name += '_';
      swept.name += point->name;
      for (const Override& given : point->overrides) {
        swept.values.push_back(given.value);
        swept.overrides.push_back(given);
      }
    }
    return swept;
  }

  Document document_;
  fs::path folder_;
  Sweep sweep_;
  std::vector<Base> bases_;
  std::vector<Override> set_;
  std::vector<Axis> axes_;
  std::set<std::string> taken_;
};

}  // namespace

Sweep parse_sweep(std::string_view text, const fs::path& file) {
  return Reader(text, file).read();
}

}  // namespace ductile::drivers
