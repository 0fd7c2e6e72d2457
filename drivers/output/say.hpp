// What the program says: on its streams, and in the log of the run that it is at.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>
#include <utility>

#include "output/file.hpp"

namespace ductile::drivers {

/// Prints the text, and keeps it for the log. A stream that takes no more is no reason to end a
/// run: nothing is thrown, see stdout_lost().
void say(std::FILE* stream, std::string_view text);

template <typename... T>
void say(std::FILE* stream, fmt::format_string<T...> format, T&&... values) {
  say(stream, std::string_view(fmt::format(format, std::forward<T>(values)...)));
}

/// Keeps the text for the log alone.
void note_in_log(std::string_view text);

/// For the very start: a stream that the program has been started without is opened, so that no
/// file of a run takes its place. What is said on stdout is then lost, see stdout_lost().
void open_missing_streams();

/// Whether something said on stdout did not get there. Flushes it.
bool stdout_lost();

/// While it lives, all that is said goes into a file too, with the time of day, and so does what
/// was said before it. On the rank that writes a run's files. A disk that is full may lose of it
/// what comes last.
class Log {
 public:
  /// Creates the file, or goes on at its end. Throws OutputError.
  Log(const std::filesystem::path& file, bool go_on);
  ~Log();
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;
};

}  // namespace ductile::drivers
