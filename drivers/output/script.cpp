#include "output/script.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

#include "output/process.hpp"
#include "output/say.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {

constexpr const char* interpreter = "/usr/bin/python3";
// Of the script, and of the program.
constexpr int exit_failed = 1;
constexpr int exit_refused = 2;

std::optional<fs::path> find_script(std::string_view name) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  for (const fs::path& candidate :
       {program.parent_path().parent_path() / "share" / "ductile" / "python" / name,
        fs::path(DUCTILE_PYTHON_DIR) / name}) {
    if (fs::exists(candidate, error)) return candidate;
  }
  return std::nullopt;
}

/// All that can be read from `descriptor` until its other end is closed.
std::string read_all(int descriptor) {
  std::string text;
  std::array<char, 4096> buffer{};
  for (;;) {
    const ssize_t n = read(descriptor, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(n));
  }
}

/// The last line says what went wrong. A line of nothing but colours is none: libraries that have
/// written to a terminal in colour reset it at their end.
std::string_view last_line(std::string_view text) {
  while (!text.empty()) {
    const auto begin = text.find_last_of('\n', text.size() - 1) + 1;  // 0 where there is none
    const std::string_view line = text.substr(begin);
    const bool blank = line.find_first_not_of(" \t\r") == std::string_view::npos;
    if (!blank && line.front() != '\x1b') return line;
    text = text.substr(0, begin == 0 ? 0 : begin - 1);
  }
  return "the script failed without a word";
}

}  // namespace

ScriptEnding run_script(std::string_view name, std::vector<std::string> words, Session session) {
  const auto script = find_script(name);
  if (!script) return {exit_failed, fmt::format("{} not found", name)};
  words.insert(words.begin(), {interpreter, script->string()});
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::vector<std::string> texts = environment_without_job();
  std::vector<char*> environment;
  environment.reserve(texts.size() + 1);
  for (std::string& text : texts) environment.push_back(text.data());
  environment.push_back(nullptr);

  std::array<int, 2> messages{};
  if (pipe2(messages.data(), O_CLOEXEC) != 0) return {exit_failed, std::strerror(errno)};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, messages[1], STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  if (session == Session::own) posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  pid_t child = 0;
  const int error =
      posix_spawn(&child, interpreter, &actions, &attributes, arguments.data(), environment.data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(messages[1]);
  const std::string said = error == 0 ? read_all(messages[0]) : std::string();
  close(messages[0]);
  if (error != 0) return {exit_failed, fmt::format("{}: {}", interpreter, std::strerror(error))};

  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return {exit_failed, std::strerror(errno)};
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {0, {}};
  const bool refused = WIFEXITED(status) && WEXITSTATUS(status) == exit_refused;
  return {refused ? exit_refused : exit_failed, std::string(last_line(said))};
}

int carry_out(std::string_view name, std::vector<std::string> words) {
  const ScriptEnding ended = run_script(name, std::move(words), Session::shared);
  if (ended.code != 0) say(stderr, "{}\n", ended.complaint);
  return ended.code;
}

}  // namespace ductile::drivers
