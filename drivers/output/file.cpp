#include "output/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {

constexpr std::string_view unfinished = ".part";

// 0, or the error number.
int write_all(int descriptor, std::uint64_t offset, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t n = pwrite(descriptor, data, size, static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    if (n == 0) return ENOSPC;
    data += n;
    offset += static_cast<std::uint64_t>(n);
    size -= static_cast<std::size_t>(n);
  }
  return 0;
}

int open_file(const fs::path& file, int flags) {
  constexpr mode_t everyone = 0666;  // less the user's mask
  const int descriptor = open(file.c_str(), flags | O_CLOEXEC, everyone);
  if (descriptor < 0) fail_to_write(file, errno);
  return descriptor;
}

}  // namespace

void fail_to_write(const fs::path& file, int error) {
  throw OutputError(fmt::format("cannot write {}: {}", file.string(), std::strerror(error)));
}

void flush_to_disk(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) fail_to_write(path, errno);
  const int error = fsync(descriptor) == 0 ? 0 : errno;
  close(descriptor);
  // Some file systems have nothing to flush for a directory.
  if (error != 0 && error != EINVAL) fail_to_write(path, error);
}

NewFile::NewFile(fs::path file) : file_(std::move(file)), part_(file_) {
  part_ += unfinished;
  descriptor_ = open_file(part_, O_RDWR | O_CREAT | O_TRUNC);
}

NewFile::~NewFile() {
  if (descriptor_ < 0) return;
  close(descriptor_);
  unlink(part_.c_str());
}

void NewFile::write(std::uint64_t offset, const void* data, std::size_t size) noexcept {
  if (error_ != 0) return;
  error_ = write_all(descriptor_, offset, static_cast<const char*>(data), size);
  size_ = std::max(size_, offset + size);
}

void NewFile::read(std::uint64_t offset, void* data, std::size_t size) noexcept {
  auto* to = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t n = pread(descriptor_, to, size, static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && error_ == 0) error_ = errno;
    if (n <= 0) break;
    to += n;
    offset += static_cast<std::uint64_t>(n);
    size -= static_cast<std::size_t>(n);
  }
  std::memset(to, 0, size);
}

void NewFile::check() const {
  if (error_ != 0) fail_to_write(file_, error_);
}

void NewFile::flush() {
  if (error_ == 0 && fsync(descriptor_) != 0) error_ = errno;
  check();
}

void NewFile::commit(Durability durability) {
  if (error_ == 0 && durability == Durability::system && fsync(descriptor_) != 0) error_ = errno;
  if (close(std::exchange(descriptor_, -1)) != 0 && error_ == 0) error_ = errno;
  if (error_ == 0 && std::rename(part_.c_str(), file_.c_str()) != 0) error_ = errno;
  if (error_ != 0) {
    unlink(part_.c_str());
    fail_to_write(file_, error_);
  }
  if (durability == Durability::system) {
    const fs::path directory = file_.parent_path();
    flush_to_disk(directory.empty() ? "." : directory);
  }
}

void write_atomically(const fs::path& file, std::string_view text, Durability durability) {
  NewFile out(file);
  out.write(0, text.data(), text.size());
  out.commit(durability);
}

AppendedFile::AppendedFile(fs::path file, std::uint64_t keep)
    : file_(std::move(file)), descriptor_(open_file(file_, O_WRONLY | O_CREAT)), size_(keep) {
  if (ftruncate(descriptor_, static_cast<off_t>(keep)) != 0) {
    const int error = errno;
    close(descriptor_);
    fail_to_write(file_, error);
  }
}

AppendedFile::~AppendedFile() {
  close(descriptor_);
}

void AppendedFile::append(std::string_view piece) {
  const int error = write_all(descriptor_, size_, piece.data(), piece.size());
  if (error != 0) {
    // A disk that takes no more lets go of what it has taken; if not, the next piece overwrites it.
    static_cast<void>(ftruncate(descriptor_, static_cast<off_t>(size_)) == 0);
    fail_to_write(file_, error);
  }
  size_ += piece.size();
}

void AppendedFile::flush() const {
  if (fsync(descriptor_) != 0) fail_to_write(file_, errno);
}

}  // namespace ductile::drivers
