#include "output/hdf5.hpp"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "output/run_directory.hpp"

namespace ductile::drivers::hdf5 {
namespace {

std::string root_cause() {
  std::string cause;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned depth, const H5E_error2_t* error, void* text) -> herr_t {
        if (depth == 0 && error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
        return 0;
      },
      &cause);
  return cause.empty() ? "unknown error in HDF5" : cause;
}

}  // namespace

QuietErrors::QuietErrors() {
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}
QuietErrors::~QuietErrors() {
  H5Eset_auto2(H5E_DEFAULT, function_, data_);
}

void fail(std::string_view what, hid_t where) {
  const std::string cause = root_cause();  // before the next call clears it
  std::array<char, 4096> file{};
  const bool known = where >= 0 && H5Fget_name(where, file.data(), file.size()) > 0;
  throw OutputError(known ? fmt::format("cannot write {} in {}: {}", what, file.data(), cause)
                          : fmt::format("cannot write {}: {}", what, cause));
}

Handle open_file(const std::filesystem::path& file, bool create) {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "file properties");
  // Someone who looks at the last frame, by a lock, must not end the run.
  check(H5Pset_file_locking(access, false, true), "file properties");
  // The file must not outlive its handle through an object left open.
  check(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG), "file properties");
  return {create ? H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access)
                 : H5Fopen(file.c_str(), H5F_ACC_RDWR, access),
          H5Fclose, file.string()};
}

Handle create_group(hid_t parent, const std::string& name) {
  return {H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, name,
          parent};
}

void write_attribute(hid_t object, const char* name, std::string_view text) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, name);
  check(H5Tset_size(type, text.size()), name);
  check(H5Tset_strpad(type, H5T_STR_NULLPAD), name);
  Handle space(H5Screate(H5S_SCALAR), H5Sclose, name);
  Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, name,
                   object);
  check(H5Awrite(attribute, type, text.data()), name, object);
}

void write_attribute(hid_t object, const char* name, double value) {
  Handle space(H5Screate(H5S_SCALAR), H5Sclose, name);
  Handle attribute(H5Acreate2(object, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT),
                   H5Aclose, name, object);
  check(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value), name, object);
}

Type doubles() {
  return {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE};
}
Type floats() {
  return {H5T_IEEE_F32LE, H5T_NATIVE_FLOAT};
}
Type integers() {
  return {H5T_STD_I32LE, H5T_NATIVE_INT};
}

void write_dataset(hid_t parent, const std::string& name, std::initializer_list<hsize_t> shape,
                   Type type, const void* values, std::string_view units) {
  const std::vector<hsize_t> dims(shape);
  Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr), H5Sclose,
               name);
  Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, name);
  check(H5Pset_obj_track_times(creation, false), name);
  Handle dataset(
      H5Dcreate2(parent, name.c_str(), type.file, space, H5P_DEFAULT, creation, H5P_DEFAULT),
      H5Dclose, name, parent);
  check(H5Dwrite(dataset, type.memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), name, parent);
  write_attribute(dataset, "units", units);
}

}  // namespace ductile::drivers::hdf5
