// HDF5 in C++ terms: handles that close, calls that throw. Thin, over the C API.
#pragma once

#include <hdf5.h>

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

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

/// Creates or replaces the file, or opens it to be written. Throws OutputError.
Handle open_file(const std::filesystem::path& file, bool create);

Handle create_group(hid_t parent, const std::string& name);

void write_attribute(hid_t object, const char* name, std::string_view text);
void write_attribute(hid_t object, const char* name, double value);

/// A type in the file and in memory.
struct Type {
  hid_t file;
  hid_t memory;
};
Type doubles();
Type floats();
Type integers();

/// A dataset with the attribute `units`. The same data make the same bytes: no times are kept.
void write_dataset(hid_t parent, const std::string& name, std::initializer_list<hsize_t> shape,
                   Type type, const void* values, std::string_view units);

}  // namespace ductile::drivers::hdf5
