#include "output/run_directory.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "scenario/errors.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {
constexpr std::array own_files = {"scenario.toml",  "trajectory.csv", "run.h5",
                                  "run.xdmf",       "frames",         "summary.json",
                                  "trajectory.png", "checkpoint.h5",  "checkpoint-before.h5",
                                  "log.txt"};
constexpr std::string_view unfinished = ".part";

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
  if (!force && !fs::is_empty(directory, error)) {
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
  lock();
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
  lock();
}

RunDirectory::~RunDirectory() {
  if (lock_ >= 0) close(lock_);
}

// The lock is the system's: it ends with the process, however that ends. What is in the file is for
// people to read.
void RunDirectory::lock() {
  const fs::path file = path_ / "lock";
  constexpr mode_t everyone = 0666;
  lock_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, everyone);
  if (lock_ < 0) fail_to_write(file, errno);
  if (flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    const int reason = errno;
    std::array<char, 512> holder{};
    const ssize_t size = read(lock_, holder.data(), holder.size());
    close(std::exchange(lock_, -1));
    std::string_view who(holder.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
    while (who.ends_with('\n')) who.remove_suffix(1);
    // A file system without locks is no reason not to compute.
    if (reason != EWOULDBLOCK) return;
    throw InputError(
        fmt::format("{}: another run is writing there ({}): wait for its end, or "
                    "choose another directory with -o",
                    path_.string(), who));
  }
  const std::string text = lock_text();
  if (ftruncate(lock_, 0) != 0 || pwrite(lock_, text.data(), text.size(), 0) < 0)
    fail_to_write(file, errno);
}

}  // namespace ductile::drivers
