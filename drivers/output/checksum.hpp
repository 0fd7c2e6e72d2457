// Checksums of files: XXH3, 64 bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "output/file.hpp"

namespace ductile::drivers {

/// The checksum of bytes that come piece by piece.
class Checksum {
 public:
  Checksum();
  ~Checksum();
  Checksum(const Checksum&) = delete;
  Checksum& operator=(const Checksum&) = delete;

  void add(const void* data, std::size_t size);
  /// Of all so far.
  [[nodiscard]] std::uint64_t value() const;
  /// The same in 16 hexadecimal digits.
  [[nodiscard]] std::string text() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Of what is in the file from `begin` on.
std::uint64_t checksum_of(NewFile& file, std::uint64_t begin);
/// Of a whole file. Throws OutputError if it cannot be read.
std::uint64_t checksum_of(const std::filesystem::path& file);

}  // namespace ductile::drivers
