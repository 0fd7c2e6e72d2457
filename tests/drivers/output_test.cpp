#include <fmt/format.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "output/plot.hpp"
#include "output/run_directory.hpp"
#include "output/summary.hpp"
#include "output/surfaces.hpp"
#include "output/trajectory.hpp"
#include "output/version.hpp"
#include "run/progress.hpp"
#include "scenario/errors.hpp"
#include "scenario/text.hpp"
#include "support/temporary_directory.hpp"

namespace ductile::drivers {
namespace {

using suspension::BodySample;
using suspension::FluidState;
using suspension::Sample;
using suspension::SurfaceState;

namespace fs = std::filesystem;

class Output : public ::testing::Test {
 protected:
  static std::string read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    EXPECT_TRUE(in) << file;
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(directory_ / name) << text;
  }
  /// Runs a Python program with `directory_` as its argument and returns what it prints.
  [[nodiscard]] std::string python(const std::string& program) const {
    write("program.py", program);
    const std::string command = "/usr/bin/python3 " + (directory_ / "program.py").string() + " " +
                                directory_.string() + " > " + (directory_ / "printed").string();
    EXPECT_EQ(std::system(command.c_str()), 0);
    return read(directory_ / "printed");
  }

  testing_support::TemporaryDirectory temporary_;
  const fs::path& directory_ = temporary_.path();
};

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

/// Quantities after those of all bodies that go on to the end of a row.
std::vector<const char*> only_of(bool capsule) {
  if (capsule) return {"inclination", "phase", "tilt"};
  return {"qw",      "qx",      "qy",       "qz",       "force_x",
          "force_y", "force_z", "torque_x", "torque_y", "torque_z"};
}

/// Numbers that no short decimal stands for.
Sample awkward_sample(double time) {
  Sample sample{time, std::vector<BodySample>(2)};
  for (std::size_t b = 0; b < 2; ++b) {
    BodySample& body = sample.bodies[b];
    const auto s = static_cast<double>(b + 1) + time;
    body["x"] = std::sqrt(s);
    body["y"] = -std::cbrt(s);
    body["z"] = 1e3 * std::exp(s);
    body["vx"] = 1e-17 * std::sin(s);
    body["vy"] = std::nextafter(0.1, 1);
    body["vz"] = 1 / (3 * s);
    body.capsule = b == 1;
    body["deformation"] = std::numeric_limits<double>::denorm_min();
    body["volume_error"] = -std::pow(s, -7);
    body["strain_energy"] = 0.1 + 0.2;
    body["slip"] = 1 / s;
    for (const char* name : only_of(body.capsule)) body[name] = 1 / (s + name[0]);
    for (const char* name : {"omega_x", "omega_y", "omega_z"}) body[name] = -s / name[6];
  }
  sample.flow_rate = std::exp(time);
  return sample;
}

using TrajectoryFile = Output;

TEST_F(TrajectoryFile, ReadsBackBitForBit) {
  const fs::path file = directory_ / "trajectory.csv";
  Trajectory trajectory(file, {"lead", "lag"}, {false, true});
  std::vector<Sample> samples;
  for (int i = 0; i < 20; ++i) {
    samples.push_back(awkward_sample(i / 7.0));
    trajectory.write(samples.back());
    // Every line is in the file at once.
    const auto lines = split(read(file), '\n');
    ASSERT_EQ(lines.size(), samples.size() + 1);
  }
  const auto lines = split(read(file), '\n');
  EXPECT_EQ(lines[0],
            "t[W^2/nu],lead_x[W],lead_y[W],lead_z[W],lead_vx[nu/W],lead_vy[nu/W],lead_vz[nu/W],"
            "lag_x[W],lag_y[W],lag_z[W],lag_vx[nu/W],lag_vy[nu/W],lag_vz[nu/W],dz[W],"
            "flow_rate[nu*W],"
            "lead_slip[nu/W],lead_omega_x[nu/W^2],lead_omega_y[nu/W^2],lead_omega_z[nu/W^2],"
            "lead_qw[1],lead_qx[1],lead_qy[1],lead_qz[1],"
            "lead_force_x[rho*nu^2],lead_force_y[rho*nu^2],lead_force_z[rho*nu^2],"
            "lead_torque_x[rho*nu^2*W],lead_torque_y[rho*nu^2*W],lead_torque_z[rho*nu^2*W],"
            "lag_deformation[1],lag_volume_error[1],lag_strain_energy[k_s*a^2],lag_slip[nu/W],"
            "lag_omega_x[nu/W^2],lag_omega_y[nu/W^2],lag_omega_z[nu/W^2],"
            "lag_inclination[deg],lag_phase[deg],lag_tilt[deg]");
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& s = samples[i];
    std::vector<double> expected = {s.time};
    for (const auto& body : s.bodies) {
      for (const char* name : {"x", "y", "z", "vx", "vy", "vz"}) expected.push_back(body[name]);
    }
    expected.push_back(s.bodies[0]["z"] - s.bodies[1]["z"]);
    expected.push_back(s.flow_rate);
    const auto add = [&](std::size_t b, const std::vector<const char*>& names) {
      for (const char* name : names) expected.push_back(s.bodies[b][name]);
    };
    add(0, {"slip", "omega_x", "omega_y", "omega_z"});
    add(0, only_of(false));
    add(1, {"deformation", "volume_error", "strain_energy", "slip"});
    add(1, {"omega_x", "omega_y", "omega_z"});
    add(1, only_of(true));
    const auto fields = split(lines[i + 1], ',');
    ASSERT_EQ(fields.size(), expected.size());
    for (std::size_t j = 0; j < fields.size(); ++j) {
      EXPECT_EQ(std::strtod(fields[j].c_str(), nullptr), expected[j]) << "column " << j;
    }
  }
}

// A run that goes on has its rows again, to the last bit, and the same file as one that did not
// stop.
TEST_F(TrajectoryFile, GoesOnAfterWhatIsVouchedFor) {
  const fs::path file = directory_ / "t.csv";
  Trajectory::Extent kept;
  std::vector<Sample> first;
  {
    Trajectory trajectory(file, {"lead", "lag"}, {false, true});
    for (int i = 0; i < 6; ++i) {
      if (i == 4) kept = trajectory.extent();
      Sample sample = awkward_sample(i / 7.0);
      sample.bodies[0]["deformation"] = sample.bodies[0]["volume_error"] = 0;  // a rigid body's
      sample.bodies[0]["strain_energy"] = 0;
      if (i == 2) sample.bodies[1]["slip"] = -0.0;
      trajectory.write(sample);
      if (i < 4) first.push_back(sample);
    }
  }
  const std::string straight = read(file);
  std::ofstream(file, std::ios::app) << "0.9,half of a ro";
  std::vector<Sample> samples;
  {
    Trajectory trajectory(file, {"lead", "lag"}, {false, true}, kept, samples);
    ASSERT_EQ(samples.size(), first.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(samples[i].time, first[i].time);
      EXPECT_EQ(samples[i].flow_rate, first[i].flow_rate);
      for (std::size_t b = 0; b < 2; ++b) {
        EXPECT_EQ(samples[i].bodies[b].capsule, first[i].bodies[b].capsule);
        EXPECT_EQ(samples[i].bodies[b].values, first[i].bodies[b].values) << i << " " << b;
      }
    }
    EXPECT_TRUE(std::signbit(samples[2].bodies[1]["slip"]));
    for (int i = 4; i < 6; ++i) trajectory.write(awkward_sample(i / 7.0));
    EXPECT_EQ(trajectory.extent().bytes, straight.size());
  }
  EXPECT_EQ(read(file), straight);
  // Not what it was: left alone.
  const auto refusal = [&] {
    try {
      const Trajectory other(file, {"lead", "lag"}, {false, true}, kept, samples);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  std::string changed = straight;
  changed[kept.bytes - 2] ^= 1;
  write("t.csv", changed);
  EXPECT_NE(refusal().find("t.csv has changed since the checkpoint"), std::string::npos);
  EXPECT_EQ(read(file), changed);
  write("t.csv", straight.substr(0, kept.bytes - 1));
  EXPECT_NE(refusal().find("bytes that the checkpoint has seen"), std::string::npos);
}

TEST_F(TrajectoryFile, HasNoDistanceUnlessOfAPair) {
  Trajectory trajectory(directory_ / "t.csv", {"a"}, {false});
  Sample sample{0, std::vector<BodySample>(1)};
  trajectory.write(sample);
  EXPECT_EQ(read(directory_ / "t.csv").find("dz"), std::string::npos);
  EXPECT_EQ(read(directory_ / "t.csv").find("ahead"), std::string::npos);
  sample.bodies.resize(2);
  EXPECT_THROW(trajectory.write(sample), std::invalid_argument);
}

// Of more than two bodies there is that to the next one ahead, which comes back as it went.
TEST_F(TrajectoryFile, HasTheDistancesAheadOfMoreThanTwo) {
  const fs::path file = directory_ / "t.csv";
  const std::vector<std::string> names = {"a", "b", "c"};
  const std::vector<bool> capsules(3, false);
  Trajectory::Extent kept;
  {
    Trajectory trajectory(file, names, capsules);
    Sample sample{0, std::vector<BodySample>(3), 0.25, {0.5, 1.0 / 3, 3}};
    trajectory.write(sample);
    kept = trajectory.extent();
    sample.ahead.pop_back();
    EXPECT_THROW(trajectory.write(sample), std::invalid_argument);
  }
  const std::string text = read(file);
  EXPECT_NE(text.find("c_vz[nu/W],a_ahead[W],b_ahead[W],c_ahead[W],flow_rate[nu*W],a_slip"),
            std::string::npos)
      << text;
  std::vector<Sample> samples;
  const Trajectory trajectory(file, names, capsules, kept, samples);
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(samples[0].ahead, (std::vector<double>{0.5, 1.0 / 3, 3}));
  EXPECT_EQ(samples[0].flow_rate, 0.25);
}

TEST_F(TrajectoryFile, RefusesWhatItCannotWrite) {
  EXPECT_THROW(Trajectory(directory_ / "missing" / "t.csv", {"a"}, {false}), OutputError);
  EXPECT_THROW(Trajectory(directory_ / "t.csv", {"a,b"}, {false}), std::invalid_argument);
  Trajectory trajectory(directory_ / "t.csv", {"a"}, {false});
  EXPECT_THROW(trajectory.write({0, {BodySample{true}}}), std::invalid_argument);
}

/// An HDF5 file opened for reading through the library's own interface.
class Hdf5 {
 public:
  explicit Hdf5(const fs::path& file) : file_(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT)) {
    EXPECT_GE(file_, 0);
  }
  ~Hdf5() { H5Fclose(file_); }
  Hdf5(const Hdf5&) = delete;
  Hdf5& operator=(const Hdf5&) = delete;

  [[nodiscard]] bool has(const std::string& path) const {
    return H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0;
  }
  [[nodiscard]] std::vector<hsize_t> shape(const std::string& path) const {
    const hid_t dataset = H5Dopen2(file_, path.c_str(), H5P_DEFAULT);
    EXPECT_GE(dataset, 0) << path;
    const hid_t space = H5Dget_space(dataset);
    std::vector<hsize_t> dims(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    H5Sget_simple_extent_dims(space, dims.data(), nullptr);
    H5Sclose(space);
    H5Dclose(dataset);
    return dims;
  }
  template <typename T>
  [[nodiscard]] std::vector<T> values(const std::string& path, hid_t type) const {
    std::size_t count = 1;
    for (const hsize_t n : shape(path)) count *= n;
    std::vector<T> result(count);
    const hid_t dataset = H5Dopen2(file_, path.c_str(), H5P_DEFAULT);
    EXPECT_GE(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, result.data()), 0) << path;
    H5Dclose(dataset);
    return result;
  }
  [[nodiscard]] std::vector<double> doubles(const std::string& path) const {
    return values<double>(path, H5T_NATIVE_DOUBLE);
  }
  [[nodiscard]] double number(const std::string& object, const char* name) const {
    double value = 0;
    const hid_t attribute = H5Aopen_by_name(file_, object.c_str(), name, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value), 0);
    H5Aclose(attribute);
    return value;
  }
  [[nodiscard]] std::string units(const std::string& object) const {
    const hid_t attribute =
        H5Aopen_by_name(file_, object.c_str(), "units", H5P_DEFAULT, H5P_DEFAULT);
    const hid_t type = H5Aget_type(attribute);
    std::string text(H5Tget_size(type), '\0');
    EXPECT_GE(H5Aread(attribute, type, text.data()), 0);
    H5Tclose(type);
    H5Aclose(attribute);
    return text;
  }

 private:
  hid_t file_;
};

/// Two tetrahedra at unlike places, and a small fluid whose every number tells its node.
class SurfaceFiles : public Output {
 protected:
  static constexpr std::array<std::size_t, 3> nodes = {2, 3, 4};

  static std::vector<SurfaceMesh> meshes() {
    return {{"lead", 4, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}}, {"lag", 3, {{0, 1, 2}}}};
  }
  static FluidLattice lattice() { return {nodes, {-1, -0.5, 0.25}, 0.125, fluid::Mirror::none}; }
  /// Longer than any row lies from the origin.
  static Channel long_channel() { return {0.75, 1000}; }
  /// n vertices in a row along z from `z`, 0.1 apart.
  static std::vector<double> row(std::size_t n, double z) {
    std::vector<double> values;
    for (std::size_t i = 0; i < n; ++i) {
      const auto s = static_cast<double>(i);
      values.insert(values.end(), {0.2 + s, -0.3 * s, z + 0.1 * s});
    }
    return values;
  }
  static double value(std::size_t i, std::size_t j, std::size_t k, std::size_t component) {
    return static_cast<double>(1000 * component + 100 * i + 10 * j + k);
  }
  static std::vector<double> field(std::size_t component) {
    std::vector<double> values;
    for (std::size_t i = 0; i < nodes[0]; ++i) {
      for (std::size_t j = 0; j < nodes[1]; ++j) {
        for (std::size_t k = 0; k < nodes[2]; ++k) values.push_back(value(i, j, k, component));
      }
    }
    return values;
  }

  /// Three frames, the fluid in the first and the last.
  // The lattice has moved by `way` when a fluid is written.
  void write_frames(Surfaces& surfaces, double way = 0) const {
    const auto density = field(0);
    std::vector<double> velocity;
    for (std::size_t c = 1; c <= 3; ++c) {
      const auto component = field(c);
      velocity.insert(velocity.end(), component.begin(), component.end());
    }
    const FluidState fluid{way, density, velocity};
    for (int i = 0; i < 3; ++i) {
      const double z = 11.9 + i;
      const auto lead = row(4, z);
      const auto lag = row(3, z - 1);
      const auto speed = row(4, -5);
      const std::vector<SurfaceState> state = {{lead, speed, {}}, {lag, {}, lag}};
      surfaces.write(0.5 * i, state, i == 1 ? nullptr : &fluid);
    }
  }
};

TEST_F(SurfaceFiles, HoldWhatWasGiven) {
  Surfaces surfaces(directory_, meshes(), long_channel(), lattice());
  write_frames(surfaces);
  const Hdf5 file(directory_ / "run.h5");  // while the run goes on

  EXPECT_EQ(file.shape("/bodies/lead/triangles"), (std::vector<hsize_t>{4, 3}));
  EXPECT_EQ(file.values<int>("/bodies/lead/triangles", H5T_NATIVE_INT),
            (std::vector<int>{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}));
  for (int i = 0; i < 3; ++i) {
    const std::string frame = "/frames/00000" + std::to_string(i);
    EXPECT_EQ(file.number(frame, "time"), 0.5 * i);
    EXPECT_EQ(file.doubles(frame + "/lead/position"), row(4, 11.9 + i));
    EXPECT_EQ(file.doubles(frame + "/lead/velocity"), row(4, -5));
    EXPECT_EQ(file.doubles(frame + "/lag/force"), row(3, 10.9 + i));
    EXPECT_FALSE(file.has(frame + "/lag/velocity"));
    EXPECT_EQ(file.units(frame + "/lead/position"), "W");
    EXPECT_EQ(file.units(frame + "/lead/velocity"), "nu/W");
    EXPECT_EQ(file.units(frame + "/lag/force"), "rho*nu^2");
    EXPECT_EQ(file.has(frame + "/fluid"), i != 1);
  }
  // Both ends of the channel are there, which are one plane.
  const auto [nx, ny, nz] = nodes;
  EXPECT_EQ(file.shape("/frames/000002/fluid/density"), (std::vector<hsize_t>{nz + 1, ny, nx}));
  EXPECT_EQ(file.shape("/frames/000002/fluid/velocity"), (std::vector<hsize_t>{nz + 1, ny, nx, 3}));
  const auto density = file.doubles("/frames/000002/fluid/density");
  const auto velocity = file.doubles("/frames/000002/fluid/velocity");
  for (std::size_t k = 0; k <= nz; ++k) {
    for (std::size_t j = 0; j < ny; ++j) {
      for (std::size_t i = 0; i < nx; ++i) {
        const std::size_t node = (k * ny + j) * nx + i;
        EXPECT_EQ(density[node], value(i, j, k % nz, 0));
        for (std::size_t c = 0; c < 3; ++c) {
          EXPECT_EQ(velocity[3 * node + c], value(i, j, k % nz, c + 1));
        }
      }
    }
  }
}

// A plane between nodes makes an image of each row, one on a row of nodes of all but that.
TEST_F(SurfaceFiles, HoldTheImageBelowAMirrorPlane) {
  for (const fluid::Mirror mirror : {fluid::Mirror::between_nodes, fluid::Mirror::on_node}) {
    FluidLattice half = lattice();
    half.mirror = mirror;
    half.origin.y() = mirror == fluid::Mirror::on_node ? 0 : half.spacing / 2;
    Surfaces surfaces(directory_, meshes(), long_channel(), half);
    write_frames(surfaces);
    const Hdf5 file(directory_ / "run.h5");
    const auto [nx, ny, nz] = nodes;
    const std::size_t rows = mirror == fluid::Mirror::on_node ? 2 * ny - 1 : 2 * ny;
    EXPECT_EQ(file.shape("/frames/000000/fluid/density"), (std::vector<hsize_t>{nz + 1, rows, nx}));
    const auto density = file.doubles("/frames/000000/fluid/density");
    const auto velocity = file.doubles("/frames/000000/fluid/velocity");
    const std::string xdmf = read(directory_ / "run.xdmf");
    const double low = half.origin.y() - half.spacing * static_cast<double>(rows - ny);
    EXPECT_NE(xdmf.find(fmt::format(">0.25 {} -1</DataItem>", low)), std::string::npos) << low;
    for (std::size_t k = 0; k < nz; ++k) {
      for (std::size_t row = 0; row < rows; ++row) {
        // Where the row lies says whose image it is.
        const double y = low + half.spacing * static_cast<double>(row);
        const auto j =
            static_cast<std::size_t>(std::llround((std::abs(y) - half.origin.y()) / half.spacing));
        for (std::size_t i = 0; i < nx; ++i) {
          const std::size_t node = (k * rows + row) * nx + i;
          EXPECT_EQ(density[node], value(i, j, k, 0));
          EXPECT_EQ(velocity[3 * node], value(i, j, k, 1));
          EXPECT_EQ(velocity[3 * node + 1], (y < 0 ? -1 : 1) * value(i, j, k, 2));
          EXPECT_EQ(velocity[3 * node + 2], value(i, j, k, 3));
        }
      }
    }
  }
}

// A lattice that moves takes its nodes along, and the period brings them back: by whole nodes in
// the order of the rows, by the rest of its way in z_offset and in the origin.
TEST_F(SurfaceFiles, ShowAMovingLatticeWhereItIs) {
  for (const double way : {0.6, -0.6}) {  // 4.8 spacings
    const FluidLattice moving = lattice();
    Surfaces surfaces(directory_, meshes(), long_channel(), moving);
    write_frames(surfaces, way);
    const Hdf5 file(directory_ / "run.h5");
    const auto [nx, ny, nz] = nodes;
    const double rest = way > 0 ? 0.8 : 0.2;
    const std::size_t whole = way > 0 ? 4 : nz * 2 - 5;
    EXPECT_NEAR(file.number("/frames/000002/fluid", "z_offset"), rest * moving.spacing, 1e-12);
    const auto density = file.doubles("/frames/000002/fluid/density");
    for (std::size_t k = 0; k <= nz; ++k) {
      for (std::size_t j = 0; j < ny; ++j) {
        for (std::size_t i = 0; i < nx; ++i)
          EXPECT_EQ(density[((k + whole) % nz * ny + j) * nx + i], value(i, j, k % nz, 0));
      }
    }
    const double z = moving.origin.z() + rest * moving.spacing;
    EXPECT_NE(read(directory_ / "run.xdmf").find(fmt::format(">{} -0.5 -1</DataItem>", z)),
              std::string::npos)
        << z;
  }
}

// The fluid spans [-L/2, L/2): each body's centre is brought there, wherever the others are, and
// position + z_offset is where it was.
TEST_F(SurfaceFiles, ComeBackIntoTheChannelEachByItself) {
  constexpr double length = 12;
  Surfaces surfaces(directory_, meshes(), Channel{1, length});
  double time = 0;
  const std::array centres = {5.9, 6.1, -0.2, -5.9, 200.0};
  for (const double z : centres) {
    const auto lead = row(4, z - 0.15);  // its centre at z
    const auto lag = row(3, z - 1.1);    // at z - 1
    surfaces.write(time, std::vector<SurfaceState>{{lead, {}, {}}, {lag, {}, {}}});
    time += 1;
  }
  const Hdf5 file(directory_ / "run.h5");
  const auto offset = [&](std::size_t i, const char* body) {
    return file.number(fmt::format("/frames/{:06}/{}", i, body), "z_offset");
  };
  const std::array expected_lead = {0.0, 12.0, 0.0, 0.0, 204.0};
  const std::array expected_lag = {0.0, 0.0, 0.0, -12.0, 204.0};
  for (std::size_t i = 0; i < centres.size(); ++i) {
    EXPECT_EQ(offset(i, "lead"), expected_lead[i]) << i;
    EXPECT_EQ(offset(i, "lag"), expected_lag[i]) << i;
    const auto lead = file.doubles(fmt::format("/frames/{:06}/lead/position", i));
    const double centre = (lead[2] + lead[5] + lead[8] + lead[11]) / 4;
    EXPECT_GE(centre, -length / 2 - 1e-12);
    EXPECT_LT(centre, length / 2);
    EXPECT_NEAR(centre + offset(i, "lead"), centres[i], 1e-12);
    const auto lag = file.doubles(fmt::format("/frames/{:06}/lag/position", i));
    EXPECT_NEAR(lag[5] + offset(i, "lag"), centres[i] - 1, 1e-12);
  }
}

// More than an attribute of fixed length may hold; h5py reads it as text.
TEST_F(SurfaceFiles, SayWhatWasRun) {
  std::string scenario = "name = \"a\"\n";
  while (scenario.size() < 200000) scenario += "# of many bodies, \u00b5\n";
  write_atomically(directory_ / "scenario.toml", scenario);
  const Surfaces surfaces(directory_, meshes(), long_channel(), lattice(), {}, scenario);
  EXPECT_EQ(python(R"(
import h5py, sys
with h5py.File(sys.argv[1] + '/run.h5') as run, open(sys.argv[1] + '/scenario.toml') as given:
    assert run.attrs['scenario'] == given.read()
    print(run.attrs['version'].decode(), run.attrs['spacing'])
)"),
            fmt::format("{} {}\n", versions().front().second, lattice().spacing));
}

// Twelve edges, each once, along one axis from end to end.
TEST_F(SurfaceFiles, OutlineTheChannel) {
  const Surfaces surfaces(directory_, meshes(), Channel{0.75, 12});
  const Hdf5 file(directory_ / "run.h5");
  const auto corners = file.doubles("/channel/corners");
  const auto edges = file.values<int>("/channel/edges", H5T_NATIVE_INT);
  ASSERT_EQ(file.shape("/channel/corners"), (std::vector<hsize_t>{8, 3}));
  ASSERT_EQ(file.shape("/channel/edges"), (std::vector<hsize_t>{12, 2}));
  EXPECT_EQ(file.units("/channel/corners"), "W");
  const std::array<double, 3> half = {1, 0.75, 6};
  std::set<std::array<double, 3>> middles;
  for (std::size_t e = 0; e < 12; ++e) {
    std::array<double, 3> middle{};
    int zeros = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double from = corners[3 * static_cast<std::size_t>(edges[2 * e]) + axis];
      const double to = corners[3 * static_cast<std::size_t>(edges[2 * e + 1]) + axis];
      EXPECT_EQ(std::abs(from), half[axis]);
      EXPECT_EQ(std::abs(to), half[axis]);
      middle[axis] = (from + to) / 2;
      if (middle[axis] == 0) ++zeros;
    }
    EXPECT_EQ(zeros, 1);
    EXPECT_TRUE(middles.insert(middle).second);
  }
}

// Parsed by an XML reader that is not ours; every reference must lead to a dataset of the shape and
// type that the XDMF claims.
TEST_F(SurfaceFiles, XdmfIsWellFormedAndDescribesExistingData) {
  Surfaces surfaces(directory_, meshes(), Channel{0.75, 12}, lattice());
  write_frames(surfaces);
  const std::string printed = python(R"(
import sys, xml.etree.ElementTree as xml
domain = xml.parse(sys.argv[1] + '/run.xdmf').getroot().find('Domain')
for collection in domain.findall('Grid'):
    assert collection.get('GridType') == 'Collection'
    assert collection.get('CollectionType') == 'Temporal'
    name = collection.get('Name')
    for frame in collection:
        # Of these only the uniform grids have names, or the Xdmf3 reader numbers them.
        assert frame.get('CollectionType') == 'Spatial' and frame.get('Name') is None
        assert frame.find('Grid').get('Name') == name
        assert frame.find('Time').get('Value') == frame.find('Grid/Time').get('Value')
    print('collection', name, *(frame.find('Time').get('Value') for frame in collection))
    print('names', *sorted({a.get('Name') for a in collection.iter('Attribute')}), sep=', ')
for item in domain.iter('DataItem'):
    if item.get('Format') == 'HDF':
        print('data', item.text, item.get('NumberType') + item.get('Precision'), item.get('Dimensions'))
topology = domain.find(".//Topology[@TopologyType='3DCoRectMesh']")
geometry = domain.find(".//Geometry[@GeometryType='ORIGIN_DXDYDZ']")
print('lattice', topology.get('Dimensions'), '|', *(item.text for item in geometry))
)");
  std::vector<std::string> others;
  std::set<std::string> files;  // relative to run.xdmf
  int datasets = 0;
  for (const std::string& line : split(printed, '\n')) {
    const auto words = split(line, ' ');
    if (words[0] != "data") {
      others.push_back(line);
      continue;
    }
    ++datasets;
    const auto reference = split(words[1], ':');
    ASSERT_EQ(reference.size(), 2U) << words[1];
    const std::string& path = reference[1];
    files.insert(reference[0]);
    const Hdf5 file(directory_ / reference[0]);
    ASSERT_TRUE(file.has(path)) << path;
    std::vector<hsize_t> claimed;
    for (std::size_t i = 3; i < words.size(); ++i) claimed.push_back(std::stoull(words[i]));
    EXPECT_EQ(file.shape(path), claimed) << path;
    const bool index =
        path.find("triangles") != std::string::npos || path.find("edges") != std::string::npos;
    EXPECT_EQ(words[2], index                                     ? "Int4"
                        : path.find("fluid") != std::string::npos ? "Float4"
                                                                  : "Float8");
  }
  EXPECT_EQ(files, (std::set<std::string>{"frames/000000.h5", "frames/000001.h5",
                                          "frames/000002.h5", "run.h5"}));
  // Of 3 frames: the channel's corners and edges; 2 bodies with triangles and positions, velocity
  // of one, force of the other; of 2 frames density and velocity of the fluid.
  EXPECT_EQ(datasets, 3 * 2 + 3 * 6 + 2 * 2);
  EXPECT_EQ(others, (std::vector<std::string>{
                        "collection channel 0 0.5 1", "names, size [W], t [W^2/nu]",
                        "collection lead 0 0.5 1", "names, velocity [nu/W]",
                        "collection lag 0 0.5 1", "names, force [rho*nu^2]", "collection fluid 0 1",
                        "names, density [rho], velocity [nu/W]",
                        "lattice 5 3 2 | 0.25 -0.5 -1 0.125 0.125 0.125"}));
}

TEST_F(SurfaceFiles, StayReadableWhenAFrameFails) {
  Surfaces surfaces(directory_, meshes(), long_channel(), lattice());
  write_frames(surfaces);
  const std::string before = read(directory_ / "run.xdmf");
  const std::string overview = read(directory_ / "run.h5");
  fs::create_directory(directory_ / "frames/000003.h5.part");  // in the way
  const auto lead = row(4, 0);
  const auto lag = row(3, 0);
  const std::vector<SurfaceState> state = {{lead, {}, {}}, {lag, {}, {}}};
  try {
    surfaces.write(9, state);
    FAIL() << "wrote through a directory";
  } catch (const OutputError& error) {
    EXPECT_NE(std::string(error.what()).find("frames/000003.h5"), std::string::npos);
  }
  EXPECT_EQ(read(directory_ / "run.xdmf"), before);
  EXPECT_EQ(read(directory_ / "run.h5"), overview);
  const Hdf5 file(directory_ / "run.h5");
  EXPECT_TRUE(file.has("/frames/000002/lead/position"));
  EXPECT_FALSE(file.has("/frames/000003"));
  // Once it can be written, it is the next one.
  fs::remove(directory_ / "frames/000003.h5.part");
  surfaces.write(9, state);
  EXPECT_TRUE(Hdf5(directory_ / "run.h5").has("/frames/000003/lead/position"));
}

// What the run goes on after stays as it is, and what came later goes.
TEST_F(SurfaceFiles, GoOnAfterTheFramesThatAreKnown) {
  std::vector<Frame> first;
  const auto lead = row(4, 0);
  const auto lag = row(3, 0);
  const std::vector<SurfaceState> state = {{lead, lead, {}}, {lag, {}, lag}};
  const auto content = [this] {
    std::vector<std::string> all = {read(directory_ / "run.h5"), read(directory_ / "run.xdmf")};
    for (const char* frame : {"0", "1", "2"})
      all.push_back(read(directory_ / "frames" / ("00000" + std::string(frame) + ".h5")));
    return all;
  };
  {
    Surfaces surfaces(directory_, meshes(), long_channel());
    surfaces.write(0, state);
    surfaces.write(1, state);
    first = surfaces.frames();
    surfaces.write(2, state);
  }
  const auto straight = content();
  write("frames/000007.h5.part", "half of a frame");
  Surfaces surfaces(directory_, meshes(), long_channel(), std::nullopt, first);
  EXPECT_FALSE(fs::exists(directory_ / "frames/000002.h5"));
  EXPECT_FALSE(fs::exists(directory_ / "frames/000007.h5.part"));
  EXPECT_THROW(surfaces.write(1, state), std::invalid_argument);
  surfaces.write(2, state);
  EXPECT_EQ(content(), straight);
  write("frames/notes.txt", "mine");
  EXPECT_NO_THROW(Surfaces::require(directory_, first));
  std::string bytes = read(directory_ / "frames/000001.h5");
  bytes[bytes.size() / 2] ^= 1;
  write("frames/000001.h5", bytes);
  EXPECT_THROW(Surfaces::require(directory_, first), std::runtime_error);
  fs::remove(directory_ / "frames/000001.h5");
  EXPECT_THROW(Surfaces::require(directory_, first), std::runtime_error);
}

TEST_F(SurfaceFiles, RefuseWhatDoesNotFit) {
  EXPECT_THROW(Surfaces(directory_, {{"a/b", 3, {}}}, Channel{1, 12}), std::invalid_argument);
  EXPECT_THROW(Surfaces(directory_, {{"a", 3, {}}, {"a", 3, {}}}, Channel{1, 12}),
               std::invalid_argument);
  EXPECT_THROW(Surfaces(directory_, {{"fluid", 3, {}}}, Channel{1, 12}), std::invalid_argument);
  EXPECT_THROW(Surfaces(directory_, {{"a", 3, {{0, 1, 3}}}}, Channel{1, 12}),
               std::invalid_argument);
  EXPECT_THROW(Surfaces(directory_, {{"channel", 3, {}}}, Channel{1, 12}), std::invalid_argument);
  EXPECT_THROW(Surfaces(directory_, meshes(), Channel{1, 0}), std::invalid_argument);
  FluidLattice no_rows = lattice();
  no_rows.nodes[1] = 0;
  EXPECT_THROW(Surfaces(directory_, {}, Channel{1, 12}, no_rows), std::invalid_argument);
  EXPECT_THROW(Surfaces(directory_ / "missing", meshes(), Channel{1, 12}), OutputError);

  Surfaces surfaces(directory_, meshes(), Channel{1, 12});
  const auto lead = row(4, 0);
  const auto lag = row(3, 0);
  const std::vector<SurfaceState> state = {{lead, {}, {}}, {lag, {}, {}}};
  surfaces.write(1, state);
  EXPECT_THROW(surfaces.write(1, state), std::invalid_argument);
  EXPECT_THROW(surfaces.write(2, std::vector<SurfaceState>{{lead, {}, {}}}), std::invalid_argument);
  EXPECT_THROW(surfaces.write(2, std::vector<SurfaceState>{{lead, lag, {}}, {lag, {}, {}}}),
               std::invalid_argument);
  const FluidState fluid{};
  EXPECT_THROW(surfaces.write(2, state, &fluid), std::invalid_argument);
}

using Directory = Output;

TEST_F(Directory, IsCreatedWithItsParents) {
  const RunDirectory run(directory_ / "a" / "b", false);
  run.write_scenario("nodes = 36\n");
  EXPECT_EQ(read(directory_ / "a" / "b" / "scenario.toml"), "nodes = 36\n");
}

TEST_F(Directory, MayExistIfEmpty) {
  EXPECT_NO_THROW(RunDirectory(directory_, false));
}

TEST_F(Directory, IsRefusedIfNotEmpty) {
  write("notes.txt", "mine");
  EXPECT_THROW(RunDirectory(directory_, false), InputError);
  EXPECT_EQ(read(directory_ / "notes.txt"), "mine");
  EXPECT_THROW(RunDirectory(directory_ / "notes.txt", true), InputError);
}

TEST_F(Directory, LosesOnlyItsOwnResultsToForce) {
  for (const char* name : {"scenario.toml", "trajectory.csv", "run.h5", "run.xdmf", "summary.json",
                           "trajectory.png", "run.xdmf.part", "notes.txt", "my-trajectory.csv",
                           "checkpoint.h5", "checkpoint-before.h5", "checkpoint.h5.part", "log.txt",
                           "trajectory.pdf", "trajectory.svg", "trajectory.png.part"}) {
    write(name, "old");
  }
  fs::create_directory(directory_ / "frames");
  write("frames/000000.h5", "old");
  const RunDirectory run(directory_, true);
  std::vector<std::string> left;
  for (const auto& entry : fs::directory_iterator(directory_)) {
    left.push_back(entry.path().filename());
  }
  std::ranges::sort(left);
  EXPECT_EQ(left, (std::vector<std::string>{"lock", "my-trajectory.csv", "notes.txt"}));
}

// Within one process too; in others tests/drivers/world.py tries it.
TEST_F(Directory, IsOneRunsAtATime) {
  {
    const RunDirectory run(directory_, false);
    try {
      const RunDirectory other(directory_, true);
      FAIL() << "two runs in one directory";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("another run is writing there (process "),
                std::string::npos)
          << error.what();
    }
    EXPECT_THROW(RunDirectory other(directory_), InputError);
  }
  EXPECT_NO_THROW(RunDirectory(directory_, true));
}

TEST_F(Directory, ReplacesFilesWholeOrNotAtAll) {
  const fs::path file = directory_ / "summary.json";
  write_atomically(file, "one");
  write_atomically(file, "two");
  EXPECT_EQ(read(file), "two");
  EXPECT_FALSE(fs::exists(file.string() + ".part"));
  fs::create_directory(directory_ / "summary.json.part");  // in the way of the next one
  EXPECT_THROW(write_atomically(file, "three"), OutputError);
  EXPECT_EQ(read(file), "two");
}

class SummaryFile : public Output {
 protected:
  static Summary full() {
    Summary s;
    s.scenario = "M2 \"x_lag = 0\" \\ tab\t line\n \u00b5";
    s.status = RunStatus::blew_up;
    s.blow_up = BlowUp{
        123456789012, "lag", 17, "speed 0.7 exceeds 0.3", Eigen::Vector3d(0.5, -0.25, 1), "a wall"};
    s.time = 0.1 + 0.2;
    s.steps = 400;
    s.verdict = Verdict{PairClass::damped, 47, "dz rests at 1.2"};
    s.verdict->distance = Outlook{Outlook::State::resting, 1.2, 0, 1.2, 0, true, 0.03};
    s.dz = std::sqrt(2.0);
    BodySummary lead{"lead", {0.1, -0.0, 1e300}, {0, 1.0 / 3, std::nan("")}, {}, {}};
    lead.lateral = Outlook{Outlook::State::resting, 0.3, 1e-4, 0.3, 0, true, 0.009};
    BodySummary lag = lead;
    lag.name = "lag";
    lag.lateral.reset();
    lag.capsule = CapsuleSummary{75000,
                                 0.002,
                                 0.1,
                                 0.0018,
                                 Outlook{Outlook::State::moving, 0.0018, 1e-3, 0.0018, 0, false},
                                 {500, 1200, 9000, 700, 3}};
    s.bodies = {lead, lag};
    s.warnings = {"strain energy of lag has not settled"};
    s.wall_time = 61.5;
    s.updates_per_second = 6.02e7;
    s.ranks = 2;
    s.profile =
        RunProfile{400, {{1, 2, 3, 4, 5, 6, 7, 8, 9}, {0.1, 0, 0, 0, 0, 0, 0, 0, 1e-9}}, {1500, 0}};
    s.parameters = {
        {"channel.nodes", "36"}, {"body.lag.x", "-0.2"}, {"fluid.collision", "\"trt\""}};
    s.versions = {{"ductile", "0.1.0"}, {"PETSc", "3.18.5"}};
    return s;
  }
};

TEST_F(SummaryFile, IsJsonWithEveryNumberIntact) {
  write_summary(directory_ / "summary.json", full());
  EXPECT_EQ(python(R"(
import json, math, sys
s = json.load(open(sys.argv[1] + '/summary.json', encoding='utf-8'))
lead, lag = s['bodies']
assert s['scenario'] == 'M2 "x_lag = 0" \\ tab\t line\n \u00b5', s['scenario']
assert s['status'] == 'blew up'
assert s['blow_up'] == {'step': 123456789012, 'body': 'lag', 'vertex': 17,
                        'place_W': [0.5, -0.25, 1], 'reason': 'speed 0.7 exceeds 0.3',
                        'likely_cause': 'a wall'}
assert s['time_W2_over_nu'] == 0.1 + 0.2 and s['steps'] == 400
assert (s['verdict'], s['verdict_time'], s['verdict_reason']) == ('damped', 47, 'dz rests at 1.2')
assert s['dz_W'] == math.sqrt(2) and (s['dz_limit_W'], s['dz_limit_error_W']) == (1.2, 0.03)
assert lead['name'] == 'lead' and lead['position_W'] == [0.1, 0, 1e300]
assert lead['velocity_nu_over_W'] == [0, 1/3, None]
assert lead['x_settled'] is True and lead['x_limit_W'] == 0.3 and lead['x_rate_nu_over_W'] == 1e-4
assert lead['x_limit_error_W'] == 0.009 and lag['x_limit_error_W'] is None
assert 'k_v_rho_nu2_over_W2' not in lead
assert lag['x_settled'] is None and lag['x_limit_W'] is None
assert lag['k_v_rho_nu2_over_W2'] == 75000 and lag['volume_error_max'] == 0.002
assert lag['strain_energy_settled'] is False and lag['strain_energy_over_ks_a2'] == 0.0018
assert 'solver' not in lead
assert lag['solver'] == {'solves': 500, 'newton_iterations': 1200, 'krylov_iterations': 9000,
                         'newton_iterations_per_step': 3, 'krylov_iterations_per_step': 22.5,
                         'tangents': 700, 'step_cuts': 3}
seconds = s['profile']['seconds_by_rank']
assert s['profile']['steps'] == 400
assert list(seconds) == ['fluid', 'boxes', 'locating', 'interpolation', 'bodies', 'spreading',
                         'exchange', 'waiting', 'output']
assert seconds['fluid'] == [1, 0.1] and seconds['output'] == [9, 1e-9]
assert s['profile']['bytes_sent_a_step_by_rank'] == [1500, 0]
assert s['warnings'] == ['strain energy of lag has not settled']
assert (s['wall_time_s'], s['updates_per_second'], s['ranks']) == (61.5, 6.02e7, 2)
assert s['parameters'] == {'channel.nodes': 36, 'body.lag.x': -0.2, 'fluid.collision': 'trt'}
assert s['versions'] == {'ductile': '0.1.0', 'PETSc': '3.18.5'}
print('as written')
)"),
            "as written\n");
}

TEST_F(SummaryFile, OfASingleBodyHasNoVerdict) {
  Summary s;
  s.bodies = {BodySummary{"particle", {0, 0, 0}, {0, 0, 0}, {}, {}}};
  write_summary(directory_ / "summary.json", s);
  EXPECT_EQ(python(R"(
import json, sys
s = json.load(open(sys.argv[1] + '/summary.json', encoding='utf-8'))
print(s['status'], 'verdict' in s, 'dz_W' in s, 'blow_up' in s, 'profile' in s, s['warnings'],
      len(s['bodies']))
)"),
            "finished False False False False [] 1\n");
}

class ProgressLine : public Output {
 public:
  ~ProgressLine() override { std::fclose(out_); }

 protected:
  ProgressLine() : out_(std::fopen((directory_ / "progress").c_str(), "wb")) {}

  /// 200 steps a second of 1000 nodes each, 0.005 units of time a second, for `seconds`.
  std::string run(bool terminal, int seconds) {
    double clock = 50;
    Progress progress(10, 1000, out_, terminal, [&] { return clock; });
    progress.note("dz 1.23");
    for (int step = 0; step <= 200 * seconds; ++step) {
      clock = 50 + step / 200.0;
      progress.update(step * 25e-6, step);
    }
    progress.finish();
    return read(directory_ / "progress");
  }

  std::FILE* out_;
};

TEST_F(ProgressLine, IsPlainLinesAtGrowingIntervalsOffATerminal) {
  const auto lines = split(run(false, 400), '\n');
  // After 10, 10 + 20, + 40, + 80, + 160 seconds, and at the end.
  ASSERT_EQ(lines.size(), 6U);
  EXPECT_EQ(lines[0], "t = 0.05 of 10    0%  0.2 MLUPS  33 min 10 s left  dz 1.23");
  EXPECT_EQ(lines[4], "t = 1.55 of 10   15%  0.2 MLUPS  28 min 10 s left  dz 1.23");
  EXPECT_EQ(lines[5], "t = 2.00 of 10   20%  0.2 MLUPS  26 min 40 s left  dz 1.23");
}

TEST_F(ProgressLine, IsRewrittenInPlaceOnATerminal) {
  const std::string text = run(true, 4);
  EXPECT_EQ(std::ranges::count(text, '\n'), 1);
  EXPECT_EQ(text.back(), '\n');
  EXPECT_EQ(std::ranges::count(text, '\r'), 16);  // four a second
}

TEST(Duration, IsReadInEveryForm) {
  const std::vector<std::pair<const char*, double>> known = {
      {"90s", 90},    {"1.5m", 90},  {"30m", 1800},       {"11.5h", 41400},
      {"2d", 172800}, {"01:30", 90}, {"11:30:00", 41400}, {"1-00:00:30", 86430}};
  for (const auto& [text, seconds] : known) EXPECT_EQ(parsed_duration(text), seconds) << text;
  for (const char* text : {"", "90", "s", "-1s", "1 h", "1:60", "1:2:3:4", "1-2", "1-2:3", "1h30m",
                           "nan", "inf", "infs", "infh", "inf:30", "1e3s", "1::2", "1:"})
    EXPECT_FALSE(parsed_duration(text)) << text;
}

TEST(Duration, ReadsWell) {
  EXPECT_EQ(duration_text(7.6), "8 s");
  EXPECT_EQ(duration_text(59.6), "1 min 00 s");
  EXPECT_EQ(duration_text(200), "3 min 20 s");
  EXPECT_EQ(duration_text(7500), "2 h 05 min");
  EXPECT_EQ(duration_text(270000), "3.1 days");
}

class Plot : public Output {
 protected:
  void write_trajectory(std::size_t bodies, bool capsules) const {
    std::vector<std::string> names;
    for (std::size_t b = 0; b < bodies; ++b) names.push_back("body" + std::to_string(b));
    Trajectory trajectory(directory_ / "trajectory.csv", names,
                          std::vector<bool>(bodies, capsules));
    for (int i = 0; i <= 20; ++i) {
      Sample sample{0.5 * i, std::vector<BodySample>(bodies)};
      for (std::size_t b = 0; b < bodies; ++b) {
        sample.bodies[b]["x"] = 0.1 * static_cast<double>(b) + 0.01 * i;
        sample.bodies[b]["z"] = 0.1 * i;
        sample.bodies[b].capsule = capsules;
      }
      if (bodies > 2) sample.ahead.assign(bodies, 1);
      trajectory.write(sample);
    }
  }
  [[nodiscard]] bool is_png() const {
    return read(directory_ / "trajectory.png").starts_with("\x89PNG\r\n");
  }
};

TEST_F(Plot, IsDrawnOfOneAndOfThreeBodies) {
  for (const std::size_t bodies : {1U, 3U}) {
    write_trajectory(bodies, bodies != 3);
    EXPECT_TRUE(plot_trajectory(directory_)) << bodies;
    EXPECT_TRUE(is_png());
    fs::remove(directory_ / "trajectory.png");
  }
}

TEST_F(Plot, IsDrawnOfAPairThatDied) {
  write_trajectory(2, true);
  std::ofstream(directory_ / "trajectory.csv", std::ios::app) << "10.5,0.2,nan,0.";
  write("summary.json", "{\"status\": \"blew");
  EXPECT_TRUE(plot_trajectory(directory_));
  EXPECT_TRUE(is_png());
}

TEST_F(Plot, ComesInEveryFormat) {
  write_trajectory(2, true);
  for (const auto& [format, begin] :
       {std::pair("png", "\x89PNG\r\n"), std::pair("pdf", "%PDF"), std::pair("svg", "<?xml")}) {
    EXPECT_TRUE(plot_trajectory(directory_, format));
    EXPECT_TRUE(read(directory_ / fmt::format("trajectory.{}", format)).starts_with(begin));
  }
}

TEST_F(Plot, ThatWasAskedForGivesACode) {
  write_trajectory(1, true);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(draw({{directory_}, "", directory_ / "own.svg"}), 0);
  EXPECT_EQ(draw({{directory_ / "none"}, "", {}}), 2);
  EXPECT_EQ(draw({{directory_}, "", directory_ / "none" / "own.svg"}), 1);
  const std::string printed = ::testing::internal::GetCapturedStderr();
  EXPECT_TRUE(read(directory_ / "own.svg").starts_with("<?xml"));
  EXPECT_EQ(std::ranges::count(printed, '\n'), 2) << printed;
  EXPECT_NE(printed.find("none: no such directory"), std::string::npos) << printed;
}

TEST_F(Plot, OfAComparisonWarnsInOneLineWhereItCannot) {
  ::testing::internal::CaptureStderr();
  EXPECT_FALSE(plot_comparison(directory_));
  const std::string printed = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::ranges::count(printed, '\n'), 1) << printed;
  EXPECT_TRUE(printed.starts_with("warning: no compare.png: ")) << printed;
  EXPECT_NE(printed.find("compare.json"), std::string::npos) << printed;
}

TEST_F(Plot, WarnsInOneLineWhereItCannot) {
  ::testing::internal::CaptureStderr();
  EXPECT_FALSE(plot_trajectory(directory_));
  const std::string printed = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::ranges::count(printed, '\n'), 1) << printed;
  EXPECT_TRUE(printed.starts_with("warning: no trajectory.png: ")) << printed;
  EXPECT_NE(printed.find("trajectory.csv"), std::string::npos) << printed;
}

}  // namespace
}  // namespace ductile::drivers
