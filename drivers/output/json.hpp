// JSON, as far as the program writes any.
#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <concepts>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace ductile::drivers {

/// The text as a string of JSON, in quotes.
inline std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

/// Text of JSON, made piece by piece; commas, line breaks and indents are its own affair. Numbers
/// have the fewest digits that read back as the same double, null is what is not finite or not
/// known.
class Json {
 public:
  void open(char bracket, std::string_view key = {}) {
    begin(key);
    text_ += bracket;
    ++depth_;
    empty_ = true;
  }
  void close(char bracket) {
    --depth_;
    if (!empty_) new_line();
    text_ += bracket;
    empty_ = false;
  }
  void add(std::string_view key, std::string_view value) { put(key, quoted(value)); }
  void add(std::string_view key, std::integral auto value) { put(key, fmt::format("{}", value)); }
  void add(std::string_view key, double value) { put(key, number(value)); }
  void add(std::string_view key, const Eigen::Vector3d& v) {
    put(key, fmt::format("[{}, {}, {}]", number(v.x()), number(v.y()), number(v.z())));
  }
  void add(std::string_view key, std::span<const double> values) {
    std::string text;
    for (const double value : values) text += (text.empty() ? "" : ", ") + number(value);
    put(key, '[' + text + ']');
  }
  /// A value that is JSON already.
  void add_json(std::string_view key, std::string_view value) { put(key, value); }
  template <typename T>
  void add(std::string_view key, const std::optional<T>& value) {
    value ? add(key, *value) : put(key, "null");
  }
  [[nodiscard]] std::string text() const { return text_ + '\n'; }

 private:
  static std::string number(double value) {
    return std::isfinite(value) ? fmt::format("{}", value) : "null";
  }
  void new_line() { text_ += '\n' + std::string(2 * depth_, ' '); }
  void begin(std::string_view key) {
    if (!empty_) text_ += ',';
    if (depth_ > 0) new_line();
    if (!key.empty()) text_ += quoted(key) + ": ";
    empty_ = false;
  }
  void put(std::string_view key, std::string_view value) {
    begin(key);
    text_ += value;
  }

  std::string text_;
  std::size_t depth_ = 0;
  bool empty_ = true;
};

}  // namespace ductile::drivers
