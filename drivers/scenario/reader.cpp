#include "scenario/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenario/defaults.hpp"
#include "scenario/keys.hpp"
#include "scenario/text.hpp"
#include "scenario/vocabulary.hpp"

namespace ductile::drivers {
namespace {

/// Where a rigid body's markers lie, how far the fluid slips along them, and what is inside, as far
/// as the scenario leaves it to the program. What is said of retraction or slip decides the other.
/// Slip takes from the force with which fluid keeps a light body stable.
void place_markers(const Scenario& s, bool any_interior, BodyOptions& body) {
  RigidOptions& rigid = body.rigid;
  const bool felt = !rigid.retraction;
  const bool slip_felt = !rigid.slip;
  if (felt && slip_felt && body.density_ratio >= 1) {
    const suspension::FeltPlace place = default_place(s.channel, s.fluid, body);
    rigid.retraction = place.retraction;
    rigid.slip = place.slip;
  }
  if (!rigid.slip) rigid.slip = 0;
  if (!rigid.retraction)
    rigid.retraction = default_retraction(s.channel, s.fluid, body, *rigid.slip);
  if (any_interior) rigid.interior = default_interior(s.channel, s.fluid, body);
  if (rigid.interior == suspension::Interior::fluid) return;
  if (slip_felt) rigid.slip = 0;
  if (felt) rigid.retraction = default_retraction(s.channel, s.fluid, body, *rigid.slip, true);
}

/// Reads a document into a scenario.
class Reader {
 public:
  explicit Reader(const Document& document) : document_(document) {}

  Scenario read() {
    Scenario s;
    check_root();
    read_keys(document_.root(), "", root_keys(), s);
    if (s.name.empty()) s.name = name_from(document_.file());
    read_table("channel", channel_keys(), s.channel);
    read_fluid(s.channel, s.fluid);
    s.membrane.volume_modulus = default_volume_modulus(s.channel, s.fluid);
    read_table("membrane", membrane_keys(), s.membrane);
    read_table("rigid", rigid_keys(), s.rigid);
    s.run.stop_distance = default_stop_distance(s.channel);
    read_table("run", run_keys(), s.run);
    read_table("output", output_keys(), s.output);
    read_petsc(s);
    read_bodies(s);
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

  void read_fluid(const ChannelOptions& channel, FluidOptions& fluid) const {
    read_table("fluid", fluid_keys(), fluid);
    const auto* table = document_.root()["fluid"].as_table();
    const auto told = [table](const char* key) -> const toml::node* {
      return table == nullptr ? nullptr : table->get(key);
    };
    // What moves on the lattice is what an incompressible fluid has wrong.
    const bool all_go_along = fluid.frame == LatticeFrame::bodies && channel.reynolds > 0 &&
                              channel.wall_velocity == ChannelOptions{}.wall_velocity &&
                              channel.gravity == ChannelOptions{}.gravity;
    if (told("equilibrium") == nullptr && !all_go_along)
      fluid.equilibrium = fluid::Equilibrium::compressible;
    const toml::node* arithmetic = told("arithmetic");
    if (arithmetic == nullptr) {
      fluid.arithmetic = fluid.storage;
    } else if (fluid.arithmetic == fluid::Precision::single_precision &&
               fluid.storage == fluid::Precision::double_precision) {
      document_.fail("fluid.arithmetic", *arithmetic,
                     "needs fluid.storage = \"single\"; with double storage take \"double\"");
    }
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
      if (const std::string& name = s.bodies.back().name; name == "fluid" || name == "channel") {
        document_.fail("body.name", named(*table),
                       fmt::format("names the {} in the output: call the body otherwise", name));
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

  // Whether a key is given for a body, in its own table or in that of all of its kind.
  [[nodiscard]] bool given(const toml::table& body, std::string_view kind,
                           std::string_view key) const {
    const auto* common = document_.root()[kind].as_table();
    return body.contains(key) || (common != nullptr && common->contains(key));
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
      if (!body.membrane.retraction)
        body.membrane.retraction = default_retraction(s.channel, s.fluid, body, 0);
      applicable = names_of(body_keys(), capsule_keys(), membrane_keys());
    } else {
      read_keys(table, path, rigid_body_keys(), body);
      read_keys(table, path, rigid_keys(), body.rigid);
      place_markers(s, !given(table, "rigid", "interior"), body);
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

  const Document& document_;
};

}  // namespace

Scenario parse_scenario(const Document& document) {
  return Reader(document).read();
}

}  // namespace ductile::drivers
