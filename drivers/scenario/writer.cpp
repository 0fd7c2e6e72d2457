#include "scenario/writer.hpp"

#include <fmt/format.h>

#include <string_view>
#include <vector>

#include "scenario/keys.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {
namespace {

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

std::string written(const Scenario& s, bool limits) {
  std::string text = "# A scenario of ductile with every default filled in.\n\n";
  text += written(root_keys(), s);
  text += "\n[channel]\n" + written(channel_keys(), s.channel);
  text += "\n[fluid]\n" + written(fluid_keys(), s.fluid);
  text += "\n[membrane]\n" + written(membrane_keys(), s.membrane);
  text += "\n[rigid]\n" + written(rigid_keys(), s.rigid);
  if (limits) text += "\n[run]\n" + written(run_keys(), s.run);
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

}  // namespace

std::string resolved_toml(const Scenario& scenario) {
  return written(scenario, true);
}

std::string system_toml(const Scenario& scenario) {
  return written(scenario, false);
}

std::vector<std::pair<std::string, std::string>> parameters(const Scenario& s) {
  std::vector<std::pair<std::string, std::string>> list;
  const auto add = [&list](const std::string& path, const auto& keys, const auto& table) {
    for (const auto& key : keys) list.emplace_back(path + std::string(key.name), key.write(table));
  };
  add("", root_keys(), s);
  add("channel.", channel_keys(), s.channel);
  add("fluid.", fluid_keys(), s.fluid);
  add("membrane.", membrane_keys(), s.membrane);
  add("rigid.", rigid_keys(), s.rigid);
  add("run.", run_keys(), s.run);
  add("output.", output_keys(), s.output);
  for (const PetscOption& option : s.petsc)
    list.emplace_back("petsc." + option.name, in_quotes(option.value));
  for (const BodyOptions& body : s.bodies) {
    const std::string path = "body." + body.name + ".";
    add(path, body_keys(), body);
    if (body.kind == BodyKind::capsule) {
      add(path, capsule_keys(), body);
      add(path, membrane_keys(), body.membrane);
    } else {
      add(path, rigid_body_keys(), body);
      add(path, rigid_keys(), body.rigid);
    }
  }
  return list;
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
