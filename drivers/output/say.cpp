#include "output/say.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <unistd.h>

#include <ctime>
#include <optional>
#include <string>

namespace ductile::drivers {
namespace {

// Of this process, as its streams are.
struct State {
  std::string before;  // said while there was no log
  std::string line;    // begun, not ended
  std::optional<AppendedFile> log;
  const Log* owner = nullptr;  // the one that has opened it
  bool lost = false;
};

State& state() {
  static State the;
  return the;
}

void write_line(State& now, std::string_view line) {
  const std::string stamped =
      fmt::format("{:%F %T}  {}\n", fmt::localtime(std::time(nullptr)), line);
  if (!now.log) {
    now.before += stamped;
    return;
  }
  try {
    now.log->append(stamped);
  } catch (const OutputError&) {
    // What matters more than the log meets the same disk, and is told of.
    return;
  }
}

}  // namespace

void note_in_log(std::string_view text) {
  State& now = state();
  for (const char c : text) {
    if (c == '\n') {
      write_line(now, std::exchange(now.line, {}));
    } else {
      now.line += c;
    }
  }
}

void say(std::FILE* stream, std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stream) == text.size();
  if (!written && stream == stdout) state().lost = true;
  note_in_log(text);
}

void open_missing_streams() {
  for (int descriptor = 0; descriptor <= STDERR_FILENO; ++descriptor) {
    if (fcntl(descriptor, F_GETFD) >= 0) continue;
    // The least that is free is this one. A full device refuses what is written to it.
    if (open(descriptor == STDOUT_FILENO ? "/dev/full" : "/dev/null", O_RDWR) != descriptor) return;
  }
}

bool stdout_lost() {
  return std::fflush(stdout) != 0 || state().lost;
}

Log::Log(const std::filesystem::path& file, bool go_on) {
  State& now = state();
  now.log.reset();  // of a run before this one
  std::error_code error;
  const std::uintmax_t size = go_on ? std::filesystem::file_size(file, error) : 0;
  now.log.emplace(file, error ? 0 : size);
  now.owner = this;
  now.log->append(std::exchange(now.before, {}));
}

Log::~Log() {
  if (state().owner == this) state().log.reset();
}

}  // namespace ductile::drivers
