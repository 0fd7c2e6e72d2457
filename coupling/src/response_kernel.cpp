// Compiled once for each instruction set, under the namespace DUCTILE_INSTRUCTION_SET. What is
// below is in an unnamed namespace, and nothing of the standard library is called: an inline
// function with external linkage might be linked from here into code for a lesser machine.
#include "response_kernel.hpp"

namespace ductile::coupling {
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

// Where four nodes begin, of row (i, j) of the 4 x 4 that a marker meets.
[[gnu::always_inline]] inline std::size_t row(const ResponseMarker& marker, const std::size_t* size,
                                              std::size_t i, std::size_t j) {
  return 4 * (marker.corner + (i * size[1] + j) * size[2]);
}

void spread(const ResponseMarker* markers, std::size_t count, const std::size_t* size,
            const double* force, double* grid) {
  for (std::size_t m = 0; m < count; ++m) {
    const ResponseMarker& marker = markers[m];
    const Lanes<4> f = {force[3 * m], force[3 * m + 1], force[3 * m + 2], 0};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        double* node = grid + row(marker, size, i, j);
        const Lanes<4> g = marker.across[4 * i + j] * f;
        // A node at a time: what the marker before has just stored is then loaded as it was stored.
        for (std::size_t k = 0; k < 4; ++k) {
          store<4>(node + 4 * k, load<4>(node + 4 * k) + marker.along[k] * g);
        }
      }
    }
  }
}

void gather(const ResponseMarker* markers, std::size_t count, const std::size_t* size,
            const double* grid, double* velocity) {
  for (std::size_t m = 0; m < count; ++m) {
    const ResponseMarker& marker = markers[m];
    Lanes<8> first{};  // two nodes at a time
    Lanes<8> second{};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        const double* node = grid + row(marker, size, i, j);
        const double w = marker.across[4 * i + j];
        first += w * load<8>(node);
        second += w * load<8>(node + 8);
      }
    }
    const double* p = marker.along;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      velocity[3 * m + axis] =
          0.5 * (((p[0] * first[axis] + p[1] * first[4 + axis]) + p[2] * second[axis]) +
                 p[3] * second[4 + axis]);
    }
  }
}

}  // namespace

namespace DUCTILE_INSTRUCTION_SET {

const ResponseKernel& response_kernel() {
  static constexpr ResponseKernel functions = {spread, gather};
  return functions;
}

}  // namespace DUCTILE_INSTRUCTION_SET

}  // namespace ductile::coupling
