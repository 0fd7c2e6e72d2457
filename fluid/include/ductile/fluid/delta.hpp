// Peskin's 4-point regularised delta function, eq. (17).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace ductile::fluid {

/// phi(r), eq. (17).
inline double phi(double r) {
  r = std::abs(r);
  if (r >= 2) return 0;
  if (r <= 1) return 0.125 * (3 - 2 * r + std::sqrt(std::max(0.0, 1 + 4 * r - 4 * r * r)));
  return 0.125 * (5 - 2 * r - std::sqrt(std::max(0.0, -7 + 12 * r - 4 * r * r)));
}

/// The largest integer that does not exceed x; |x| < 2^31. No call, on any instruction set.
inline int floor_of(double x) {
  const int n = static_cast<int>(x);
  return x < n ? n - 1 : n;
}

/// A coordinate reaches the four nodes from this one on.
inline int first_node(double x) {
  return floor_of(x) - 1;
}

/// The four nodes `base` .. `base` + 3 that a coordinate reaches, and phi at each.
struct Weights {
  int base;
  std::array<double, 4> phi;
};

/// All four values of phi share one square root: with r the distance to the node below,
/// s = sqrt(1 + 4 r - 4 r^2) serves eq. (17) at 1 + r, r, 1 - r and 2 - r.
inline Weights weights(double x) {
  const int node = floor_of(x);
  const double r = x - node;
  const double s = std::sqrt(std::max(0.0, 1 + 4 * r - 4 * r * r));
  return {node - 1,
          {0.125 * (3 - 2 * r - s), 0.125 * (3 - 2 * r + s), 0.125 * (1 + 2 * r + s),
           0.125 * (1 + 2 * r - s)}};
}

}  // namespace ductile::fluid
