// Interpolation and spreading between markers and the nodes of a patch.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "ductile/coupling/body.hpp"
#include "ductile/coupling/marker.hpp"
#include "ductile/fluid/fluid.hpp"
#include "ductile/fluid/instruction_set.hpp"

namespace ductile::coupling {

struct StencilKernel;

/// Where the markers of a body meet the lattice: the stencil of each, kept for a time step.
class Stencils {
 public:
  /// `set` must be available; results do not depend on it.
  explicit Stencils(fluid::InstructionSet set = fluid::best_instruction_set());
  /// Positions: 3n numbers.
  void locate(std::span<const double> positions);
  [[nodiscard]] std::size_t size() const { return markers_.size(); }

  /// Adds F_m phi phi phi to the patch's force, marker by marker, eq. (16) (the minus sign is in
  /// F). `period` is the number of planes after which z repeats, 0 if it does not.
  void spread(std::span<const double> force, fluid::Patch& patch, int period) const;
  /// Adds, for each marker, the patch's contribution to the velocity of eq. (15) from each of its
  /// four planes: partial[12 m + 4 component + plane].
  void interpolate(const fluid::Patch& patch, int period, std::span<double> partial) const;

  [[nodiscard]] const StencilMarker& operator[](std::size_t m) const { return markers_[m]; }

 private:
  const StencilKernel* kernel_;
  std::vector<StencilMarker> markers_;
};

/// Response from markers alone: S S^T is the same wherever the lattice's nodes are, so the owner of
/// a body needs neither the fluid nor other ranks. It takes rho = 1, of which the fluid's density
/// differs by the square of the Mach number; the velocity that a body advances with has the true
/// one.
class MarkerResponse final : public Response {
 public:
  explicit MarkerResponse(fluid::InstructionSet set = fluid::best_instruction_set());
  /// Where the markers are until the next call; 3n numbers, not kept.
  void locate(std::span<const double> positions);
  void apply(std::span<const double> force, std::span<double> velocity) const override;

 private:
  const StencilKernel* kernel_;
  std::vector<ResponseMarker> markers_;
  std::array<std::size_t, 3> size_{};
  mutable std::vector<double> grid_;  // scratch around the markers, x y z and a gap at each node
};

}  // namespace ductile::coupling
