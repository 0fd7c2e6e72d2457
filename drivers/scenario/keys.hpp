// The keys of a scenario file, declared once: the tables below drive reading, checking, writing and
// documenting a scenario. A key's default is that of the struct's member.
#pragma once

#include <toml++/toml.h>

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/scenario.hpp"

namespace ductile::drivers {

/// What is wrong with a value, without where it stands: "must be a number above 0".
struct Complaint {
  std::string text;
};

/// A key of the table that is read into a T.
template <class T>
struct Key {
  std::string_view name;
  std::string expected;      ///< type and bounds: "a number above 0.5 and at most 1"
  std::string_view unit;     ///< "" for pure numbers
  std::string_view meaning;  ///< one line
  /// How the default comes about where it is not simply the member's; else "".
  std::string_view default_rule;
  std::function<void(T&, const toml::node&)> read;  ///< throws Complaint
  std::function<std::string(const T&)> write;       ///< as TOML
};

const std::vector<Key<Scenario>>& root_keys();
const std::vector<Key<ChannelOptions>>& channel_keys();
const std::vector<Key<FluidOptions>>& fluid_keys();
const std::vector<Key<MembraneOptions>>& membrane_keys();
const std::vector<Key<RigidOptions>>& rigid_keys();
/// Those of every body; of capsules and of rigid bodies only.
const std::vector<Key<BodyOptions>>& body_keys();
const std::vector<Key<BodyOptions>>& capsule_keys();
const std::vector<Key<BodyOptions>>& rigid_body_keys();
const std::vector<Key<RunLimits>>& run_keys();
const std::vector<Key<OutputOptions>>& output_keys();

}  // namespace ductile::drivers
