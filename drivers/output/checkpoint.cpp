#include "output/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>

#include "output/checksum.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {

constexpr std::size_t block_size = 512;
constexpr std::size_t piece = std::size_t{1} << 20U;
constexpr std::string_view title = "ductile checkpoint\n";

using Block = std::array<char, block_size>;

Block block_of(int format, std::uint64_t size, std::uint64_t checksum) {
  Block block{};
  const std::string text =
      fmt::format("{}format {}\nsize {}\nxxh3 {:016x}\n", title, format, size, checksum);
  std::ranges::copy(text, block.begin());
  return block;
}

/// The number after `word` in the text, which then begins after it; nothing if there is none.
template <typename Number>
std::optional<Number> take(std::string_view& text, std::string_view word, int base = 10) {
  if (!text.starts_with(word)) return std::nullopt;
  Number value{};
  const auto [end, error] =
      std::from_chars(text.data() + word.size(), text.data() + text.size(), value, base);
  if (error != std::errc() || end == text.data() + text.size() || *end != '\n') return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end + 1 - text.data()));
  return value;
}

bool fits_float(std::span<const double> numbers) {
  return std::ranges::all_of(
      numbers, [](double x) { return static_cast<double>(static_cast<float>(x)) == x; });
}

std::string slashes(std::string_view name) {
  return fmt::format("/{}", name);
}

}  // namespace

NewCheckpoint::NewCheckpoint(const fs::path& file) : path_(file), out_(file) {
  writer_.emplace(out_, block_size);
}

void NewCheckpoint::put(const std::string& name, hdf5::Type type, std::span<const std::byte> values,
                        std::size_t count) {
  const hdf5::QuietErrors quiet;
  out_.check();
  for (std::size_t end = name.find('/'); end != std::string::npos; end = name.find('/', end + 1))
    hdf5::need_group(writer_->file(), name.substr(0, end));
  Checksum checksum;
  checksum.add(values.data(), values.size());
  hdf5::write_dataset(writer_->file(), name, {count}, type, values.data(), "");
  hdf5::Handle dataset(H5Dopen2(writer_->file(), name.c_str(), H5P_DEFAULT), H5Dclose, name);
  hdf5::write_attribute(dataset, "xxh3", checksum.text());
}

void NewCheckpoint::put(std::string_view name, std::span<const double> numbers) {
  for (const double x : numbers) {
    if (!std::isfinite(x)) throw NotFinite(std::string(name));
  }
  if (fits_float(numbers)) {
    const std::vector<float> narrow(numbers.begin(), numbers.end());
    put(std::string(name), hdf5::floats(), std::as_bytes(std::span(narrow)), narrow.size());
  } else {
    put(std::string(name), hdf5::doubles(), std::as_bytes(numbers), numbers.size());
  }
}

void NewCheckpoint::put(std::string_view name, std::string_view text) {
  put(std::string(name), hdf5::characters(), std::as_bytes(std::span(text)), text.size());
}

void NewCheckpoint::commit(const fs::path& before) {
  writer_->close();
  out_.check();
  const std::uint64_t size = out_.size();
  const Block block = block_of(checkpoint_format, size, checksum_of(out_, block_size));
  out_.write(0, block.data(), block.size());
  out_.flush();  // now, for once it is renamed the old one is not the latest any more
  std::error_code error;
  fs::rename(path_, before, error);
  if (error && error != std::errc::no_such_file_or_directory) fail_to_write(before, error.value());
  out_.commit(Durability::system);
}

Checkpoint::Checkpoint(const fs::path& file) : path_(file) {
  // A pipe would be waited for.
  std::error_code ignored;
  if (fs::exists(file, ignored) && !fs::is_regular_file(file, ignored))
    throw OutputError(fmt::format("cannot read {}: is no file", path_.string()));
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(file.c_str(), "rb"),
                                                           std::fclose);
  // Not to be read now is no reason to go on from an older one.
  if (in == nullptr) {
    throw OutputError(fmt::format("cannot read {}: {}", path_.string(), std::strerror(errno)));
  }
  Block block{};
  const std::size_t begun = std::fread(block.data(), 1, block.size(), in.get());
  std::string_view text(block.data(), begun);
  if (!text.starts_with(title)) refuse("is no checkpoint of ductile");
  text.remove_prefix(title.size());
  const auto format = take<int>(text, "format ");
  if (!format) refuse("is damaged: its first lines cannot be read");
  if (*format != checkpoint_format) {
    refuse(
        fmt::format("is of format {}, and this program knows format {}: go on with the version "
                    "of ductile that wrote it",
                    *format, checkpoint_format));
  }
  const auto size = take<std::uint64_t>(text, "size ");
  const auto sum = take<std::uint64_t>(text, "xxh3 ", 16);
  if (!size || !sum || block != block_of(*format, *size, *sum))
    refuse("is damaged: its first lines cannot be read");
  Checksum checksum;
  std::uint64_t read = begun;
  std::vector<char> buffer(piece);
  for (std::size_t n = piece; n == piece; read += n) {
    n = std::fread(buffer.data(), 1, piece, in.get());
    checksum.add(buffer.data(), n);
  }
  if (std::ferror(in.get()) != 0)
    throw OutputError(fmt::format("cannot read {}: {}", path_.string(), std::strerror(errno)));
  if (read != *size) refuse(fmt::format("is damaged: it has {} of {} bytes", read, *size));
  if (checksum.value() != *sum) {
    refuse(fmt::format("is damaged: its checksum is {}, not {:016x}", checksum.text(), *sum));
  }
  const hdf5::QuietErrors quiet;
  try {
    file_.emplace(hdf5::open_file(path_));
  } catch (const OutputError& error) {
    refuse(error.what());
  }
}

void Checkpoint::refuse(std::string_view reason) const {
  throw CheckpointError(fmt::format("{} {}", path_.string(), reason));
}

hdf5::Handle Checkpoint::open(std::string_view name) const {
  const hid_t dataset = H5Dopen2(*file_, slashes(name).c_str(), H5P_DEFAULT);
  if (dataset < 0) refuse(fmt::format("has no {}", name));
  return {dataset, H5Dclose, name};
}

std::vector<std::byte> Checkpoint::bytes(std::string_view name, std::size_t size_of_one) const {
  try {
    return raw(name, size_of_one);
  } catch (const OutputError&) {  // as the calls of HDF5 name it
    refuse(fmt::format("has {}, which cannot be read", name));
  }
}

std::vector<std::byte> Checkpoint::raw(std::string_view name, std::size_t size_of_one) const {
  const hdf5::Handle dataset = open(name);
  const hdf5::Handle type(H5Dget_type(dataset), H5Tclose, name);
  const hdf5::Handle space(H5Dget_space(dataset), H5Sclose, name);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  if (count < 0 || H5Tget_size(type) != size_of_one) refuse(fmt::format("has no such {}", name));
  std::vector<std::byte> values(static_cast<std::size_t>(count) * size_of_one);
  if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    refuse(fmt::format("has {}, which cannot be read", name));
  Checksum checksum;
  checksum.add(values.data(), values.size());
  if (hdf5::read_attribute(dataset, "xxh3") != checksum.text())
    refuse(fmt::format("is damaged: the checksum of {} is another", name));
  return values;
}

std::vector<double> Checkpoint::numbers(std::string_view name) const {
  const hdf5::QuietErrors quiet;
  std::size_t size = 0;
  {
    const hdf5::Handle dataset = open(name);
    const hdf5::Handle type(H5Dget_type(dataset), H5Tclose, name);
    size = H5Tget_size(type);
    if (H5Tget_class(type) != H5T_FLOAT || (size != sizeof(float) && size != sizeof(double)))
      refuse(fmt::format("has {}, which is not of numbers", name));
  }
  const std::vector<std::byte> values = bytes(name, size);
  std::vector<double> numbers(values.size() / size);
  if (size == sizeof(double)) {
    std::ranges::copy(values, std::as_writable_bytes(std::span(numbers)).begin());
  } else {
    std::vector<float> narrow(numbers.size());
    std::ranges::copy(values, std::as_writable_bytes(std::span(narrow)).begin());
    std::ranges::copy(narrow, numbers.begin());
  }
  return numbers;
}

void Checkpoint::read(std::string_view name, std::span<double> numbers) const {
  const std::vector<double> kept = this->numbers(name);
  if (kept.size() != numbers.size()) {
    refuse(fmt::format("has {} numbers of {}, where this run has {}", kept.size(), name,
                       numbers.size()));
  }
  std::ranges::copy(kept, numbers.begin());
}

std::string Checkpoint::text(std::string_view name) const {
  const hdf5::QuietErrors quiet;
  const std::vector<std::byte> values = bytes(name, 1);
  return {reinterpret_cast<const char*>(values.data()), values.size()};
}

}  // namespace ductile::drivers
