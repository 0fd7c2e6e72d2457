// How a marker meets the lattice.
#pragma once

#include <cstddef>

namespace ductile::coupling {

/// The nodes from `base` to `base` + 3 along each axis, and phi at each.
struct StencilMarker {
  int base[3];
  double phi[3][4];
};

/// A marker of MarkerResponse.
struct ResponseMarker {
  std::size_t corner;  ///< of its stencil, in nodes of a grid around all markers
  double across[16];   ///< phi(x) phi(y)
  double along[4];     ///< phi(z)
};

}  // namespace ductile::coupling
