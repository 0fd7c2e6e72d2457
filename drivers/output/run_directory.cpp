#include "output/run_directory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "scenario/errors.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {
constexpr std::array own_files = {"scenario.toml", "trajectory.csv", "run.h5",
                                  "run.xdmf",      "summary.json",   "trajectory.png"};
constexpr std::string_view unfinished = ".part";
}  // namespace

void write_atomically(const fs::path& file, std::string_view text) {
  fs::path part = file;
  part += unfinished;
  const auto fail = [&](int error) {
    throw OutputError(fmt::format("cannot write {}: {}", file.string(), std::strerror(error)));
  };
  std::FILE* out = std::fopen(part.c_str(), "wb");
  if (out == nullptr) fail(errno);
  const bool written = std::fwrite(text.data(), 1, text.size(), out) == text.size();
  const int write_error = errno;
  const bool closed = std::fclose(out) == 0;
  if (!written || !closed) fail(written ? errno : write_error);
  if (std::rename(part.c_str(), file.c_str()) != 0) fail(errno);
}

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
  const auto fail = [&](std::string_view what) {
    throw OutputError(fmt::format("{} {}: {}", what, path_.string(), error.message()));
  };
  fs::create_directories(path_, error);
  if (error) fail("cannot create");
  for (const char* name : own_files) {
    for (const std::string_view suffix : {std::string_view(), unfinished}) {
      fs::path file = path_ / name;
      file += suffix;
      fs::remove(file, error);
      if (error) fail("cannot remove the old results in");
    }
  }
}

}  // namespace ductile::drivers
