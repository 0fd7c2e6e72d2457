#include "output/surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "output/hdf5.hpp"
#include "output/run_directory.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {

using hdf5::create_group;
using hdf5::Handle;
using hdf5::write_attribute;
using hdf5::write_dataset;
using suspension::FluidState;
using suspension::SurfaceState;

constexpr const char* data_name = "run.h5";
constexpr const char* description_name = "run.xdmf";

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

std::array<std::span<const double>, 3> components(std::span<const double> vectors) {
  const std::size_t n = vectors.size() / 3;
  return {vectors.first(n), vectors.subspan(n, n), vectors.last(n)};
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
       {std::pair("velocity", &state.velocity), std::pair("force", &state.force)}) {
    if (values->empty()) continue;
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
    if (!is_name(body.name))
      throw std::invalid_argument(fmt::format("body name '{}': must be {}", body.name, name_rule));
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

  const hdf5::QuietErrors quiet;
  Handle file = hdf5::open_file(data_, true);
  {
    Handle group = create_group(file, "bodies");
    for (const auto& body : bodies_) {
      Handle own = create_group(group, body.name);
      write_dataset(own, "triangles", {body.triangles.size(), 3}, hdf5::integers(),
                    body.triangles.data(), "vertex index");
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
  const hdf5::QuietErrors quiet;
  Handle file = hdf5::open_file(data_, false);
  {
    Handle frame = create_group(file, frame_path(frames_));
    write_attribute(frame, "time", time);
    write_attribute(frame, "time_units", "W^2/nu");
    write_attribute(frame, "z_offset", z_offset);
    write_attribute(frame, "z_offset_units", "W");
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      Handle own = create_group(frame, bodies_[b].name);
      const hsize_t n = bodies_[b].vertices;
      std::vector<double> position = bodies[b].position;
      for (std::size_t i = 2; i < position.size(); i += 3) position[i] -= z_offset;
      write_dataset(own, "position", {n, 3}, hdf5::doubles(), position.data(), "W");
      if (!bodies[b].velocity.empty()) {
        write_dataset(own, "velocity", {n, 3}, hdf5::doubles(), bodies[b].velocity.data(), "nu/W");
      }
      if (!bodies[b].force.empty()) {
        write_dataset(own, "force", {n, 3}, hdf5::doubles(), bodies[b].force.data(), "rho*nu^2");
      }
    }
    if (fluid != nullptr) {
      Handle own = create_group(frame, "fluid");
      const auto [nx, ny, nz] = lattice_->nodes;
      write_dataset(own, "density", {nz, ny, nx}, hdf5::floats(),
                    x_fastest(lattice_->nodes, std::array{std::span(fluid->density)}).data(),
                    "rho");
      write_dataset(own, "velocity", {nz, ny, nx, 3}, hdf5::floats(),
                    x_fastest(lattice_->nodes, components(fluid->velocity)).data(), "nu/W");
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
    const auto fits = [n](const std::vector<double>& s) { return s.empty() || s.size() == n; };
    if (bodies[b].position.size() != n || !fits(bodies[b].velocity) || !fits(bodies[b].force)) {
      throw std::invalid_argument(fmt::format("frame of body '{}' has not 3 x {} numbers",
                                              bodies_[b].name, bodies_[b].vertices));
    }
  }
  if (fluid == nullptr) return;
  if (!lattice_) throw std::invalid_argument("frame with a fluid, but no lattice was announced");
  const std::size_t n = lattice_->nodes[0] * lattice_->nodes[1] * lattice_->nodes[2];
  if (fluid->density.size() != n || fluid->velocity.size() != 3 * n) {
    throw std::invalid_argument(fmt::format("fluid of {} densities and {} velocities for {} nodes",
                                            fluid->density.size(), fluid->velocity.size(), n));
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
