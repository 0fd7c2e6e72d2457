#include "scenario.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

#include "check.hpp"
#include "errors.hpp"
#include "keys.hpp"
#include "units.hpp"

namespace ductile::drivers {
namespace {

/// At most `limit` bytes of a text, cut between UTF-8 characters.
std::string shortened(std::string text, std::size_t limit) {
  if (text.size() <= limit) return text;
  std::size_t end = limit;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  text.resize(end);
  return text + "...";
}

/// A key as it stands in a file, in quotes only where it needs them.
std::string shown_key(std::string_view key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
  return shortened(bare ? std::string(key) : in_quotes(key), 60);
}

std::string shown(const toml::node& node) {
  std::string text;
  if (const auto* array = node.as_array()) {
    for (const toml::node& element : *array) {
      if (text.size() > 60) break;
      text += (text.empty() ? "[" : ", ") + shown(element);
    }
    text = text.empty() ? "[]" : text + "]";
  } else if (node.is_table()) {
    text = "(a table)";
  } else if (const auto* string = node.as_string()) {
    text = in_quotes(string->get());
  } else if (const auto* number = node.as_floating_point()) {
    text = fmt::format("{}", number->get());
    if (text.find_first_of(".en") == std::string::npos) text += ".0";
  } else {
    std::ostringstream stream;
    node.visit([&stream](const auto& value) {
      if constexpr (toml::is_value<decltype(value)>) stream << value;
    });
    text = stream.str();
  }
  return shortened(std::move(text), 60);
}

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

/// Tables and the keys each knows.
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

std::string joined(const std::vector<std::string_view>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Where a key that is in the wrong table belongs.
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

/// What to say of a name at the top level that is neither table nor key.
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

/// A parsed file that knows where each of its values came from.
class Document {
 public:
  Document(std::string_view text, std::string file) : file_(std::move(file)) {
    try {
      root_ = toml::parse(text, file_);
    } catch (const toml::parse_error& error) {
      std::string what(error.description());
      constexpr std::string_view opening = "Error while ";
      if (what.starts_with(opening)) what.erase(0, opening.size());
      for (char& c : what)
        if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
      throw InputError(
          fmt::format("{}: not valid TOML: {}", position(error.source()), shortened(what, 200)));
    }
  }

  [[nodiscard]] const toml::table& root() const { return root_; }

  void apply(const Override& override) {
    const std::vector<std::string> path = split(override.key);
    toml::table* table = &root_;
    if (path.size() == 2 && path[0] != "body") {
      if (!known_keys().contains(path[0]))
        throw InputError(override.origin + ": " + unknown_at_top(path[0], true));
      if (!root_.contains(path[0])) {
        toml::table added;
        root_.insert(path[0], std::move(added));
      }
      table = root_[path[0]].as_table();
    } else if (path.size() == 3 && path[0] == "body") {
      table = body(path[1], override);
    } else if (path.size() != 1) {
      throw InputError(override.origin +
                       ": the key must be TABLE.KEY, or body.NAME.KEY for a body of that name");
    }
    // What is no table where one is due is reported as such when it is read.
    if (table == nullptr) return;
    toml::table parsed = parsed_value(override);
    parsed.begin()->second.visit(
        [&](auto& value) { table->insert_or_assign(path.back(), std::move(value)); });
  }

  /// "file:line:column" or, of an override, its origin.
  [[nodiscard]] std::string place(const toml::source_region& region) const {
    if (is_override(region)) return *region.path;
    return position(region);
  }

  /// One line about the value of a key.
  [[noreturn]] void fail(const std::string& key, const toml::node& node,
                         const std::string& complaint) const {
    if (is_override(node.source()))
      throw InputError(fmt::format("{}: {}", place(node.source()), complaint));
    const bool value = !node.is_table() && !node.is_array_of_tables();
    throw InputError(fmt::format("{}: {}{}: {}", place(node.source()), key,
                                 value ? " = " + shown(node) : "", complaint));
  }

  /// One line about the key itself.
  [[noreturn]] void fail_key(const std::string& key, const toml::key& at, const toml::node& node,
                             const std::string& complaint) const {
    if (is_override(node.source()))
      throw InputError(fmt::format("{}: {}", place(node.source()), complaint));
    throw InputError(fmt::format("{}: {}: {}", place(at.source()), key, complaint));
  }

  /// One line about a key that may not be in the file: it stands where its nearest table stands.
  [[noreturn]] void fail(const ScenarioError& error) const {
    const std::vector<std::string> path = split(error.key());
    const toml::node* node = &root_;
    for (const std::string& step : path) {
      const toml::node* next = nullptr;
      if (const auto* table = node->as_table()) {
        next = table->get(step);
      } else if (const auto* array = node->as_array()) {
        for (std::size_t i = 0; i < array->size() && next == nullptr; ++i) {
          if (const auto* body = (*array)[i].as_table(); body != nullptr && name(*body, i) == step)
            next = body;
        }
      }
      if (next == nullptr) break;
      node = next;
    }
    if (node->is_array_of_tables()) node = &root_;
    fail(error.key(), *node, error.what());
  }

  /// Name of the i-th body as given or by default.
  static std::string name(const toml::table& body, std::size_t i) {
    return body["name"].value<std::string>().value_or(fmt::format("body{}", i + 1));
  }

 private:
  [[nodiscard]] bool is_override(const toml::source_region& region) const {
    return region.path != nullptr && region.path != root_.source().path;
  }

  [[nodiscard]] std::string position(const toml::source_region& region) const {
    return fmt::format("{}:{}:{}", file_, std::max<toml::source_index>(region.begin.line, 1),
                       std::max<toml::source_index>(region.begin.column, 1));
  }

  static std::vector<std::string> split(std::string_view key) {
    std::vector<std::string> path(1);
    for (const char c : key) {
      if (c == '.') {
        path.emplace_back();
      } else {
        path.back() += c;
      }
    }
    return path;
  }

  /// The table of the body of that name. Throws InputError if there is none; returns null if what
  /// the file calls `body` is no array of tables.
  toml::table* body(const std::string& wanted, const Override& override) {
    auto* array = root_["body"].as_array();
    if (array == nullptr && root_.contains("body")) return nullptr;
    std::string names;
    for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
      auto* table = (*array)[i].as_table();
      if (table == nullptr) return nullptr;
      if (name(*table, i) == wanted) return table;
      names += (names.empty() ? "" : ", ") + shown_key(name(*table, i));
    }
    throw InputError(fmt::format("{}: there is no body {}; the bodies are: {}", override.origin,
                                 in_quotes(wanted), names.empty() ? "none" : names));
  }

  /// {"value": value}. What is no TOML value is taken as a string, so that words need no quotes.
  static toml::table parsed_value(const Override& override) {
    try {
      toml::table table = toml::parse("value = " + override.value, override.origin);
      if (table.size() == 1) return table;
    } catch (const toml::parse_error&) {
      // Fall through: a bare word.
    }
    return toml::parse("value = " + in_quotes(override.value), override.origin);
  }

  std::string file_;
  toml::table root_;
};

/// Reads a document into a scenario.
class Reader {
 public:
  explicit Reader(const Document& document) : document_(document) {}

  Scenario read(const std::string& file) {
    Scenario s;
    check_root();
    read_keys(document_.root(), "", root_keys(), s);
    if (s.name.empty()) s.name = name_from(file);
    read_table("channel", channel_keys(), s.channel);
    read_table("fluid", fluid_keys(), s.fluid);
    s.membrane.volume_modulus = default_volume_modulus(half_width(s.channel.nodes, s.channel.walls),
                                                       (s.fluid.tau - 0.5) / 3);
    read_table("membrane", membrane_keys(), s.membrane);
    read_table("rigid", rigid_keys(), s.rigid);
    const double length = s.channel.length;
    s.run.stop_distance = std::min(s.run.stop_distance, std::max(length - 2, length / 2));
    read_table("run", run_keys(), s.run);
    read_table("output", output_keys(), s.output);
    read_petsc(s);
    read_bodies(s);
    check_together(s);
    return s;
  }

 private:
  void check_root() const {
    for (const auto& [key, node] : document_.root()) {
      const std::string_view name = key.str();
      if (known_keys().contains(name)) {
        if (name == "body") continue;
        if (!node.is_table())
          document_.fail(shown_key(name), node, fmt::format("must be a table: write [{}]", name));
        continue;
      }
      const auto roots = names_of(root_keys());
      if (std::find(roots.begin(), roots.end(), name) != roots.end()) continue;
      document_.fail_key(shown_key(name), key, node,
                         unknown_at_top(name, node.is_table() || node.is_array_of_tables()));
    }
  }

  void check_known(const toml::table& table, const std::string& path,
                   const std::vector<std::string_view>& known) const {
    for (const auto& [key, node] : table) {
      if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
      std::string hint = home_of(key.str());
      if (hint.empty()) hint = suggestion(key.str(), known);
      if (hint.empty()) hint = " the keys are " + joined(known);
      document_.fail_key(path + shown_key(key.str()), key, node, "unknown key;" + hint);
    }
  }

  static std::string name_from(const std::string& file) {
    std::string name = std::filesystem::path(file).stem().string().substr(0, 64);
    for (char& c : name) {
      if (static_cast<unsigned char>(c) >= 128 ||
          (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_'))
        c = '-';
    }
    return name.empty() ? "run" : name;
  }

  template <class T>
  void read_keys(const toml::table& table, const std::string& path, const std::vector<Key<T>>& keys,
                 T& out) const {
    for (const Key<T>& key : keys) {
      const toml::node* node = table.get(key.name);
      if (node == nullptr) continue;
      try {
        key.read(out, *node);
      } catch (const Complaint& complaint) {
        document_.fail(path + std::string(key.name), *node, complaint.text);
      }
    }
  }

  template <class T>
  void read_table(const std::string& name, const std::vector<Key<T>>& keys, T& out) const {
    const auto* table = document_.root()[name].as_table();
    if (table == nullptr) return;
    check_known(*table, name + ".", names_of(keys));
    read_keys(*table, name + ".", keys, out);
  }

  void read_petsc(Scenario& s) const {
    const auto* table = document_.root()["petsc"].as_table();
    if (table == nullptr) return;
    for (const auto& [key, node] : *table) {  // sorted by name
      const std::string_view name = key.str();
      const std::string path = "petsc." + shown_key(name);
      const bool good = !name.empty() && std::isalpha(static_cast<unsigned char>(name[0])) != 0 &&
                        std::all_of(name.begin(), name.end(), [](unsigned char c) {
                          return c < 128 && (std::isalnum(c) != 0 || c == '_' || c == '-');
                        });
      if (!good) {
        document_.fail_key(path, key, node,
                           "must be the name of a PETSc option without its dash, such as "
                           "membrane_ksp_rtol");
      }
      PetscOption option{std::string(name), ""};
      if (const auto* text = node.as_string()) {
        option.value = text->get();
      } else if (node.is_number()) {
        option.value = shown(node);
      } else if (node.is_boolean()) {
        if (!node.value<bool>().value_or(true)) option.value = "false";
      } else {
        document_.fail(path, node, "must be a number, a string, or true or false");
      }
      if (option.value.find_first_of("\n\r") != std::string::npos)
        document_.fail(path, node, "must be on one line");
      s.petsc.push_back(std::move(option));
    }
  }

  void read_bodies(Scenario& s) const {
    const toml::node* node = document_.root().get("body");
    if (node == nullptr) return;
    const auto* array = node->as_array();
    if (array == nullptr)
      document_.fail("body", *node, "must be an array of tables: write [[body]]");
    std::set<std::string> names;
    for (std::size_t i = 0; i < array->size(); ++i) {
      const toml::node& element = (*array)[i];
      const auto* table = element.as_table();
      if (table == nullptr)
        document_.fail("body", element, "must be an array of tables: write [[body]]");
      s.bodies.push_back(read_body(*table, i, s));
      if (s.bodies.back().name == "fluid") {
        document_.fail("body.name", named(*table),
                       "names the fluid in the output: call the body otherwise");
      }
      if (!names.insert(s.bodies.back().name).second) {
        document_.fail("body.name", named(*table),
                       fmt::format("two bodies are called {}: give each its own name",
                                   in_quotes(s.bodies.back().name)));
      }
    }
  }

  static const toml::node& named(const toml::table& body) {
    const toml::node* name = body.get("name");
    return name == nullptr ? body : *name;
  }

  [[nodiscard]] BodyOptions read_body(const toml::table& table, std::size_t i,
                                      const Scenario& s) const {
    const std::string path = "body." + shown_key(Document::name(table, i)) + ".";
    check_known(table, path, known_keys().at("body"));
    BodyOptions body;
    body.name = fmt::format("body{}", i + 1);
    body.membrane = s.membrane;
    body.rigid = s.rigid;
    read_keys(table, path, body_keys(), body);
    std::vector<std::string_view> applicable;
    if (body.kind == BodyKind::capsule) {
      if (!table.contains("laplace")) {
        document_.fail(path + "laplace", table,
                       "is missing: state the capsule's softness La = k_s a/(rho nu^2)");
      }
      read_keys(table, path, capsule_keys(), body);
      read_keys(table, path, membrane_keys(), body.membrane);
      applicable = names_of(body_keys(), capsule_keys(), membrane_keys());
    } else {
      read_keys(table, path, rigid_body_keys(), body);
      read_keys(table, path, rigid_keys(), body.rigid);
      applicable = names_of(body_keys(), rigid_body_keys(), rigid_keys());
    }
    for (const auto& [key, node] : table) {
      if (std::find(applicable.begin(), applicable.end(), key.str()) == applicable.end()) {
        document_.fail_key(path + shown_key(key.str()), key, node,
                           fmt::format("does not apply to a {}: remove it",
                                       body.kind == BodyKind::capsule ? "capsule" : "rigid body"));
      }
    }
    return body;
  }

  /// What no single key can tell.
  static void check_together(const Scenario& s) {
    const bool moving = s.channel.wall_velocity != std::array<double, 2>{0, 0};
    if (moving && s.channel.side_walls && s.channel.start == Start::developed) {
      throw ScenarioError("channel.start",
                          "must be \"rest\" where walls move and there are side walls, since no "
                          "developed flow is known for it (or set channel.side_walls = false)");
    }
    const bool symmetric = s.channel.symmetry == Symmetry::y;
    if (symmetric && !s.channel.side_walls) {
      throw ScenarioError(
          "channel.symmetry",
          "must be \"none\" where channel.side_walls = false: the plane of symmetry "
          "needs a wall to face");
    }
    if (symmetric && s.channel.gravity[1] != 0) {
      throw ScenarioError("channel.gravity",
                          "must be 0 along y where channel.symmetry = \"y\": set that to \"none\"");
    }
    if (s.run.stop_distance > s.channel.length) {
      throw ScenarioError("run.stop_distance",
                          fmt::format("must be at most channel.length = {}: further away is nearer "
                                      "to the periodic image",
                                      s.channel.length));
    }
    for (const BodyOptions& body : s.bodies) {
      const std::string path = "body." + body.name + ".";
      if (body.kind == BodyKind::rigid && body.shape != BodyShape::sphere)
        throw ScenarioError(path + "shape", "rigid bodies are spheres: remove it");
      if (body.rotation_axis == std::array<double, 3>{0, 0, 0})
        throw ScenarioError(path + "rotation_axis", "must not be zero");
      if (symmetric && body.y != 0) {
        throw ScenarioError(
            path + "y",
            "must be 0 where channel.symmetry = \"y\": put the body on the plane of "
            "symmetry, or set channel.symmetry = \"none\"");
      }
      if (std::abs(body.z) > s.channel.length / 2) {
        throw ScenarioError(path + "z",
                            fmt::format("must be from {} to {}: half of channel.length either way",
                                        -s.channel.length / 2, s.channel.length / 2));
      }
    }
  }

  const Document& document_;
};

/// One line per key: value, unit and meaning.
template <class T>
std::string written(const std::vector<Key<T>>& keys, const T& table) {
  std::string text;
  for (const Key<T>& key : keys) {
    const std::string assignment = fmt::format("{} = {}", key.name, key.write(table));
    text += fmt::format("{:<32}  # {}{}{}\n", assignment, key.unit, key.unit.empty() ? "" : ": ",
                        key.meaning);
  }
  return text;
}

template <class T>
std::string described(std::string_view heading, std::string_view about,
                      const std::vector<Key<T>>& keys) {
  std::string text = fmt::format("\n{}{}{}\n", heading, about.empty() ? "" : "  ", about);
  const T defaults{};
  for (const Key<T>& key : keys) {
    const std::string value =
        key.default_rule.empty() ? key.write(defaults) : std::string(key.default_rule);
    text += fmt::format("  {} = {}\n      {}{}{}.\n      {}.\n", key.name, value, key.expected,
                        key.unit.empty() ? "" : ", in ", key.unit, key.meaning);
  }
  return text;
}

}  // namespace

Scenario parse_scenario(std::string_view text, const std::string& file,
                        const std::vector<Override>& overrides) {
  Document document(text, file);
  for (const Override& override : overrides) document.apply(override);
  try {
    Scenario scenario = Reader(document).read(file);
    const LatticeSetup setup = lattice_setup(scenario);
    check_geometry(scenario, setup);
    check_symmetry(scenario, setup);
    return scenario;
  } catch (const ScenarioError& error) {
    document.fail(error);
  }
}

Scenario load_scenario(const std::filesystem::path& file, const std::vector<Override>& overrides) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    throw InputError(fmt::format("{}: is a directory, not a scenario file", file.string()));
  std::ifstream stream(file, std::ios::binary);
  const int reason = errno;
  if (!stream)
    throw InputError(fmt::format("{}: cannot be read: {}", file.string(), std::strerror(reason)));
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad()) throw InputError(fmt::format("{}: cannot be read", file.string()));
  return parse_scenario(text, file.string(), overrides);
}

std::string resolved_toml(const Scenario& s) {
  std::string text = "# A scenario of ductile with every default filled in.\n\n";
  text += written(root_keys(), s);
  text += "\n[channel]\n" + written(channel_keys(), s.channel);
  text += "\n[fluid]\n" + written(fluid_keys(), s.fluid);
  text += "\n[membrane]\n" + written(membrane_keys(), s.membrane);
  text += "\n[rigid]\n" + written(rigid_keys(), s.rigid);
  text += "\n[run]\n" + written(run_keys(), s.run);
  text += "\n[output]\n" + written(output_keys(), s.output);
  if (!s.petsc.empty()) {
    text += "\n[petsc]\n";
    for (const PetscOption& option : s.petsc) {
      text += fmt::format("{} = {}\n", option.name,
                          option.value.empty() ? "true" : in_quotes(option.value));
    }
  }
  for (const BodyOptions& body : s.bodies) {
    text += "\n[[body]]\n" + written(body_keys(), body);
    if (body.kind == BodyKind::capsule) {
      text += written(capsule_keys(), body) + written(membrane_keys(), body.membrane);
    } else {
      text += written(rigid_body_keys(), body) + written(rigid_keys(), body.rigid);
    }
  }
  return text;
}

std::string describe_keys() {
  std::string text =
      "Keys of a scenario file (TOML), each with its default, type, bounds, unit and meaning.\n"
      "W is the channel's half-width along x, nu and rho are the fluid's viscosity and density,\n"
      "eta = rho nu; dx is the lattice spacing.\n";
  text += described("(top level)", "", root_keys());
  text += described("[channel]", "|x| < 1, |y| < half_width_y, periodic along z", channel_keys());
  text += described("[fluid]", "", fluid_keys());
  text += described("[membrane]", "of every capsule that does not say otherwise", membrane_keys());
  text += described("[rigid]", "of every rigid body that does not say otherwise", rigid_keys());
  text += described("[[body]]", "one for each body", body_keys());
  text += described("[[body]] of kind \"capsule\"", "and any key of [membrane]", capsule_keys());
  text += described("[[body]] of kind \"rigid\"", "and any key of [rigid]", rigid_body_keys());
  text += described("[run]", "", run_keys());
  text += described("[output]", "", output_keys());
  text +=
      "\n[petsc]  any option of PETSc, without its dash\n"
      "  membrane_ksp_rtol = 0.01\n"
      "      a number, a string, or true for an option that takes no value.\n"
      "      The solvers of implicit integrators have the prefix membrane_; what no solver has "
      "read "
      "is reported.\n";
  return text;
}

}  // namespace ductile::drivers
