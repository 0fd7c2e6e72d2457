#include "output/surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "output/checksum.hpp"
#include "output/hdf5.hpp"
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
constexpr const char* frames_name = "frames";

constexpr const char* channel_name = "channel";
constexpr const char* fluid_name = "fluid";

/// A quantity that lives on the nodes of a grid: dataset, and unit as users read it.
struct Field {
  const char* name;
  const char* unit;
};
constexpr Field position_field = {"position", "W"};
constexpr Field velocity_field = {"velocity", "nu/W"};
constexpr Field force_field = {"force", "rho*nu^2"};
constexpr Field density_field = {"density", "rho"};
constexpr Field time_field = {"t", "W^2/nu"};
constexpr Field size_field = {"size", "W"};

/// The grid on which fluid is shown: the lattice with its images below a mirror plane, and with
/// the plane at the end of the period.
struct FluidGrid {
  explicit FluidGrid(const FluidLattice& lattice)
      : below(lattice.mirror == fluid::Mirror::none      ? 0
              : lattice.mirror == fluid::Mirror::on_node ? lattice.nodes[1] - 1
                                                         : lattice.nodes[1]),
        nodes{lattice.nodes[0], lattice.nodes[1] + below, lattice.nodes[2] + 1},
        origin(lattice.origin -
               lattice.spacing * static_cast<double>(below) * Eigen::Vector3d::UnitY()) {}

  std::size_t below;  // nodes along y that are images
  std::array<std::size_t, 3> nodes;
  Eigen::Vector3d origin;
};

/// How far the lattice has moved along z: by whole nodes, in the period, and by less than a spacing
/// besides [W].
struct Way {
  Way(const FluidLattice& lattice, double way) {
    const double spacings = way / lattice.spacing;
    const double whole = std::floor(spacings);
    rest = (spacings - whole) * lattice.spacing;
    const auto period = static_cast<double>(lattice.nodes[2]);
    nodes = static_cast<std::size_t>(whole - period * std::floor(whole / period));
  }
  std::size_t nodes;
  double rest;
};

/// Components with z fastest, of the lattice -> one array with x fastest, components interlaced,
/// of the grid: the order of XDMF's and VTK's regular meshes. Of vectors the image has y reversed.
std::vector<float> x_fastest(const FluidLattice& lattice, const Way& way,
                             std::span<const std::span<const double>> components) {
  const FluidGrid grid(lattice);
  const auto [nx, ny, nz] = grid.nodes;
  std::vector<float> values(nx * ny * nz * components.size());
  std::size_t target = 0;
  for (std::size_t k = 0; k < nz; ++k) {
    for (std::size_t j = 0; j < ny; ++j) {
      const bool image = j < grid.below;
      const std::size_t row = image ? lattice.nodes[1] - 1 - j : j - grid.below;
      for (std::size_t i = 0; i < nx; ++i) {
        const std::size_t node = (i * lattice.nodes[1] + row) * lattice.nodes[2] +
                                 (k + lattice.nodes[2] - way.nodes) % lattice.nodes[2];
        for (std::size_t c = 0; c < components.size(); ++c) {
          const double sign = image && components.size() == 3 && c == 1 ? -1 : 1;
          values[target++] = static_cast<float>(sign * components[c][node]);
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
                      std::string_view place) {
  return fmt::format(
      R"(<DataItem Dimensions="{}" NumberType="{}" Precision="{}" Format="HDF">{}</DataItem>)",
      dimensions, type, precision, place);
}

std::string xdmf_values(int count, std::string_view values) {
  return fmt::format(
      R"(<DataItem Dimensions="{}" NumberType="Float" Precision="8" Format="XML">{}</DataItem>)",
      count, values);
}

/// Readers show names and nothing else, so the unit is in the name.
std::string xdmf_attribute(const Field& field, std::string_view kind, std::string_view item,
                           std::string_view centre = "Node") {
  return fmt::format(
      "          <Attribute Name=\"{} [{}]\" AttributeType=\"{}\" Center=\"{}\">{}</Attribute>\n",
      field.name, field.unit, kind, centre, item);
}

// One of ParaView's readers shows the name of the temporal collection around the frames of a block,
// the other that of the innermost grid, which it numbers unless the collection in between has no
// name.
std::string xdmf_grid(std::string_view name, double time, std::string_view content) {
  return fmt::format(
      "      <Grid GridType=\"Collection\" CollectionType=\"Spatial\">\n"
      "        <Time Value=\"{0}\"/>\n"
      "        <Grid Name=\"{1}\" GridType=\"Uniform\">\n"
      "          <Time Value=\"{0}\"/>\n{2}"
      "        </Grid>\n      </Grid>\n",
      time, name, content);
}

std::string frame_name(std::size_t frame) {
  return fmt::format("{:06}", frame);
}

std::string frame_file(std::size_t frame) {
  return fmt::format("{}/{}.h5", frames_name, frame_name(frame));
}

std::string in_data(std::string_view dataset) {
  return fmt::format("{}:/{}", data_name, dataset);
}

std::string in_frame(std::size_t frame, std::string_view part, std::string_view dataset) {
  return fmt::format("{}:/{}/{}", frame_file(frame), part, dataset);
}

// As lines, which hide nothing behind them. Time and size are data of the grid as a whole.
std::string xdmf_channel(const Channel& channel, double time) {
  const std::string content =
      "          <Topology TopologyType=\"Polyline\" NodesPerElement=\"2\" "
      "NumberOfElements=\"12\">" +
      xdmf_item("12 2", "Int", 4, in_data("channel/edges")) +
      "</Topology>\n          <Geometry GeometryType=\"XYZ\">" +
      xdmf_item("8 3", "Float", 8, in_data("channel/corners")) + "</Geometry>\n" +
      xdmf_attribute(time_field, "Scalar", xdmf_values(1, fmt::format("{}", time)), "Grid") +
      xdmf_attribute(
          size_field, "Vector",
          xdmf_values(3, fmt::format("2 {} {}", 2 * channel.half_width_y, channel.length)), "Grid");
  return xdmf_grid(channel_name, time, content);
}

std::string xdmf_surface(const SurfaceMesh& mesh, const Frame::Given& given, std::size_t frame,
                         double time) {
  const std::string shape = fmt::format("{} 3", mesh.vertices);
  std::string content = fmt::format(
      "          <Topology TopologyType=\"Triangle\" NumberOfElements=\"{}\">{}</Topology>\n"
      "          <Geometry GeometryType=\"XYZ\">{}</Geometry>\n",
      mesh.triangles.size(),
      xdmf_item(fmt::format("{} 3", mesh.triangles.size()), "Int", 4,
                in_data(fmt::format("bodies/{}/triangles", mesh.name))),
      xdmf_item(shape, "Float", 8, in_frame(frame, mesh.name, position_field.name)));
  for (const auto& [field, is_given] :
       {std::pair(velocity_field, given.velocity), std::pair(force_field, given.force)}) {
    if (!is_given) continue;
    content += xdmf_attribute(field, "Vector",
                              xdmf_item(shape, "Float", 8, in_frame(frame, mesh.name, field.name)));
  }
  return xdmf_grid(mesh.name, time, content);
}

// XDMF 2 lists the axes of regular meshes from the slowest to the fastest: z, y, x.
std::string xdmf_fluid(const FluidLattice& lattice, std::size_t frame, double time, double way) {
  const FluidGrid grid(lattice);
  const std::string shape = fmt::format("{} {} {}", grid.nodes[2], grid.nodes[1], grid.nodes[0]);
  const std::string content =
      fmt::format(
          "          <Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"{}\"/>\n"
          "          <Geometry GeometryType=\"ORIGIN_DXDYDZ\">\n"
          "            {}\n            {}\n          </Geometry>\n",
          shape,
          xdmf_values(3, fmt::format("{} {} {}", grid.origin.z() + Way(lattice, way).rest,
                                     grid.origin.y(), grid.origin.x())),
          xdmf_values(3, fmt::format("{0} {0} {0}", lattice.spacing))) +
      xdmf_attribute(
          density_field, "Scalar",
          xdmf_item(shape, "Float", 4, in_frame(frame, fluid_name, density_field.name))) +
      xdmf_attribute(
          velocity_field, "Vector",
          xdmf_item(shape + " 3", "Float", 4, in_frame(frame, fluid_name, velocity_field.name)));
  return xdmf_grid(fluid_name, time, content);
}

/// Eight corners, of which corner 4 i + 2 j + k is at the i-th end along x, j-th along y, k-th
/// along z, and the twelve pairs of them that differ in one axis.
void write_channel(hid_t file, const Channel& channel) {
  const Eigen::Vector3d half(1, channel.half_width_y, channel.length / 2);
  std::vector<double> corners;
  std::vector<int> edges;
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      const int bit = 4 >> axis;
      const bool high = (corner & bit) != 0;
      corners.push_back(high ? half[axis] : -half[axis]);
      if (!high) edges.insert(edges.end(), {corner, corner | bit});
    }
  }
  Handle group = create_group(file, channel_name);
  write_dataset(group, "corners", {8, 3}, hdf5::doubles(), corners.data(), position_field.unit);
  write_dataset(group, "edges", {12, 2}, hdf5::integers(), edges.data(), "corner index");
}

double centre_z(std::span<const double> position) {
  double sum = 0;
  for (std::size_t i = 2; i < position.size(); i += 3) sum += position[i];
  return sum / (static_cast<double>(position.size()) / 3);
}

}  // namespace

Surfaces::Surfaces(fs::path directory, std::vector<SurfaceMesh> bodies, const Channel& channel,
                   const std::optional<FluidLattice>& lattice, std::vector<Frame> frames,
                   std::string scenario)
    : directory_(std::move(directory)),
      bodies_(std::move(bodies)),
      channel_(channel),
      lattice_(lattice),
      scenario_(std::move(scenario)),
      grids_(bodies_.size() + 2) {
  if (!(channel_.half_width_y > 0) || !(channel_.length > 0)) {
    throw std::invalid_argument(fmt::format("channel of half-width {} along y, length {}",
                                            channel_.half_width_y, channel_.length));
  }
  std::set<std::string_view> names = {channel_name, fluid_name};
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

  std::error_code error;
  fs::create_directory(directory_ / frames_name, error);
  if (error) fail_to_write(directory_ / frames_name, error.value());
  take_over(std::move(frames));
  write_overview();
}

// Frames beyond those that are known came after what the run goes on from.
void Surfaces::take_over(std::vector<Frame> frames) {
  for (Frame& frame : frames) add(std::move(frame));
  flushed_ = frames_.size();
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory_ / frames_name, error)) {
    const std::string name = entry.path().filename();
    const std::string number = name.substr(0, name.find('.'));
    const bool of_a_frame = name == number + ".h5" || name == number + ".h5.part";
    if (!of_a_frame || number.size() < frame_name(0).size() ||
        !std::ranges::all_of(number, [](unsigned char c) { return std::isdigit(c) != 0; }))
      continue;
    const bool known = name == number + ".h5" && std::stoull(number) < frames_.size();
    if (!known && !fs::remove(entry.path(), error)) break;
  }
  if (error) fail_to_write(directory_ / frames_name, error.value());
}

void Surfaces::remove(const fs::path& directory) {
  std::error_code error;
  for (const char* name : {data_name, description_name, frames_name}) {
    fs::remove_all(directory / name, error);
    if (error) fail_to_write(directory / name, error.value());
  }
}

void Surfaces::require(const fs::path& directory, const std::vector<Frame>& frames) {
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const fs::path file = directory / frame_file(n);
    if (!fs::exists(file)) throw std::runtime_error(fmt::format("{} is missing", file.string()));
    if (checksum_of(file) != frames[n].checksum)
      throw std::runtime_error(fmt::format("{} has changed since it was written", file.string()));
  }
}

void Surfaces::add(Frame frame) {
  const std::size_t number = frames_.size();
  grids_.front() += xdmf_channel(channel_, frame.time);
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    grids_[1 + b] += xdmf_surface(bodies_[b], frame.bodies[b], number, frame.time);
  if (frame.fluid) grids_.back() += xdmf_fluid(*lattice_, number, frame.time, *frame.fluid);
  frames_.push_back(std::move(frame));
}

void Surfaces::write(double time, std::span<const SurfaceState> bodies, const FluidState* fluid) {
  check(time, bodies, fluid);
  Frame written{time, std::nullopt, {}, 0};
  if (fluid != nullptr) written.fluid = fluid->way;
  NewFile out(directory_ / frame_file(frames_.size()));
  hdf5::write_file(out, [&](hid_t frame) {
    write_attribute(frame, "time", time);
    write_attribute(frame, "time_units", time_field.unit);
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      write_body(frame, b, bodies[b]);
      written.bodies.push_back({!bodies[b].velocity.empty(), !bodies[b].force.empty()});
    }
    if (fluid != nullptr) write_fluid(frame, *fluid);
  });
  written.checksum = checksum_of(out, 0);
  out.commit();
  add(std::move(written));
  write_overview();
}

void Surfaces::flush() {
  for (; flushed_ < frames_.size(); ++flushed_) flush_to_disk(directory_ / frame_file(flushed_));
  for (const fs::path& path :
       {directory_ / frames_name, directory_ / data_name, directory_ / description_name})
    flush_to_disk(path);
}

// What run.xdmf names is there before it is named.
void Surfaces::write_overview() const {
  hdf5::write_file(directory_ / data_name, [this](hid_t file) {
    if (!scenario_.empty()) hdf5::write_long_attribute(file, "scenario", scenario_);
    write_attribute(file, "version", DUCTILE_VERSION);
    if (lattice_) write_attribute(file, "spacing", lattice_->spacing);
    write_channel(file, channel_);
    Handle group = create_group(file, "bodies");
    for (const auto& body : bodies_) {
      Handle own = create_group(group, body.name);
      write_dataset(own, "triangles", {body.triangles.size(), 3}, hdf5::integers(),
                    body.triangles.data(), "vertex index");
    }
    Handle frames = create_group(file, frames_name);
    for (std::size_t n = 0; n < frames_.size(); ++n)
      hdf5::create_link(frames, frame_name(n), frame_file(n));
  });
  write_xdmf();
}

void Surfaces::write_body(hid_t frame, std::size_t body, const SurfaceState& state) const {
  Handle own = create_group(frame, bodies_[body].name);
  const hsize_t n = bodies_[body].vertices;
  const double z_offset =
      channel_.length * std::floor(centre_z(state.position) / channel_.length + 0.5);
  write_attribute(own, "z_offset", z_offset);
  write_attribute(own, "z_offset_units", position_field.unit);
  std::vector<double> position = state.position;
  for (std::size_t i = 2; i < position.size(); i += 3) position[i] -= z_offset;
  const auto write = [&](const Field& field, const std::vector<double>& values) {
    if (values.empty()) return;
    write_dataset(own, field.name, {n, 3}, hdf5::doubles(), values.data(), field.unit);
  };
  write(position_field, position);
  write(velocity_field, state.velocity);
  write(force_field, state.force);
}

void Surfaces::write_fluid(hid_t frame, const FluidState& fluid) const {
  Handle own = create_group(frame, fluid_name);
  const Way way(*lattice_, fluid.way);
  write_attribute(own, "z_offset", way.rest);
  write_attribute(own, "z_offset_units", position_field.unit);
  const auto [nx, ny, nz] = FluidGrid(*lattice_).nodes;
  write_dataset(own, density_field.name, {nz, ny, nx}, hdf5::floats(),
                x_fastest(*lattice_, way, std::array{std::span(fluid.density)}).data(),
                density_field.unit);
  write_dataset(own, velocity_field.name, {nz, ny, nx, 3}, hdf5::floats(),
                x_fastest(*lattice_, way, components(fluid.velocity)).data(), velocity_field.unit);
}

void Surfaces::check(double time, std::span<const SurfaceState> bodies,
                     const FluidState* fluid) const {
  if (!frames_.empty() && !(time > frames_.back().time)) {
    throw std::invalid_argument(
        fmt::format("frame at t = {} does not follow that at t = {}", time, frames_.back().time));
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
      "  <Domain>\n"
      "    <Information Name=\"units\" Value=\"coordinates in W, half the channel's width; times "
      "in "
      "W^2/nu; others in the units of their names\"/>\n";
  for (std::size_t g = 0; g < grids_.size(); ++g) {
    if (grids_[g].empty()) continue;
    text += fmt::format(
        "    <Grid Name=\"{}\" GridType=\"Collection\" CollectionType=\"Temporal\">\n{}"
        "    </Grid>\n",
        g == 0                ? channel_name
        : g <= bodies_.size() ? bodies_[g - 1].name
                              : fluid_name,
        grids_[g]);
  }
  text += "  </Domain>\n</Xdmf>\n";
  write_atomically(directory_ / description_name, text);
}

}  // namespace ductile::drivers
