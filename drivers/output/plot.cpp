#include "output/plot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "output/say.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {

constexpr const char* interpreter = "/usr/bin/python3";

std::optional<fs::path> find_script(const char* name) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  for (const fs::path& candidate :
       {program.parent_path().parent_path() / "share" / "ductile" / name,
        fs::path(DUCTILE_PYTHON_DIR) / name}) {
    if (fs::exists(candidate, error)) return candidate;
  }
  return std::nullopt;
}

/// The environment without what ties a process to a running MPI job.
std::vector<char*> environment_without_mpi() {
  std::vector<char*> kept;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    bool of_mpi = false;
    for (const std::string_view prefix : {"OMPI_", "PMIX_", "PMI_", "ORTE_", "PRTE_"}) {
      of_mpi = of_mpi || text.starts_with(prefix);
    }
    if (!of_mpi) kept.push_back(*entry);
  }
  kept.push_back(nullptr);
  return kept;
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

/// Python's last line says what went wrong.
std::string_view last_line(std::string_view text) {
  const auto end = text.find_last_not_of('\n');
  if (end == std::string_view::npos) return "the script failed without a word";
  text = text.substr(0, end + 1);
  return text.substr(text.rfind('\n') + 1);
}

/// Lets the script draw `picture` into the directory that is its one argument.
bool draw(const char* script_name, std::string_view picture, const fs::path& directory) {
  const auto warn = [picture](std::string_view reason) {
    say(stderr, "warning: no {}: {}\n", picture, reason);
    return false;
  };
  const auto script = find_script(script_name);
  if (!script) return warn(fmt::format("{} not found", script_name));
  std::string python = interpreter;
  std::string script_text = script->string();
  std::string directory_text = directory.string();
  std::array<char*, 4> arguments = {python.data(), script_text.data(), directory_text.data(),
                                    nullptr};
  const std::vector<char*> environment = environment_without_mpi();

  std::array<int, 2> messages{};
  if (pipe2(messages.data(), O_CLOEXEC) != 0) return warn(std::strerror(errno));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, messages[1], STDERR_FILENO);
  // In a session of its own, so that what kills a job a second after it was told to end lets the
  // picture be drawn.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  pid_t child = 0;
  const int error =
      posix_spawn(&child, interpreter, &actions, &attributes, arguments.data(), environment.data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  close(messages[1]);
  const std::string said = error == 0 ? read_all(messages[0]) : std::string();
  close(messages[0]);
  if (error != 0) return warn(fmt::format("{}: {}", interpreter, std::strerror(error)));

  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return warn(std::strerror(errno));
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return warn(last_line(said));
  return true;
}

}  // namespace

bool plot_trajectory(const fs::path& directory) {
  return draw("plot_trajectory.py", "trajectory.png", directory);
}

bool plot_comparison(const fs::path& directory) {
  return draw("plot_comparison.py", "compare.png", directory);
}

}  // namespace ductile::drivers
