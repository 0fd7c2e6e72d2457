// To be preloaded: writes that fail, and a program that dies in the middle of one.
//
//   FAULT_PATH  a directory: what is written below it is counted, and nothing else
//   FAULT_AT    the number of the operation at which it happens, from 1
//   FAULT_KIND  kill: half of it is done, and the process killed
//               full: from then on nothing can be written, as on a full disk
//               once: it fails, and the next ones do not
//   FAULT_COUNT a file into which the number of operations is written at the end
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

std::atomic<long> count = 0;

std::string_view variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

bool counted(std::string_view path) {
  const std::string_view below = variable("FAULT_PATH");
  return !below.empty() && path.starts_with(below);
}

bool counted(int descriptor) {
  std::array<char, PATH_MAX> path{};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  const ssize_t size = readlink(link.c_str(), path.data(), path.size());
  return size > 0 && counted(std::string_view(path.data(), static_cast<std::size_t>(size)));
}

enum class Fate { goes_on, fails, dies };

Fate next() {
  static const long at = std::atol(variable("FAULT_AT").data());
  static const std::string_view kind = variable("FAULT_KIND");
  const long n = ++count;
  if (at == 0 || n < at || (kind != "full" && n > at)) return Fate::goes_on;
  return kind == "kill" ? Fate::dies : Fate::fails;
}

template <typename Function>
Function real(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

// Runs `whole` or `half` as fate has it.
template <typename Whole, typename Half>
auto meet(bool is_counted, const Whole& whole, const Half& half) -> decltype(whole()) {
  if (!is_counted) return whole();
  switch (next()) {
    case Fate::goes_on:
      return whole();
    case Fate::dies:
      half();
      std::raise(SIGKILL);
      [[fallthrough]];
    case Fate::fails:
      half();
      break;
  }
  errno = ENOSPC;
  return -1;
}

const auto nothing = [] {};

struct Reporter {
  Reporter() = default;
  Reporter(const Reporter&) = delete;
  Reporter& operator=(const Reporter&) = delete;
  ~Reporter() {
    const std::string path(variable("FAULT_COUNT"));
    if (path.empty() || count == 0) return;
    if (std::FILE* out = std::fopen(path.c_str(), "w")) {
      std::fprintf(out, "%ld\n", count.load());
      std::fclose(out);
    }
  }
} reporter;

ssize_t any_pwrite(const char* name, int file, const void* data, std::size_t size, off_t at) {
  using Pwrite = ssize_t (*)(int, const void*, std::size_t, off_t);
  const auto write = real<Pwrite>(name);
  return meet(
      counted(file), [&] { return write(file, data, size, at); },
      [&] { static_cast<void>(write(file, data, size / 2, at)); });
}

}  // namespace

extern "C" {

ssize_t pwrite(int file, const void* data, std::size_t size, off_t at) {
  return any_pwrite("pwrite", file, data, size, at);
}
ssize_t pwrite64(int file, const void* data, std::size_t size, off_t at) {
  return any_pwrite("pwrite64", file, data, size, at);
}
int ftruncate(int file, off_t size) {
  return meet(
      counted(file), [&] { return real<int (*)(int, off_t)>("ftruncate")(file, size); }, nothing);
}
// Of making a file, as for want of inodes.
int open(const char* path, int flags, ...) {
  std::va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  const bool makes = (flags & O_CREAT) != 0 && access(path, F_OK) != 0;
  return meet(
      makes && counted(path),
      [&] { return real<int (*)(const char*, int, ...)>("open")(path, flags, mode); }, nothing);
}
int fsync(int file) {
  return meet(
      counted(file), [&] { return real<int (*)(int)>("fsync")(file); }, nothing);
}
int rename(const char* from, const char* to) {
  return meet(
      counted(from), [&] { return real<int (*)(const char*, const char*)>("rename")(from, to); },
      nothing);
}
int mkdir(const char* path, mode_t mode) {
  return meet(
      counted(path), [&] { return real<int (*)(const char*, mode_t)>("mkdir")(path, mode); },
      nothing);
}

}  // extern "C"
