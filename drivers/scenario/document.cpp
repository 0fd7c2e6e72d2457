#include "scenario/document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include "scenario/text.hpp"
#include "scenario/vocabulary.hpp"

namespace ductile::drivers {
namespace {

std::vector<std::string> split(std::string_view key) {
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

/// {"value": value}. What is no TOML value is taken as a string, so that words need no quotes.
toml::table parsed_value(const Override& override) {
  try {
    toml::table table = toml::parse("value = " + override.value, override.origin);
    if (table.size() == 1) return table;
  } catch (const toml::parse_error&) {
    // Fall through: a bare word.
  }
  try {
    return toml::parse("value = " + in_quotes(override.value), override.origin);
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}: {}", in_quotes(override.origin), error.description()));
  }
}

}  // namespace

std::string read_text(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    throw InputError(fmt::format("{}: is a directory, not a scenario file", file.string()));
  std::ifstream stream(file, std::ios::binary);
  const int reason = errno;
  if (!stream)
    throw InputError(fmt::format("{}: cannot be read: {}", file.string(), std::strerror(reason)));
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad()) throw InputError(fmt::format("{}: cannot be read", file.string()));
  return text;
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

Document::Document(std::string_view text, std::string file) : file_(std::move(file)) {
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

void Document::apply(const Override& override) {
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

std::string Document::place(const toml::source_region& region) const {
  if (is_override(region)) return *region.path;
  return position(region);
}

void Document::fail(const std::string& key, const toml::node& node,
                    const std::string& complaint) const {
  if (is_override(node.source()))
    throw InputError(fmt::format("{}: {}", place(node.source()), complaint));
  const bool value = !node.is_table() && !node.is_array_of_tables();
  throw InputError(fmt::format("{}: {}{}: {}", place(node.source()), key,
                               value ? " = " + shown(node) : "", complaint));
}

void Document::fail_key(const std::string& key, const toml::key& at, const toml::node& node,
                        const std::string& complaint) const {
  if (is_override(node.source()))
    throw InputError(fmt::format("{}: {}", place(node.source()), complaint));
  throw InputError(fmt::format("{}: {}: {}", place(at.source()), key, complaint));
}

void Document::fail(const ScenarioError& error) const {
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

std::string Document::name(const toml::table& body, std::size_t i) {
  return body["name"].value<std::string>().value_or(fmt::format("body{}", i + 1));
}

bool Document::is_override(const toml::source_region& region) const {
  return region.path != nullptr && region.path != root_.source().path;
}

std::string Document::position(const toml::source_region& region) const {
  return fmt::format("{}:{}:{}", file_, std::max<toml::source_index>(region.begin.line, 1),
                     std::max<toml::source_index>(region.begin.column, 1));
}

toml::table* Document::body(const std::string& wanted, const Override& override) {
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

}  // namespace ductile::drivers
