// Files that survive: whatever moment the program or the disk fails at, what was complete before is
// still there, whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string_view>

namespace ductile::drivers {

/// Output that could not be written; names the file and the system's reason.
class OutputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What a file outlives.
enum class Durability {
  program,  ///< the end of the program, at any moment
  system    ///< also that of the system: it is on the disk, which takes milliseconds
};

/// Throws OutputError "cannot write FILE: REASON" for an error number.
[[noreturn]] void fail_to_write(const std::filesystem::path& file, int error);

/// Makes a file or a directory's entries outlive the system. Throws OutputError.
void flush_to_disk(const std::filesystem::path& path);

/// Replaces a file: what is written goes into FILE.part, which commit() puts into its place. Until
/// then, and for good if anything fails, the old file stays what it was.
class NewFile {
 public:
  /// Throws OutputError.
  explicit NewFile(std::filesystem::path file);
  /// Without commit() removes FILE.part.
  ~NewFile();
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  [[nodiscard]] const std::filesystem::path& part() const { return part_; }
  /// Writes at `offset`. The first failure is kept for commit(); then nothing more is written.
  void write(std::uint64_t offset, const void* data, std::size_t size) noexcept;
  /// Reads back; zeros beyond what is there. A failure is kept like one to write.
  void read(std::uint64_t offset, void* data, std::size_t size) noexcept;
  /// The end of what was written.
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Throws OutputError if anything could not be written so far.
  void check() const;
  /// Brings it onto the disk. Throws OutputError if anything could not be written.
  void flush();
  /// Throws OutputError if anything could not be written.
  void commit(Durability durability = Durability::program);

 private:
  std::filesystem::path file_;
  std::filesystem::path part_;
  int descriptor_ = -1;
  int error_ = 0;
  std::uint64_t size_ = 0;
};

/// Replaces `file` by one that holds `text`. Throws OutputError.
void write_atomically(const std::filesystem::path& file, std::string_view text,
                      Durability durability = Durability::program);

/// A file that only grows, by whole pieces.
class AppendedFile {
 public:
  /// Creates the file, or keeps the first `keep` bytes of what is there. Throws OutputError.
  explicit AppendedFile(std::filesystem::path file, std::uint64_t keep = 0);
  ~AppendedFile();
  AppendedFile(const AppendedFile&) = delete;
  AppendedFile& operator=(const AppendedFile&) = delete;

  /// Appends the piece and hands it to the system. Throws OutputError; the file then ends where it
  /// ended before.
  void append(std::string_view piece);
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Throws OutputError.
  void flush() const;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  std::uint64_t size_;
};

}  // namespace ductile::drivers
