#include "output/run_directory.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

#include "output/plot.hpp"
#include "output/say.hpp"
#include "scenario/errors.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {
constexpr std::array own_files = {"scenario.toml",
                                  "trajectory.csv",
                                  "run.h5",
                                  "run.xdmf",
                                  "frames",
                                  "summary.json",
                                  "trajectory.png",
                                  "trajectory.pdf",
                                  "trajectory.svg",
                                  "checkpoint.h5",
                                  "checkpoint-before.h5",
                                  "checkpoint-refused.h5",
                                  "log.txt"};
constexpr std::string_view unfinished = ".part";
constexpr std::string_view lock_name = "lock";
constexpr std::string_view log_name = "log.txt";

std::string lock_text() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return fmt::format("process {} on {}\n", getpid(), host.data());
}
}  // namespace

void require_free(const fs::path& directory, bool force) {
  std::error_code error;
  if (!fs::exists(directory, error)) return;
  if (!fs::is_directory(directory, error)) {
    throw InputError(
        fmt::format("{}: is not a directory: choose another with -o", directory.string()));
  }
  // What a run leaves that has died before it began is nothing to lose: a lock, files that it was
  // writing, and beside one of them a log.
  const auto trace = [](const fs::directory_entry& entry) {
    const std::string name = entry.path().filename().string();
    const auto is_part_of = [&name](std::string_view own) {
      return name.starts_with(own) && name.substr(own.size()) == unfinished;
    };
    return name == lock_name || is_part_of(lock_name) || std::ranges::any_of(own_files, is_part_of);
  };
  const bool of_a_run = std::any_of(fs::directory_iterator(directory, error), {}, trace);
  const auto counts = [&](const fs::directory_entry& entry) {
    return !trace(entry) && !(of_a_run && entry.path().filename() == log_name);
  };
  const bool empty = std::none_of(fs::directory_iterator(directory, error), {}, counts);
  if (!force && !empty) {
    throw InputError(fmt::format(
        "{}: is not empty: add --force to replace the run in it, or choose another with -o",
        directory.string()));
  }
}

RunDirectory::RunDirectory(fs::path path, bool force) : path_(std::move(path)) {
  require_free(path_, force);
  std::error_code error;
  fs::create_directories(path_, error);
  if (error) fail_to_write(path_, error.value());
  lock_.emplace(path_, "run");
  require_free(path_, force);  // another run may have come and gone meanwhile
  for (const char* name : own_files) {
    for (const std::string_view suffix : {std::string_view(), unfinished}) {
      fs::path file = path_ / name;
      file += suffix;
      fs::remove_all(file, error);
      if (error) {
        throw OutputError(fmt::format("cannot remove the old results in {}: {}", path_.string(),
                                      error.message()));
      }
    }
  }
}

RunDirectory::RunDirectory(fs::path path) : path_(std::move(path)) {
  lock_.emplace(path_, "run");
}

bool is_locked(const fs::path& directory) {
  const int descriptor = open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool taken = flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(descriptor);
  return taken;
}

DirectoryLock::~DirectoryLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::vector<fs::path> RunDirectory::plots() const {
  std::vector<fs::path> files;
  files.reserve(picture_formats.size());
  for (const std::string_view format : picture_formats)
    files.push_back(path_ / fmt::format("trajectory.{}", format));
  return files;
}

// The lock is on the directory itself, and the system's: it ends with the process, however that
// ends, and nothing that somebody removes takes it away. The file says whose it is.
DirectoryLock::DirectoryLock(const fs::path& directory, std::string_view what) {
  const fs::path file = directory / lock_name;
  descriptor_ = open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0)
    throw OutputError(fmt::format("cannot open {}: {}", directory.string(), std::strerror(errno)));
  if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0) {
    write_atomically(file, lock_text());
    return;
  }
  const int reason = errno;
  close(std::exchange(descriptor_, -1));
  if (reason != EWOULDBLOCK) {
    say(stderr, "warning: {} cannot be locked ({}): see to it that no other {} writes there\n",
        directory.string(), std::strerror(reason), what);
    return;
  }
  std::string who;
  std::getline(std::ifstream(file), who);
  throw InputError(
      fmt::format("{}: another {} is writing there ({}): wait for its end, or choose "
                  "another directory with -o",
                  directory.string(), what, who.empty() ? "of which no more is known" : who));
}

}  // namespace ductile::drivers
