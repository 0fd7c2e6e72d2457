// The response of a body's own markers.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "ductile/coupling/body.hpp"
#include "ductile/fluid/instruction_set.hpp"
#include "response_kernel.hpp"

namespace ductile::coupling {

/// Response from markers alone: S S^T is the same wherever the lattice's nodes are, so the owner of
/// a body needs neither the fluid nor other ranks. It takes rho = 1, of which the fluid's density
/// differs by the square of the Mach number; the velocity that a body advances with has the true
/// one.
class MarkerResponse final : public Response {
 public:
  /// `set` must be available; results do not depend on it.
  explicit MarkerResponse(fluid::InstructionSet set = fluid::best_instruction_set());
  /// Where the markers are until the next call; 3n numbers, not kept.
  void locate(std::span<const double> positions);
  void apply(std::span<const double> force, std::span<double> velocity) const override;

 private:
  const ResponseKernel* kernel_;
  std::vector<ResponseMarker> markers_;
  std::array<std::size_t, 3> size_{};
  mutable std::vector<double> grid_;  // scratch around the markers, x y z and a gap at each node
};

}  // namespace ductile::coupling
