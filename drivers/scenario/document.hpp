// A scenario file, parsed as TOML, that knows where each of its values came from.
#pragma once

#include <toml++/toml.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/errors.hpp"

namespace ductile::drivers {

/// A value given outside of the file: `key` is "channel.nodes", or "body.NAME.x" for the body of
/// that name; `value` is TOML, or a string without its quotes; `origin` is how messages call it
/// ("--set channel.nodes=24").
struct Override {
  std::string key;
  std::string value;
  std::string origin;
};

/// The text of a file. Throws InputError if it cannot be read.
std::string read_text(const std::filesystem::path& file);

/// A value as it stands in a file, shortened.
std::string shown(const toml::node& node);

class Document {
 public:
  /// `file` is what messages call the text. Throws InputError if it is not TOML.
  Document(std::string_view text, std::string file);

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] const toml::table& root() const { return root_; }

  /// Gives a key the value of the override. Throws InputError for a table or a body that is not
  /// there; whether the key is known is seen when it is read.
  void apply(const Override& override);

  /// All of these throw InputError: one line about the value of a key, ...
  [[noreturn]] void fail(const std::string& key, const toml::node& node,
                         const std::string& complaint) const;
  /// ... about the key itself, ...
  [[noreturn]] void fail_key(const std::string& key, const toml::key& at, const toml::node& node,
                             const std::string& complaint) const;
  /// ... and about a key that may not be in the file: it stands where its nearest table stands.
  [[noreturn]] void fail(const ScenarioError& error) const;

  /// Name of the i-th body as given or by default.
  static std::string name(const toml::table& body, std::size_t i);

 private:
  [[nodiscard]] bool is_override(const toml::source_region& region) const;
  [[nodiscard]] std::string position(const toml::source_region& region) const;
  /// "file:line:column" or, of an override, its origin.
  [[nodiscard]] std::string place(const toml::source_region& region) const;
  /// The table of the body of that name. Throws InputError if there is none; returns null if what
  /// the file calls `body` is no array of tables.
  toml::table* body(const std::string& wanted, const Override& override);

  std::string file_;
  toml::table root_;
};

}  // namespace ductile::drivers
