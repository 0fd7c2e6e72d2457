#include "scenario/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <span>

namespace ductile::drivers {
namespace {

/// The length of the shorter of two words' way into each other: insertions, deletions, changes and
/// swaps of neighbours (optimal string alignment).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      result += fmt::format("\\{}", c);
    } else if (static_cast<unsigned char>(c) < 32 || c == 127) {
      result += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    } else {
      result += c;
    }
  }
  return result + "\"";
}

std::string shortened(std::string text, std::size_t limit) {
  if (text.size() <= limit) return text;
  std::size_t end = limit;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  text.resize(end);
  return text + "...";
}

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= 64 && std::ranges::all_of(text, [](unsigned char c) {
    return (c < 128 && std::isalnum(c) != 0) || c == '-' || c == '_';
  });
}

std::string name_from(const std::string& file) {
  std::string name = std::filesystem::path(file).stem().string().substr(0, 64);
  for (char& c : name) {
    if (!is_name(std::string_view(&c, 1))) c = '-';
  }
  return name.empty() ? "run" : name;
}

std::string short_name(std::string_view key) {
  constexpr std::string_view of_body = "body.";
  if (!key.starts_with(of_body)) return std::string(key.substr(key.rfind('.') + 1));
  std::string name(key.substr(of_body.size()));
  std::replace(name.begin(), name.end(), '.', '-');
  return name;
}

std::string short_value(std::string_view value) {
  std::string text;
  for (const char c : value) {
    const bool plain = is_name(std::string_view(&c, 1)) || c == '.';
    if (c != '"' && c != '[' && c != ']' && c != ' ') text += plain ? c : '-';
  }
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text;
}

std::string suggestion(std::string_view given, const std::vector<std::string_view>& known) {
  if (given.size() > 64) return "";
  // Case and the kind of dash are the commonest slips.
  const auto plain = [](std::string_view word) {
    std::string result(word);
    for (char& c : result)
      c = c == '-' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return result;
  };
  std::string_view best;
  std::size_t least = 1 + std::max<std::size_t>(1, given.size() / 3);
  for (const std::string_view name : known) {
    const std::size_t distance = edit_distance(plain(given), plain(name));
    if (distance < least) {
      least = distance;
      best = name;
    }
  }
  return best.empty() ? "" : fmt::format(" did you mean {}?", in_quotes(best));
}

std::string some_of(const std::vector<std::string>& names) {
  constexpr std::size_t shown = 5;
  const auto first = std::span(names).first(std::min(shown, names.size()));
  return names.size() <= shown
             ? fmt::format("{}", fmt::join(first, ", "))
             : fmt::format("{} and {} more", fmt::join(first, ", "), names.size() - shown);
}

std::string joined(const std::vector<std::string_view>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string duration_text(double seconds) {
  constexpr std::int64_t minute = 60;
  constexpr std::int64_t hour = 3600;
  constexpr std::int64_t day = 86400;
  const auto total = static_cast<std::int64_t>(std::llround(std::max(0.0, seconds)));
  if (total < minute) return fmt::format("{} s", total);
  if (total < hour) return fmt::format("{} min {:02} s", total / minute, total % minute);
  if (total < 2 * day) return fmt::format("{} h {:02} min", total / hour, total % hour / minute);
  return fmt::format("{:.1f} days", seconds / day);
}

std::optional<double> parsed_duration(std::string_view text) {
  // A number from the front, and what comes after it.
  const auto number = [&text]() -> std::optional<double> {
    double value = 0;
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
    if (error != std::errc() || !std::isfinite(value) || value < 0 || text.starts_with('-'))
      return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return value;
  };
  const auto first = number();
  if (!first || text.empty()) return std::nullopt;
  constexpr double day = 86400;
  for (const auto& [unit, seconds] :
       {std::pair("s", 1.0), std::pair("m", 60.0), std::pair("h", 3600.0), std::pair("d", day)}) {
    if (text == unit) return *first * seconds;
  }
  double days = 0;
  double total = *first;
  int parts = 1;
  if (text.starts_with('-')) {
    days = *first;
    text.remove_prefix(1);
    const auto hours = number();
    if (!hours) return std::nullopt;
    total = *hours;
  }
  for (; text.starts_with(':'); ++parts) {
    text.remove_prefix(1);
    const auto next = number();
    if (!next || *next >= 60) return std::nullopt;
    total = 60 * total + *next;
  }
  const bool whole = text.empty() && (days > 0 ? parts == 3 : parts == 2 || parts == 3);
  return whole ? std::optional(days * day + total) : std::nullopt;
}

}  // namespace ductile::drivers
