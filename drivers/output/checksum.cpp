#include "output/checksum.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>
#include <vector>

namespace ductile::drivers {

constexpr std::size_t piece = std::size_t{1} << 20U;

struct Checksum::State {
  State() : xxh(XXH3_createState()) {
    if (xxh == nullptr) throw std::bad_alloc();
    XXH3_64bits_reset(xxh);
  }
  ~State() { XXH3_freeState(xxh); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  XXH3_state_t* xxh;
};

Checksum::Checksum() : state_(std::make_unique<State>()) {}
Checksum::~Checksum() = default;

void Checksum::add(const void* data, std::size_t size) {
  XXH3_64bits_update(state_->xxh, data, size);
}

std::uint64_t Checksum::value() const {
  return XXH3_64bits_digest(state_->xxh);
}

std::string Checksum::text() const {
  return fmt::format("{:016x}", value());
}

std::uint64_t checksum_of(NewFile& file, std::uint64_t begin) {
  Checksum checksum;
  std::vector<char> buffer(piece);
  for (std::uint64_t at = begin; at < file.size(); at += piece) {
    const std::size_t n = std::min<std::uint64_t>(piece, file.size() - at);
    file.read(at, buffer.data(), n);
    checksum.add(buffer.data(), n);
  }
  return checksum.value();
}

std::uint64_t checksum_of(const std::filesystem::path& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(file.c_str(), "rb"),
                                                           std::fclose);
  Checksum checksum;
  std::vector<char> buffer(piece);
  for (std::size_t n = piece; in != nullptr && n == piece;) {
    n = std::fread(buffer.data(), 1, piece, in.get());
    checksum.add(buffer.data(), n);
  }
  if (in == nullptr || std::ferror(in.get()) != 0)
    throw OutputError(fmt::format("cannot read {}: {}", file.string(), std::strerror(errno)));
  return checksum.value();
}

}  // namespace ductile::drivers
