// Compiled once for each instruction set, under the namespace DUCTILE_INSTRUCTION_SET. What is
// below is in an unnamed namespace, and nothing of the standard library is called: an inline
// function with external linkage might be linked from here into code for a lesser machine.
#include "stencil_kernel.hpp"

namespace ductile::fluid {
namespace {

// N numbers side by side.
template <int N>
struct LanesOf {
  using type [[gnu::vector_size(N * sizeof(double))]] = double;
};
template <int N>
using Lanes = typename LanesOf<N>::type;

template <int N>
[[gnu::always_inline]] inline Lanes<N> load(const double* from) {
  Lanes<N> values;
  __builtin_memcpy(&values, from, sizeof values);
  return values;
}
template <int N>
[[gnu::always_inline]] inline void store(double* to, Lanes<N> values) {
  __builtin_memcpy(to, &values, sizeof values);
}

// Calls f(k) for each offset k of a stencil's first plane in the patch, -3 <= k < size. Where z is
// periodic the patch may meet the stencil at both of its ends.
template <class Number, class F>
[[gnu::always_inline]] inline void for_images(int base, const PatchField<Number>& field, int period,
                                              F&& f) {
  int k = base - field.begin[2];
  if (period > 0) {
    k = (k + 3) % period;
    if (k < 0) k += period;
    k -= 3;
    if (k < 0 && k + period < field.size[2]) f(k + period);
  }
  if (k >= -3 && k < field.size[2]) f(k);
}

// Index of the stencil's first node; its rows in x and in y are `size[1]` pitches and one apart.
template <class Number>
[[gnu::always_inline]] inline std::ptrdiff_t corner(const Stencil& point,
                                                    const PatchField<Number>& field, int k) {
  const std::ptrdiff_t i = point.base[0] - field.begin[0];
  const std::ptrdiff_t j = point.base[1] - field.begin[1];
  return (i * field.size[1] + j) * field.pitch + field.pad + k;
}

void spread(const Stencil* points, std::size_t count, const double* force,
            const PatchField<double>& field, int period) {
  const std::ptrdiff_t across = field.size[1] * field.pitch;
  for (std::size_t m = 0; m < count; ++m) {
    const Stencil& point = points[m];
    for_images(
        point.base[2], field, period, [&](int k) __attribute__((always_inline)) {
          const Lanes<4> z = load<4>(point.phi[2]);
          const Lanes<4> f[3] = {z * force[3 * m], z * force[3 * m + 1], z * force[3 * m + 2]};
          const std::ptrdiff_t first = corner(point, field, k);
          for (int i = 0; i < 4; ++i) {
            for (int j = 0; j < 4; ++j) {
              const double w = point.phi[0][i] * point.phi[1][j];
              const std::ptrdiff_t n = first + i * across + j * field.pitch;
              for (int axis = 0; axis < 3; ++axis) {
                double* to = field.component[axis] + n;
                store<4>(to, load<4>(to) + w * f[axis]);
              }
            }
          }
        });
  }
}

void interpolate(const Stencil* points, std::size_t count, const PatchField<const double>& field,
                 int period, double* partial) {
  const std::ptrdiff_t across = field.size[1] * field.pitch;
  for (std::size_t m = 0; m < count; ++m) {
    const Stencil& point = points[m];
    for_images(
        point.base[2], field, period, [&](int k) __attribute__((always_inline)) {
          Lanes<4> u[3] = {};
          const std::ptrdiff_t first = corner(point, field, k);
          for (int i = 0; i < 4; ++i) {
            for (int j = 0; j < 4; ++j) {
              const double w = point.phi[0][i] * point.phi[1][j];
              const std::ptrdiff_t n = first + i * across + j * field.pitch;
              for (int axis = 0; axis < 3; ++axis)
                u[axis] += w * load<4>(field.component[axis] + n);
            }
          }
          const Lanes<4> z = load<4>(point.phi[2]);
          for (int axis = 0; axis < 3; ++axis) {
            double* sum = partial + 12 * m + 4 * axis;
            store<4>(sum, load<4>(sum) + z * u[axis]);
          }
        });
  }
}

}  // namespace

namespace DUCTILE_INSTRUCTION_SET {

const StencilKernel& stencil_kernel() {
  static constexpr StencilKernel functions = {spread, interpolate};
  return functions;
}

}  // namespace DUCTILE_INSTRUCTION_SET

}  // namespace ductile::fluid
