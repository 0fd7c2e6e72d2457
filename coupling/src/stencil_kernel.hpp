// The loops over markers and the nodes that they reach, for each instruction set.
#pragma once

#include <cstddef>

#include "ductile/coupling/marker.hpp"
#include "ductile/fluid/instruction_set.hpp"

namespace ductile::coupling {

/// A vector on the nodes of a fluid::Patch, as the loops see it.
template <class Number>
struct PatchField {
  int begin[3];
  int size[3];
  std::ptrdiff_t pitch;
  int pad;
  Number* component[3];
};

/// The same bits with each instruction set.
struct StencilKernel {
  /// Adds `force` of the markers to the field, as Stencils::spread().
  void (*spread)(const StencilMarker* markers, std::size_t count, const double* force,
                 const PatchField<double>& field, int period);
  /// As Stencils::interpolate().
  void (*interpolate)(const StencilMarker* markers, std::size_t count,
                      const PatchField<const double>& field, int period, double* partial);
  /// As MarkerResponse::apply(); `grid` holds zeros.
  void (*respond)(const ResponseMarker* markers, std::size_t count, const std::size_t* size,
                  const double* force, double* grid, double* velocity);
};

/// stencil_kernel.cpp, compiled once for each of them.
namespace baseline {
const StencilKernel& stencil_kernel();
}
namespace avx2 {
const StencilKernel& stencil_kernel();
}
namespace avx512 {
const StencilKernel& stencil_kernel();
}

/// `set` must be available.
const StencilKernel& stencil_kernel(fluid::InstructionSet set);

}  // namespace ductile::coupling
