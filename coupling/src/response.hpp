// The response of a body's own markers.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "ductile/coupling/body.hpp"
#include "ductile/fluid/fluid.hpp"
#include "ductile/instruction_set.hpp"
#include "response_kernel.hpp"

namespace ductile::coupling {

/// Response from markers alone: S S^T is the same wherever the lattice's nodes are, so the owner of
/// a body needs neither the fluid nor other ranks. It takes rho = 1, of which the fluid's density
/// differs by the square of the Mach number; the velocity that a body advances with has the true
/// one. Across a mirror plane the force has its image, as in the fluid.
class MarkerResponse final : public Response {
 public:
  /// `set` must be available; results do not depend on it.
  explicit MarkerResponse(fluid::Mirror mirror = fluid::Mirror::none,
                          InstructionSet set = best_instruction_set());
  /// Where the markers are until the next call; 3n numbers, not kept. The fluid receives `share` of
  /// their force, Host::share.
  void locate(std::span<const double> positions, double share = 1);
  void apply(std::span<const double> force, std::span<double> velocity) const override;

 private:
  void fold() const;

  fluid::Mirror mirror_;
  const ResponseKernel* kernel_;
  std::vector<ResponseMarker> markers_;
  double share_ = 1;
  int low_y_ = 0;  // the first row of nodes
  std::array<std::size_t, 3> size_{};
  mutable std::vector<double> grid_;  // scratch around the markers, x y z and a gap at each node
};

}  // namespace ductile::coupling
