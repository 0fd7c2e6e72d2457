// Four numbers side by side, for sources that are compiled once for each instruction set. What is
// below is in an unnamed namespace and always inlined, so that nothing compiled for one set is
// linked into code for another.
#pragma once

#include <cstddef>

#ifdef __AVX__
#include <immintrin.h>
#endif

namespace ductile {
namespace {

template <class Number>
struct FourOf {
  using type [[gnu::vector_size(4 * sizeof(Number))]] = Number;
};
template <class Number>
using LanesOf = typename FourOf<Number>::type;
using Lanes = LanesOf<double>;

template <class Number>
[[gnu::always_inline]] inline LanesOf<Number> load(const Number* from) {
  LanesOf<Number> values;
  __builtin_memcpy(&values, from, sizeof values);
  return values;
}
template <class T, class V>
[[gnu::always_inline]] inline void store(T* to, V values) {
  __builtin_memcpy(to, &values, sizeof values);
}

[[gnu::always_inline]] inline Lanes root(Lanes values) {
#ifdef __AVX__
  return _mm256_sqrt_pd(values);
#else
  return Lanes{__builtin_sqrt(values[0]), __builtin_sqrt(values[1]), __builtin_sqrt(values[2]),
               __builtin_sqrt(values[3])};
#endif
}

// Rows become columns.
[[gnu::always_inline]] inline void transpose(Lanes (&rows)[4]) {
  const Lanes even01 = __builtin_shufflevector(rows[0], rows[1], 0, 4, 2, 6);
  const Lanes odd01 = __builtin_shufflevector(rows[0], rows[1], 1, 5, 3, 7);
  const Lanes even23 = __builtin_shufflevector(rows[2], rows[3], 0, 4, 2, 6);
  const Lanes odd23 = __builtin_shufflevector(rows[2], rows[3], 1, 5, 3, 7);
  rows[0] = __builtin_shufflevector(even01, even23, 0, 1, 4, 5);
  rows[1] = __builtin_shufflevector(odd01, odd23, 0, 1, 4, 5);
  rows[2] = __builtin_shufflevector(even01, even23, 2, 3, 6, 7);
  rows[3] = __builtin_shufflevector(odd01, odd23, 2, 3, 6, 7);
}

}  // namespace
}  // namespace ductile
