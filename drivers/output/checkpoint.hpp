// checkpoint.h5: all that a run needs to go on, to the last bit, on any number of ranks.
//
// An HDF5 file with a user block of 512 bytes, which is text:
//     ductile checkpoint
//     format 3
//     size 1234567
//     xxh3 0123456789abcdef
// the size of the file and the checksum of what follows the block; then zeros. Every data set has
// its own checksum of its bytes as the attribute "xxh3" besides.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "output/file.hpp"
#include "output/hdf5.hpp"

namespace ductile::drivers {

constexpr int checkpoint_format = 3;

/// A checkpoint that is none, is damaged, of an unknown format, or lacks something; names the file.
class CheckpointError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Something that is not a finite number was to be kept: the run has blown up. what() is its name.
class NotFinite : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Writes a checkpoint beside; commit() puts it into its place. Throws OutputError.
class NewCheckpoint {
 public:
  explicit NewCheckpoint(const std::filesystem::path& file);

  /// Numbers under a path such as "state/fluid/f00"; in single precision where that loses nothing.
  /// Throws NotFinite too.
  void put(std::string_view name, std::span<const double> numbers);
  void put(std::string_view name, std::string_view text);
  /// The file, and what was in its place, as `before`, on the disk.
  void commit(const std::filesystem::path& before);

 private:
  void put(const std::string& name, hdf5::Type type, std::span<const std::byte> values,
           std::size_t count);

  std::filesystem::path path_;
  NewFile out_;
  std::optional<hdf5::Writer> writer_;
};

/// A checkpoint that is whole.
class Checkpoint {
 public:
  /// Reads all of it once, before HDF5 sees any of it. Throws CheckpointError; OutputError if the
  /// system does not let it be read.
  explicit Checkpoint(const std::filesystem::path& file);

  /// Throw CheckpointError if there is nothing of that name, or not so many numbers.
  void read(std::string_view name, std::span<double> numbers) const;
  [[nodiscard]] std::vector<double> numbers(std::string_view name) const;
  [[nodiscard]] std::string text(std::string_view name) const;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  [[noreturn]] void refuse(std::string_view reason) const;
  [[nodiscard]] hdf5::Handle open(std::string_view name) const;
  [[nodiscard]] std::vector<std::byte> bytes(std::string_view name, std::size_t size_of_one) const;
  [[nodiscard]] std::vector<std::byte> raw(std::string_view name, std::size_t size_of_one) const;

  std::filesystem::path path_;
  std::optional<hdf5::Handle> file_;
};

}  // namespace ductile::drivers
