#include "output/hdf5.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

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

// A driver of HDF5 that writes into a NewFile, and always succeeds: what has failed is for
// NewFile::commit() to tell.
using Sink = Writer::Sink;

struct DriverFile {
  H5FD_t base;  // HDF5's own part comes first
  std::shared_ptr<Sink> sink;
  haddr_t end;  // of what HDF5 has allocated
};

DriverFile* of(H5FD_t* file) {
  return reinterpret_cast<DriverFile*>(file);
}
const DriverFile* of(const H5FD_t* file) {
  return reinterpret_cast<const DriverFile*>(file);
}

H5FD_t* driver_open(const char* /*name*/, unsigned /*flags*/, hid_t access, haddr_t /*limit*/) {
  const auto* sink = static_cast<const std::shared_ptr<Sink>* const*>(H5Pget_driver_info(access));
  if (sink == nullptr) return nullptr;
  auto* file = new DriverFile{};
  file->sink = **sink;
  return &file->base;
}

herr_t driver_close(H5FD_t* file) {
  delete of(file);
  return 0;
}

herr_t driver_query(const H5FD_t* /*file*/, unsigned long* features) {
  *features = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
              H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t driver_end(const H5FD_t* file, H5FD_mem_t /*type*/) {
  return of(file)->end;
}

herr_t driver_set_end(H5FD_t* file, H5FD_mem_t /*type*/, haddr_t end) {
  of(file)->end = end;
  return 0;
}

haddr_t driver_size(const H5FD_t* file, H5FD_mem_t /*type*/) {
  const NewFile* out = of(file)->sink->out;
  return std::max<haddr_t>(of(file)->end, out != nullptr ? out->size() : 0);
}

herr_t driver_read(H5FD_t* file, H5FD_mem_t /*type*/, hid_t /*transfer*/, haddr_t at,
                   std::size_t size, void* data) {
  if (NewFile* out = of(file)->sink->out) out->read(at, data, size);
  return 0;
}

herr_t driver_write(H5FD_t* file, H5FD_mem_t /*type*/, hid_t /*transfer*/, haddr_t at,
                    std::size_t size, const void* data) {
  if (NewFile* out = of(file)->sink->out) out->write(at, data, size);
  return 0;
}

// Space that nobody has written to at the end belongs to the file too.
herr_t driver_truncate(H5FD_t* file, hid_t /*transfer*/, hbool_t /*closing*/) {
  const DriverFile& own = *of(file);
  NewFile* out = own.sink->out;
  if (out != nullptr && own.end > out->size()) out->write(own.end - 1, "", 1);
  return 0;
}

hid_t driver() {
  static const hid_t id = [] {
    H5FD_class_t methods{};
    methods.name = "ductile";
    methods.maxaddr = HADDR_MAX / 4;
    methods.fc_degree = H5F_CLOSE_STRONG;
    methods.fapl_size = sizeof(const std::shared_ptr<Sink>*);
    methods.open = driver_open;
    methods.close = driver_close;
    methods.query = driver_query;
    methods.get_eoa = driver_end;
    methods.set_eoa = driver_set_end;
    methods.get_eof = driver_size;
    methods.read = driver_read;
    methods.write = driver_write;
    methods.truncate = driver_truncate;
    std::ranges::fill(methods.fl_map, H5FD_MEM_SUPER);
    return check(H5FDregister(&methods), "driver");
  }();
  return id;
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

Writer::Writer(NewFile& out, hsize_t user_block)
    : name_(out.part().string()), sink_(std::make_shared<Sink>(Sink{&out})), file_([&] {
        const QuietErrors quiet;
        Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "file properties");
        const std::shared_ptr<Sink>* target = &sink_;
        check(H5Pset_driver(access, driver(), &target), "file properties");
        Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "file properties");
        check(H5Pset_userblock(creation, user_block), "file properties");
        return Handle(H5Fcreate(name_.c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose, name_);
      }()) {}

Writer::~Writer() {
  const QuietErrors quiet;
  static_cast<void>(Handle(std::move(file_)));
  sink_->out = nullptr;  // whatever HDF5 still does to a file that it could not close
}

void Writer::close() {
  const QuietErrors quiet;
  file_.close(name_);
}

void write_file(NewFile& out, const std::function<void(hid_t file)>& fill) {
  const QuietErrors quiet;
  Writer writer(out);
  try {
    fill(writer.file());
    writer.close();
  } catch (const OutputError&) {
    out.check();  // is the reason, where there is one
    throw;
  }
}

void write_file(const std::filesystem::path& file, const std::function<void(hid_t file)>& fill) {
  NewFile out(file);
  write_file(out, fill);
  out.commit();
}

Handle open_file(const std::filesystem::path& file) {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "file properties");
  // Locks are for those who write in place; here nobody does.
  check(H5Pset_file_locking(access, false, true), "file properties");
  check(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG), "file properties");
  return {H5Fopen(file.c_str(), H5F_ACC_RDONLY, access), H5Fclose, file.string()};
}

Handle create_group(hid_t parent, const std::string& name) {
  return {H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, name,
          parent};
}

void need_group(hid_t parent, const std::string& name) {
  if (H5Lexists(parent, name.c_str(), H5P_DEFAULT) <= 0) create_group(parent, name);
}

void create_link(hid_t parent, const std::string& name, const std::string& file) {
  check(H5Lcreate_external(file.c_str(), "/", parent, name.c_str(), H5P_DEFAULT, H5P_DEFAULT), name,
        parent);
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

void write_long_attribute(hid_t object, const char* name, const std::string& text) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, name);
  check(H5Tset_size(type, H5T_VARIABLE), name);
  check(H5Tset_cset(type, H5T_CSET_UTF8), name);
  Handle space(H5Screate(H5S_SCALAR), H5Sclose, name);
  Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, name,
                   object);
  const char* begin = text.c_str();
  check(H5Awrite(attribute, type, &begin), name, object);
}

void write_attribute(hid_t object, const char* name, double value) {
  Handle space(H5Screate(H5S_SCALAR), H5Sclose, name);
  Handle attribute(H5Acreate2(object, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT),
                   H5Aclose, name, object);
  check(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value), name, object);
}

std::string read_attribute(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return "";
  Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose, name, object);
  Handle type(H5Aget_type(attribute), H5Tclose, name);
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0) return "";
  std::string text(H5Tget_size(type), '\0');
  if (H5Sget_simple_extent_npoints(Handle(H5Aget_space(attribute), H5Sclose, name)) != 1) return "";
  check(H5Aread(attribute, type, text.data()), name, object);
  return text;
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
Type characters() {
  return {H5T_STD_U8LE, H5T_NATIVE_UCHAR};
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
  if (!units.empty()) write_attribute(dataset, "units", units);
}

}  // namespace ductile::drivers::hdf5
