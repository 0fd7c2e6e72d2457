// run.h5 and run.xdmf: the bodies' surfaces, and on request the fluid, over time.
#pragma once

#include <hdf5.h>

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ductile/fluid/fluid.hpp"
#include "ductile/suspension/suspension.hpp"

namespace ductile::drivers {

/// A body's surface, as far as it stays the same.
struct SurfaceMesh {
  std::string name;
  std::size_t vertices = 0;
  std::vector<std::array<int, 3>> triangles;
};

/// The channel, centred on the origin: |x| <= 1, |y| <= half_width_y, and along z one period of
/// `length`; all in W.
struct Channel {
  double half_width_y = 1;
  double length = 0;
};

/// The regular lattice that fluid fields come on.
struct FluidLattice {
  std::array<std::size_t, 3> nodes = {0, 0, 0};      ///< along x, y, z
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of node (0, 0, 0) at t = 0 [W]
  double spacing = 1;                                ///< [W]
  fluid::Mirror mirror = fluid::Mirror::none;        ///< fields come for the upper half alone
};

/// A frame that has been written: what there is in it.
struct Frame {
  struct Given {
    bool velocity = false;
    bool force = false;
  };
  double time = 0;              ///< [W^2/nu]
  std::optional<double> fluid;  ///< how far its lattice has moved along z [W]
  std::vector<Given> bodies;    ///< besides the positions
  std::uint64_t checksum = 0;   ///< of its file
};

/// Writes frames, one file each, run.h5 that shows them all, and run.xdmf that lets ParaView read
/// them (XDMF 2, by any of its readers; paths are relative, so the directory may be moved). In
/// run.h5, whose frames are links to frames/000000.h5 and so on:
///     /channel/corners                     double [8, 3], edges int32 [12, 2]: its outline
///     /bodies/NAME/triangles               int32 [triangles, 3]
///     /frames/000000/                      attribute time [W^2/nu]
///     /frames/000000/NAME/                 attribute z_offset [W]
///     /frames/000000/NAME/position         double [n, 3], and velocity, force where given
///     /frames/000000/fluid/density         float [nz, ny, nx], velocity [nz, ny, nx, 3]
/// with the unit of each as its attribute `units`, and in run.xdmf in its name. Attributes of the
/// root: `scenario`, the TOML that was run, but for [run]; `version` of ductile; `spacing` of the
/// lattice [W].
///
/// All lie in the channel's frame, z in [-L/2, L/2), L its length. A body travels far down the
/// periodic channel: each is shown whole, moved back by its own z_offset, the multiple of L that
/// brings its centre, the mean of its vertices, into the channel; position + z_offset is unwrapped.
/// The fluid is shown whole too: below a mirror plane as the image of what is above it, and with
/// the plane z = L/2, which repeats z = -L/2. Where the lattice moves, the fluid's nodes lie
/// further along z by its attribute z_offset, less than a spacing [W]. Fields are stored in single
/// precision.
///
/// Every file is written beside and put into its place, a frame before what names it: all can be
/// read while the run goes on, and whatever it ends by, they hold all frames that were whole.
class Surfaces {
 public:
  /// Goes on after `frames`, which are there already, and removes later ones. Throws OutputError;
  /// std::invalid_argument for names that repeat or
  /// cannot stand in a path, a triangle that names no vertex, a channel of no size, or a lattice
  /// without nodes.
  Surfaces(std::filesystem::path directory, std::vector<SurfaceMesh> bodies, const Channel& channel,
           const std::optional<FluidLattice>& lattice = std::nullopt,
           std::vector<Frame> frames = {}, std::string scenario = "");

  /// Throws std::runtime_error unless all frames that a run is to go on after are there, as they
  /// were written. Reads them.
  static void require(const std::filesystem::path& directory, const std::vector<Frame>& frames);

  /// Removes all that this class writes. Throws OutputError.
  static void remove(const std::filesystem::path& directory);

  /// Appends a frame: every body in order and, if `fluid` is given, the fluid (which may come less
  /// often than the bodies). Throws OutputError, or std::invalid_argument if a size does not fit,
  /// time does not increase, or fluid comes without a lattice.
  void write(double time, std::span<const suspension::SurfaceState> bodies,
             const suspension::FluidState* fluid = nullptr);
  [[nodiscard]] const std::vector<Frame>& frames() const { return frames_; }
  /// Brings all frames onto the disk. Throws OutputError.
  void flush();

 private:
  void take_over(std::vector<Frame> frames);
  void add(Frame frame);
  void check(double time, std::span<const suspension::SurfaceState> bodies,
             const suspension::FluidState* fluid) const;
  void write_body(hid_t frame, std::size_t body, const suspension::SurfaceState& state) const;
  void write_fluid(hid_t frame, const suspension::FluidState& fluid) const;
  void write_overview() const;
  void write_xdmf() const;

  std::filesystem::path directory_;
  std::vector<SurfaceMesh> bodies_;
  Channel channel_;
  std::optional<FluidLattice> lattice_;
  std::string scenario_;
  std::vector<Frame> frames_;
  std::size_t flushed_ = 0;  // so many of them are on the disk
  // XDMF of all frames so far: of the channel, of each body, of the fluid.
  std::vector<std::string> grids_;
};

}  // namespace ductile::drivers
