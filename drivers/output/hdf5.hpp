// HDF5 in C++ terms: handles that close, calls that throw, new files that fail as a whole. Thin,
// over the C API.
#pragma once

#include <hdf5.h>

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "output/file.hpp"

namespace ductile::drivers::hdf5 {

/// While it lives HDF5 does not print its error stack: it goes into our exceptions instead.
class QuietErrors {
 public:
  QuietErrors();
  ~QuietErrors();
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// Throws OutputError: `what` could not be written into the file that holds the object `where`, if
/// one is given, and HDF5's own reason.
[[noreturn]] void fail(std::string_view what, hid_t where);

/// Returns what an HDF5 call returned, or throws OutputError if that says that it failed.
template <typename Result>
Result check(Result result, std::string_view what, hid_t where = H5I_INVALID_HID) {
  if (result < 0) fail(what, where);
  return result;
}

/// An HDF5 identifier, closed at the end of its scope.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close closer, std::string_view what, hid_t where = H5I_INVALID_HID)
      : id_(check(id, what, where)), close_(closer) {}
  Handle(Handle&& other) noexcept
      : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }

  /// Closes now: for a file that is when it reaches the disk, so it may fail.
  void close(std::string_view what) { check(close_(std::exchange(id_, H5I_INVALID_HID)), what); }

 private:
  hid_t id_;
  Close close_;
};

/// A new HDF5 file. HDF5 itself never hears of a write that fails: it cannot close a file then, and
/// ends the program in trouble. drivers::NewFile::commit() tells.
class Writer {
 public:
  /// Where the driver writes to; nothing once the writer is gone.
  struct Sink {
    NewFile* out;
  };

  /// `out` must outlive it, and holds the whole file after close(). Throws OutputError.
  explicit Writer(NewFile& out, hsize_t user_block = 0);
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  [[nodiscard]] hid_t file() const { return file_; }
  /// Throws OutputError.
  void close();

 private:
  std::string name_;
  std::shared_ptr<Sink> sink_;
  Handle file_;
};

/// Fills a new file, which is then to be committed. Throws OutputError.
void write_file(NewFile& out, const std::function<void(hid_t file)>& fill);
/// Replaces `file` by a new HDF5 file that `fill` writes. Throws OutputError.
void write_file(const std::filesystem::path& file, const std::function<void(hid_t file)>& fill);

/// Opens it to be read. Throws OutputError.
Handle open_file(const std::filesystem::path& file);

Handle create_group(hid_t parent, const std::string& name);
/// Makes the group unless there is one.
void need_group(hid_t parent, const std::string& name);
/// `name` in `parent` stands for the root of another file, by a path relative to this one's.
void create_link(hid_t parent, const std::string& name, const std::string& file);

void write_attribute(hid_t object, const char* name, std::string_view text);
void write_attribute(hid_t object, const char* name, double value);
/// A text of any length: an attribute of a fixed one holds 64 kB at most.
void write_long_attribute(hid_t object, const char* name, const std::string& text);
/// A text; empty if there is none of that name.
std::string read_attribute(hid_t object, const char* name);

/// A type in the file and in memory.
struct Type {
  hid_t file;
  hid_t memory;
};
Type doubles();
Type floats();
Type integers();
Type characters();

/// A dataset with the attribute `units`, if any are given. The same data make the same bytes: no
/// times are kept.
void write_dataset(hid_t parent, const std::string& name, std::initializer_list<hsize_t> shape,
                   Type type, const void* values, std::string_view units);

}  // namespace ductile::drivers::hdf5
