// The loops of MarkerResponse over markers and the nodes that they reach, for each instruction set.
#pragma once

#include <cstddef>

#include "ductile/instruction_set.hpp"

namespace ductile::coupling {

/// How a marker meets a grid around all markers.
struct ResponseMarker {
  std::size_t corner;  ///< first node of its stencil
  double across[16];   ///< phi(x) phi(y)
  double along[4];     ///< phi(z)
};

/// The same bits with each instruction set.
struct ResponseKernel {
  /// The markers' force is added to the grid: x y z and a gap at each node, z fastest.
  void (*spread)(const ResponseMarker* markers, std::size_t count, const std::size_t* size,
                 const double* force, double* grid);
  /// Half of what the grid holds is told to the markers: the velocity.
  void (*gather)(const ResponseMarker* markers, std::size_t count, const std::size_t* size,
                 const double* grid, double* velocity);
};

/// response_kernel.cpp, compiled once for each of them.
namespace baseline {
const ResponseKernel& response_kernel();
}
namespace avx2 {
const ResponseKernel& response_kernel();
}
namespace avx512 {
const ResponseKernel& response_kernel();
}

/// `set` must be available.
const ResponseKernel& response_kernel(InstructionSet set);

}  // namespace ductile::coupling
