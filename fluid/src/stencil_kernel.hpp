// The loops over points and the nodes that they reach, for each instruction set.
#pragma once

#include <cstddef>

#include "ductile/instruction_set.hpp"

namespace ductile::fluid {

/// A vector on the nodes of a Patch, as the loops see it.
template <class Number>
struct PatchField {
  int begin[3];
  int size[3];
  std::ptrdiff_t pitch;
  int pad;
  Number* component[3];
};

/// `x` holds 3 `count` numbers, x y z of each point in turn. The same bits with each instruction
/// set. `period` is the number of planes after which z repeats, 0 if it does not. Where points are
/// is computed in double, all else in Number.
template <class Number>
struct StencilKernel {
  /// Adds F_m phi phi phi to the field, point by point, eq. (16).
  void (*spread)(const double* x, std::size_t count, const double* force,
                 const PatchField<Number>& field, int period);
  /// velocity[3 m ..] <- eq. (15) for each point of which the field has all four planes, its terms
  /// added plane by plane, in double.
  void (*interpolate)(const double* x, std::size_t count, const PatchField<const Number>& field,
                      int period, double* velocity);
  /// Adds, for each point, the field's contribution to eq. (15) from each of its four planes:
  /// partial[12 m + 4 component + plane].
  void (*interpolate_planes)(const double* x, std::size_t count,
                             const PatchField<const Number>& field, int period, double* partial);
};

/// stencil_kernel.cpp, compiled once for each of them.
namespace baseline {
template <class Number>
const StencilKernel<Number>& stencil_kernel();
}
namespace avx2 {
template <class Number>
const StencilKernel<Number>& stencil_kernel();
}
namespace avx512 {
template <class Number>
const StencilKernel<Number>& stencil_kernel();
}

}  // namespace ductile::fluid
