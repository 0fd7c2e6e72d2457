#include "run_directory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "errors.hpp"

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

void check_body_name(std::string_view name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  if (name.empty() || !std::all_of(name.begin(), name.end(), allowed)) {
    throw std::invalid_argument(
        fmt::format("body name '{}': use letters, digits, '_' and '-' only", name));
  }
}

RunDirectory::RunDirectory(fs::path path, bool force) : path_(std::move(path)) {
  std::error_code error;
  const auto fail = [&](std::string_view what) {
    throw OutputError(fmt::format("{} {}: {}", what, path_.string(), error.message()));
  };
  const fs::file_status status = fs::status(path_, error);
  if (fs::exists(status)) {
    if (!fs::is_directory(status)) {
      throw InputError(fmt::format("output directory {} exists and is a file", path_.string()));
    }
    const bool empty = fs::is_empty(path_, error);
    if (error) fail("cannot read");
    if (!empty && !force) {
      throw InputError(
          fmt::format("output directory {} is not empty: name another, or overwrite its results "
                      "with --force",
                      path_.string()));
    }
    for (const char* name : own_files) {
      for (const std::string_view suffix : {std::string_view(), unfinished}) {
        fs::path file = path_ / name;
        file += suffix;
        fs::remove(file, error);
        if (error) fail("cannot remove the old results in");
      }
    }
  } else {
    fs::create_directories(path_, error);
    if (error) fail("cannot create");
  }
}

}  // namespace ductile::drivers
