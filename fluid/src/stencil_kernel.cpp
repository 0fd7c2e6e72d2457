// Compiled once for each instruction set, under the namespace DUCTILE_INSTRUCTION_SET. What is
// below is in an unnamed namespace, and nothing of the standard library is called: an inline
// function with external linkage might be linked from here into code for a lesser machine.
#include "stencil_kernel.hpp"

#include "lanes.hpp"

namespace ductile::fluid {
namespace {

using IntLanes [[gnu::vector_size(4 * sizeof(int))]] = int;

// How some points meet the lattice: point m the nodes from base[3 m + axis] to 3 beyond, with phi,
// eq. (17), at each of them from phi[12 m + 4 axis] on. It is cheaper to compute for a few points
// at a time than to keep and to fetch.
template <class Number>
struct Stencils {
  static constexpr std::size_t most = 32;  // points, a multiple of 4
  alignas(64) int base[3 * most];
  alignas(64) Number phi[12 * most];

  // As weights() of delta.hpp, of four coordinates.
  [[gnu::always_inline]] void locate_four(std::size_t n, Lanes x) {
    Lanes node = __builtin_convertvector(__builtin_convertvector(x, IntLanes), Lanes);
    node = x < node ? node - 1 : node;
    const Lanes r = x - node;
    const Lanes square = 1 + 4 * r - 4 * r * r;
    const Lanes s = root(square > 0 ? square : Lanes{});
    store(base + n, __builtin_convertvector(node - 1, IntLanes));
    Lanes p[4] = {0.125 * (3 - 2 * r - s), 0.125 * (3 - 2 * r + s), 0.125 * (1 + 2 * r + s),
                  0.125 * (1 + 2 * r - s)};
    transpose(p);
    for (std::size_t k = 0; k < 4; ++k)
      store(phi + 4 * (n + k), __builtin_convertvector(p[k], LanesOf<Number>));
  }

  [[gnu::always_inline]] void locate(const double* x, std::size_t count) {
    const std::size_t coordinates = 3 * count;
    std::size_t n = 0;
    for (; n + 4 <= coordinates; n += 4) locate_four(n, load(x + n));
    if (n == coordinates) return;
    double rest[4] = {};
    __builtin_memcpy(rest, x + n, (coordinates - n) * sizeof(double));
    locate_four(n, load(rest));
  }
};

// Calls f(m, base, phi) for all points.
template <class Number, class F>
[[gnu::always_inline]] inline void for_stencils(const double* x, std::size_t count, F&& f) {
  Stencils<Number> stencils{};
  constexpr std::size_t most = Stencils<Number>::most;
  for (std::size_t first = 0; first < count; first += most) {
    const std::size_t some = count - first < most ? count - first : most;
    stencils.locate(x + 3 * first, some);
    for (std::size_t m = 0; m < some; ++m)
      f(first + m, stencils.base + 3 * m, stencils.phi + 12 * m);
  }
}

// A stencil's first plane in [0, period), where z is periodic, counted from the patch's.
[[gnu::always_inline]] inline int folded(int k, int period) {
  if (period > 0 && (k < 0 || k >= period)) {
    k %= period;
    if (k < 0) k += period;
  }
  return k;
}

// Calls f(k) for each offset k of a stencil's first plane in the patch, -3 <= k < size. Where z is
// periodic the patch may meet the stencil at both of its ends.
template <class Number, class F>
[[gnu::always_inline]] inline void for_images(int base, const PatchField<Number>& field, int period,
                                              F&& f) {
  int k = base - field.begin[2];
  if (period > 0) {
    k = folded(k + 3, period) - 3;
    if (k < 0 && k + period < field.size[2]) f(k + period);
  }
  if (k >= -3 && k < field.size[2]) f(k);
}

// Index of the stencil's first node; its rows in x and in y are `size[1]` pitches and one apart.
template <class Number>
[[gnu::always_inline]] inline std::ptrdiff_t corner(const int* base,
                                                    const PatchField<Number>& field, int k) {
  const std::ptrdiff_t i = base[0] - field.begin[0];
  const std::ptrdiff_t j = base[1] - field.begin[1];
  return (i * field.size[1] + j) * field.pitch + field.pad + k;
}

template <class Number>
void spread(const double* x, std::size_t count, const double* force,
            const PatchField<Number>& field, int period) {
  const std::ptrdiff_t across = field.size[1] * field.pitch;
  for_stencils<Number>(
      x,
      count, [&](std::size_t m, const int* base, const Number* phi) __attribute__((always_inline)) {
        for_images(
            base[2], field, period, [&](int k) __attribute__((always_inline)) {
              const LanesOf<Number> z = load(phi + 8);
              LanesOf<Number> f[3];
              for (std::size_t axis = 0; axis < 3; ++axis)
                f[axis] = z * static_cast<Number>(force[3 * m + axis]);
              const std::ptrdiff_t first = corner(base, field, k);
              for (int i = 0; i < 4; ++i) {
                for (int j = 0; j < 4; ++j) {
                  const Number w = phi[i] * phi[4 + j];
                  const std::ptrdiff_t n = first + i * across + j * field.pitch;
                  for (int axis = 0; axis < 3; ++axis) {
                    Number* to = field.component[axis] + n;
                    store(to, load(to) + w * f[axis]);
                  }
                }
              }
            });
      });
}

// Calls f(axis, terms) with the four planes' terms of each component.
template <class Number, class F>
[[gnu::always_inline]] inline void for_terms(const int* base, const Number* phi,
                                             const PatchField<const Number>& field, int k, F&& f) {
  const std::ptrdiff_t across = field.size[1] * field.pitch;
  const std::ptrdiff_t first = corner(base, field, k);
  LanesOf<Number> u[3] = {};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      const Number w = phi[i] * phi[4 + j];
      const std::ptrdiff_t n = first + i * across + j * field.pitch;
      for (int axis = 0; axis < 3; ++axis) u[axis] += w * load(field.component[axis] + n);
    }
  }
  const LanesOf<Number> z = load(phi + 8);
  for (int axis = 0; axis < 3; ++axis) f(axis, __builtin_convertvector(z * u[axis], Lanes));
}

// Sums as sum_of_planes() does, which other ranks use for what they have in parts.
template <class Number>
void interpolate(const double* x, std::size_t count, const PatchField<const Number>& field,
                 int period, double* velocity) {
  for_stencils<Number>(
      x,
      count, [&](std::size_t m, const int* base, const Number* phi) __attribute__((always_inline)) {
        const int k = folded(base[2] - field.begin[2], period);
        if (k < 0 || k + 4 > field.size[2]) return;
        double* u = velocity + 3 * m;
        for_terms(
            base, phi, field, k, [&](int axis, Lanes t) __attribute__((always_inline)) {
              u[axis] = ((t[0] + t[1]) + t[2]) + t[3];
            });
      });
}

template <class Number>
void interpolate_planes(const double* x, std::size_t count, const PatchField<const Number>& field,
                        int period, double* partial) {
  for_stencils<Number>(
      x,
      count, [&](std::size_t m, const int* base, const Number* phi) __attribute__((always_inline)) {
        for_images(
            base[2], field, period, [&](int k) __attribute__((always_inline)) {
              for_terms(
                  base, phi, field, k, [&](int axis, Lanes t) __attribute__((always_inline)) {
                    double* sum = partial + 12 * m + 4 * static_cast<std::size_t>(axis);
                    store(sum, load(sum) + t);
                  });
            });
      });
}

}  // namespace

namespace DUCTILE_INSTRUCTION_SET {

template <class Number>
const StencilKernel<Number>& stencil_kernel() {
  static constexpr StencilKernel<Number> functions = {spread<Number>, interpolate<Number>,
                                                      interpolate_planes<Number>};
  return functions;
}
template const StencilKernel<double>& stencil_kernel<double>();
template const StencilKernel<float>& stencil_kernel<float>();

}  // namespace DUCTILE_INSTRUCTION_SET

}  // namespace ductile::fluid
