#include "surfaces.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "run_directory.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {

constexpr const char* data_name = "run.h5";
constexpr const char* description_name = "run.xdmf";

/// Keeps HDF5 from printing its error stack: it goes into our exception instead.
class QuietErrors {
 public:
  QuietErrors() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

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

/// Returns what an HDF5 call returned, or throws if that says that it failed.
template <typename Result>
Result check(Result result, std::string_view what) {
  if (result < 0) {
    throw OutputError(fmt::format("cannot write {} in {}: {}", what, data_name, root_cause()));
  }
  return result;
}

/// An HDF5 identifier, closed at the end of its scope.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close closer, std::string_view what)
      : id_(drivers::check(id, what)), close_(closer) {}
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
  void close(std::string_view what) {
    drivers::check(close_(std::exchange(id_, H5I_INVALID_HID)), what);
  }

 private:
  hid_t id_;
  Close close_;
};

Handle open_file(const fs::path& file, bool create) {
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
  return {H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, name};
}

void write_attribute(hid_t object, const char* name, std::string_view text) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, name);
  check(H5Tset_size(type, text.size()), name);
  check(H5Tset_strpad(type, H5T_STR_NULLPAD), name);
  Handle space(H5Screate(H5S_SCALAR), H5Sclose, name);
  Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, name);
  check(H5Awrite(attribute, type, text.data()), name);
}

void write_attribute(hid_t object, const char* name, double value) {
  Handle space(H5Screate(H5S_SCALAR), H5Sclose, name);
  Handle attribute(H5Acreate2(object, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT),
                   H5Aclose, name);
  check(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value), name);
}

struct Type {
  hid_t file;
  hid_t memory;
};

void write_dataset(hid_t parent, const std::string& name, std::initializer_list<hsize_t> shape,
                   Type type, const void* values, std::string_view units) {
  const std::vector<hsize_t> dims(shape);
  Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr), H5Sclose,
               name);
  Handle dataset(
      H5Dcreate2(parent, name.c_str(), type.file, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose, name);
  check(H5Dwrite(dataset, type.memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), name);
  write_attribute(dataset, "units", units);
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

/// Components with z fastest -> one array with x fastest, components interlaced: the order of
/// XDMF's and VTK's regular meshes.
std::vector<float> x_fastest(const std::array<std::size_t, 3>& nodes,
                             std::span<const std::span<const double>> components) {
  const auto [nx, ny, nz] = nodes;
  std::vector<float> values(nx * ny * nz * components.size());
  std::size_t target = 0;
  for (std::size_t k = 0; k < nz; ++k) {
    for (std::size_t j = 0; j < ny; ++j) {
      for (std::size_t i = 0; i < nx; ++i) {
        for (const auto& component : components) {
          values[target++] = static_cast<float>(component[(i * ny + j) * nz + k]);
        }
      }
    }
  }
  return values;
}

std::string xdmf_item(std::string_view dimensions, std::string_view type, int precision,
                      std::string_view dataset) {
  return fmt::format(
      R"(<DataItem Dimensions="{}" NumberType="{}" Precision="{}" Format="HDF">{}:{}</DataItem>)",
      dimensions, type, precision, data_name, dataset);
}

std::string xdmf_attribute(std::string_view name, std::string_view kind, std::string_view item) {
  return fmt::format(
      "        <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">{}</Attribute>\n", name,
      kind, item);
}

std::string xdmf_grid(std::string_view name, double time, std::string_view content) {
  return fmt::format(
      "      <Grid Name=\"{}\" GridType=\"Uniform\">\n        <Time Value=\"{}\"/>\n{}"
      "      </Grid>\n",
      name, time, content);
}

std::string frame_path(std::size_t frame) {
  return fmt::format("/frames/{:06}", frame);
}

std::string xdmf_surface(const SurfaceMesh& mesh, const SurfaceState& state, std::size_t frame,
                         double time) {
  const std::string data = fmt::format("{}/{}", frame_path(frame), mesh.name);
  const std::string shape = fmt::format("{} 3", mesh.vertices);
  std::string content = fmt::format(
      "        <Topology TopologyType=\"Triangle\" NumberOfElements=\"{}\">{}</Topology>\n"
      "        <Geometry GeometryType=\"XYZ\">{}</Geometry>\n",
      mesh.triangles.size(),
      xdmf_item(fmt::format("{} 3", mesh.triangles.size()), "Int", 4,
                fmt::format("/bodies/{}/triangles", mesh.name)),
      xdmf_item(shape, "Float", 8, data + "/position"));
  for (const auto& [name, values] :
       {std::pair("velocity", state.velocity), std::pair("force", state.force)}) {
    if (values.empty()) continue;
    content += xdmf_attribute(name, "Vector",
                              xdmf_item(shape, "Float", 8, fmt::format("{}/{}", data, name)));
  }
  return xdmf_grid(mesh.name, time, content);
}

// XDMF 2 lists the axes of regular meshes from the slowest to the fastest: z, y, x.
std::string xdmf_fluid(const FluidLattice& lattice, std::size_t frame, double time) {
  const std::string data = frame_path(frame) + "/fluid";
  const std::string shape =
      fmt::format("{} {} {}", lattice.nodes[2], lattice.nodes[1], lattice.nodes[0]);
  const std::string content = fmt::format(
      "        <Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"{0}\"/>\n"
      "        <Geometry GeometryType=\"ORIGIN_DXDYDZ\">\n"
      "          <DataItem Dimensions=\"3\" NumberType=\"Float\" Precision=\"8\" "
      "Format=\"XML\">{1} {2} {3}</DataItem>\n"
      "          <DataItem Dimensions=\"3\" NumberType=\"Float\" Precision=\"8\" "
      "Format=\"XML\">{4} {4} {4}</DataItem>\n"
      "        </Geometry>\n{5}{6}",
      shape, lattice.origin.z(), lattice.origin.y(), lattice.origin.x(), lattice.spacing,
      xdmf_attribute("density", "Scalar", xdmf_item(shape, "Float", 4, data + "/density")),
      xdmf_attribute("velocity", "Vector",
                     xdmf_item(shape + " 3", "Float", 4, data + "/velocity")));
  return xdmf_grid("fluid", time, content);
}

double centre_z(std::span<const double> position) {
  double sum = 0;
  for (std::size_t i = 2; i < position.size(); i += 3) sum += position[i];
  return sum / (static_cast<double>(position.size()) / 3);
}

}  // namespace

Surfaces::Surfaces(const fs::path& directory, std::vector<SurfaceMesh> bodies, double period,
                   const std::optional<FluidLattice>& lattice)
    : data_(directory / data_name),
      description_(directory / description_name),
      bodies_(std::move(bodies)),
      period_(period),
      lattice_(lattice),
      last_time_(-std::numeric_limits<double>::infinity()),
      grids_(bodies_.size() + (lattice ? 1 : 0)) {
  std::set<std::string_view> names = {"fluid"};
  for (const auto& body : bodies_) {
    check_body_name(body.name);
    if (!names.insert(body.name).second) {
      throw std::invalid_argument(fmt::format("body name '{}' is taken", body.name));
    }
    for (const auto& triangle : body.triangles) {
      for (const int vertex : triangle) {
        if (vertex < 0 || static_cast<std::size_t>(vertex) >= body.vertices) {
          throw std::invalid_argument(fmt::format("body '{}' has {} vertices, and a triangle at {}",
                                                  body.name, body.vertices, vertex));
        }
      }
    }
  }
  if (lattice_ && (std::ranges::count(lattice_->nodes, 0U) > 0 || !(lattice_->spacing > 0))) {
    throw std::invalid_argument(fmt::format("fluid lattice of {} x {} x {} nodes, spacing {}",
                                            lattice_->nodes[0], lattice_->nodes[1],
                                            lattice_->nodes[2], lattice_->spacing));
  }

  const QuietErrors quiet;
  Handle file = open_file(data_, true);
  {
    Handle group = create_group(file, "bodies");
    for (const auto& body : bodies_) {
      Handle own = create_group(group, body.name);
      write_dataset(own, "triangles", {body.triangles.size(), 3}, integers(), body.triangles.data(),
                    "vertex index");
    }
    create_group(file, "frames");
  }
  file.close(data_.string());
  write_xdmf();
}

void Surfaces::write(double time, std::span<const SurfaceState> bodies, const FluidState* fluid) {
  check(time, bodies, fluid);
  const double z_offset = period_ > 0 && !bodies.empty()
                              ? period_ * std::floor(centre_z(bodies[0].position) / period_)
                              : 0.0;
  const QuietErrors quiet;
  Handle file = open_file(data_, false);
  {
    Handle frame = create_group(file, frame_path(frames_));
    write_attribute(frame, "time", time);
    write_attribute(frame, "time_units", "W^2/nu");
    write_attribute(frame, "z_offset", z_offset);
    write_attribute(frame, "z_offset_units", "W");
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      Handle own = create_group(frame, bodies_[b].name);
      const hsize_t n = bodies_[b].vertices;
      std::vector<double> position(bodies[b].position.begin(), bodies[b].position.end());
      for (std::size_t i = 2; i < position.size(); i += 3) position[i] -= z_offset;
      write_dataset(own, "position", {n, 3}, doubles(), position.data(), "W");
      if (!bodies[b].velocity.empty()) {
        write_dataset(own, "velocity", {n, 3}, doubles(), bodies[b].velocity.data(), "nu/W");
      }
      if (!bodies[b].force.empty()) {
        write_dataset(own, "force", {n, 3}, doubles(), bodies[b].force.data(), "rho*nu^2");
      }
    }
    if (fluid != nullptr) {
      Handle own = create_group(frame, "fluid");
      const auto [nx, ny, nz] = lattice_->nodes;
      write_dataset(own, "density", {nz, ny, nx}, floats(),
                    x_fastest(lattice_->nodes, {&fluid->density, 1}).data(), "rho");
      write_dataset(own, "velocity", {nz, ny, nx, 3}, floats(),
                    x_fastest(lattice_->nodes, fluid->velocity).data(), "nu/W");
    }
  }
  file.close(data_.string());

  for (std::size_t b = 0; b < bodies.size(); ++b) {
    grids_[b] += xdmf_surface(bodies_[b], bodies[b], frames_, time);
  }
  if (fluid != nullptr) grids_.back() += xdmf_fluid(*lattice_, frames_, time);
  ++frames_;
  last_time_ = time;
  write_xdmf();
}

void Surfaces::check(double time, std::span<const SurfaceState> bodies,
                     const FluidState* fluid) const {
  if (!(time > last_time_)) {
    throw std::invalid_argument(
        fmt::format("frame at t = {} does not follow that at t = {}", time, last_time_));
  }
  if (bodies.size() != bodies_.size()) {
    throw std::invalid_argument(
        fmt::format("frame of {} bodies where {} were announced", bodies.size(), bodies_.size()));
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const std::size_t n = 3 * bodies_[b].vertices;
    const auto fits = [n](std::span<const double> s) { return s.empty() || s.size() == n; };
    if (bodies[b].position.size() != n || !fits(bodies[b].velocity) || !fits(bodies[b].force)) {
      throw std::invalid_argument(fmt::format("frame of body '{}' has not 3 x {} numbers",
                                              bodies_[b].name, bodies_[b].vertices));
    }
  }
  if (fluid == nullptr) return;
  if (!lattice_) throw std::invalid_argument("frame with a fluid, but no lattice was announced");
  const std::size_t n = lattice_->nodes[0] * lattice_->nodes[1] * lattice_->nodes[2];
  for (const auto& field :
       {fluid->density, fluid->velocity[0], fluid->velocity[1], fluid->velocity[2]}) {
    if (field.size() != n) {
      throw std::invalid_argument(
          fmt::format("fluid field of {} numbers for {} nodes", field.size(), n));
    }
  }
}

void Surfaces::write_xdmf() const {
  std::string text =
      "<?xml version=\"1.0\"?>\n<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n<Xdmf Version=\"2.0\">\n"
      "  <!-- lengths in W, times in W^2/nu, velocities in nu/W, forces in rho nu^2 -->\n"
      "  <Domain>\n";
  for (std::size_t g = 0; g < grids_.size(); ++g) {
    if (grids_[g].empty()) continue;
    text += fmt::format(
        "    <Grid Name=\"{}\" GridType=\"Collection\" CollectionType=\"Temporal\">\n{}"
        "    </Grid>\n",
        g < bodies_.size() ? bodies_[g].name : "fluid", grids_[g]);
  }
  text += "  </Domain>\n</Xdmf>\n";
  write_atomically(description_, text);
}

}  // namespace ductile::drivers
