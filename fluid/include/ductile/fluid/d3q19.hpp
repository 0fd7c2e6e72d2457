// The D3Q19 velocity set, ordered in opposite pairs.
#pragma once

#include <array>
#include <cstddef>

namespace ductile::fluid::d3q19 {

constexpr int Q = 19;
constexpr int pairs = 9;
constexpr double c_s2 = 1.0 / 3.0;

/// e[p] of the nine pairs of opposite velocities +e[p], -e[p].
constexpr std::array<std::array<int, 3>, pairs> e = {{{1, 0, 0},
                                                      {0, 1, 0},
                                                      {0, 0, 1},
                                                      {1, 1, 0},
                                                      {1, -1, 0},
                                                      {1, 0, 1},
                                                      {1, 0, -1},
                                                      {0, 1, 1},
                                                      {0, 1, -1}}};

/// Index of +e[p] and of -e[p]; 0 is the rest population.
constexpr int plus(int p) {
  return 2 * p + 1;
}
constexpr int minus(int p) {
  return 2 * p + 2;
}
constexpr int opposite(int i) {
  return i == 0 ? 0 : (i % 2 == 1 ? i + 1 : i - 1);
}

/// Velocity c_i.
constexpr std::array<int, 3> c(int i) {
  if (i == 0) return {0, 0, 0};
  const auto& v = e[static_cast<std::size_t>((i - 1) / 2)];
  return i % 2 == 1 ? v : std::array<int, 3>{-v[0], -v[1], -v[2]};
}

/// Weight w_i: 1/3, 1/18 and 1/36.
constexpr double w(int i) {
  return i == 0 ? 1.0 / 3.0 : (i <= 6 ? 1.0 / 18.0 : 1.0 / 36.0);
}

}  // namespace ductile::fluid::d3q19
