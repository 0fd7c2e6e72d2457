// The loops of MarkerResponse over markers and the nodes that they reach, for each instruction set.
#pragma once

#include <cstddef>

#include "ductile/fluid/instruction_set.hpp"

namespace ductile::coupling {

/// How a marker meets a grid around all markers.
struct ResponseMarker {
  std::size_t corner;  ///< first node of its stencil
  double across[16];   ///< phi(x) phi(y)
  double along[4];     ///< phi(z)
};

/// The same bits with each instruction set.
struct ResponseKernel {
  /// As MarkerResponse::apply(); `grid` holds zeros.
  void (*respond)(const ResponseMarker* markers, std::size_t count, const std::size_t* size,
                  const double* force, double* grid, double* velocity);
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
const ResponseKernel& response_kernel(fluid::InstructionSet set);

}  // namespace ductile::coupling
