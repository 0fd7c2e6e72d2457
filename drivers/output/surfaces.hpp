// run.h5 and run.xdmf: the bodies' surfaces, and on request the fluid, over time.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ductile/suspension/suspension.hpp"

namespace ductile::drivers {

/// A body's surface, as far as it stays the same.
struct SurfaceMesh {
  std::string name;
  std::size_t vertices = 0;
  std::vector<std::array<int, 3>> triangles;
};

/// The regular lattice that fluid fields live on; of a channel symmetric about y = 0 its upper
/// half.
struct FluidLattice {
  std::array<std::size_t, 3> nodes = {0, 0, 0};      ///< along x, y, z
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of node (0, 0, 0) [W]
  double spacing = 1;                                ///< [W]
};

/// Writes frames into run.h5, and run.xdmf that lets ParaView read them (XDMF 2, by its
/// "Xdmf Reader"; paths are relative, so the directory may be moved). In run.h5:
///     /bodies/NAME/triangles               int32 [triangles, 3]
///     /frames/000000/                      attribute time [W^2/nu], z_offset [W]
///     /frames/000000/NAME/position         double [n, 3], and velocity, force where given
///     /frames/000000/fluid/density         float [nz, ny, nx], velocity [nz, ny, nx, 3]
/// with the unit of each as its attribute `units`. Bodies travel far down a periodic channel: in
/// one of period L each frame shows all of them moved back by z_offset, the multiple of L that
/// brings the first body's centre into [0, L), where the fluid is; position + z_offset is
/// unwrapped. Fluid fields are stored in single precision.
///
/// Between frames run.h5 is closed, and run.xdmf is replaced only after it: both can be read while
/// the run goes on, and a run that dies leaves both readable up to its last whole frame.
class Surfaces {
 public:
  /// Creates or overwrites both files in `directory`. `period` [W] of the channel along z; 0: none.
  /// Throws OutputError; std::invalid_argument for names that repeat or cannot stand in a path, a
  /// triangle that names no vertex, or a lattice without nodes.
  Surfaces(const std::filesystem::path& directory, std::vector<SurfaceMesh> bodies, double period,
           const std::optional<FluidLattice>& lattice = std::nullopt);

  /// Appends a frame: every body in order and, if `fluid` is given, the fluid (which may come less
  /// often than the bodies). Throws OutputError, or std::invalid_argument if a size does not fit,
  /// time does not increase, or fluid comes without a lattice.
  void write(double time, std::span<const suspension::SurfaceState> bodies,
             const suspension::FluidState* fluid = nullptr);

 private:
  void check(double time, std::span<const suspension::SurfaceState> bodies,
             const suspension::FluidState* fluid) const;
  void write_xdmf() const;

  std::filesystem::path data_;
  std::filesystem::path description_;
  std::vector<SurfaceMesh> bodies_;
  double period_;
  std::optional<FluidLattice> lattice_;
  std::size_t frames_ = 0;
  double last_time_ = 0;
  std::vector<std::string> grids_;  // XDMF of all frames so far: of each body, then of the fluid
};

}  // namespace ductile::drivers
