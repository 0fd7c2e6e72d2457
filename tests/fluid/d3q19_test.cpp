#include "ductile/fluid/d3q19.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace ductile::fluid::d3q19;

constexpr double eps = 1e-15;

double delta(int a, int b) {
  return a == b ? 1 : 0;
}

// sum_i w_i c_ia c_ib ... = 1, 0, c_s^2 d_ab, 0, c_s^4 (d_ab d_cd + d_ac d_bd + d_ad d_bc), 0
TEST(D3Q19, IsIsotropicToFifthOrder) {
  double sum = 0;
  for (int i = 0; i < Q; ++i) sum += w(i);
  EXPECT_NEAR(sum, 1, eps);
  for (unsigned a = 0; a < 3; ++a) {
    double first = 0;
    for (int i = 0; i < Q; ++i) first += w(i) * c(i)[a];
    EXPECT_EQ(first, 0);
    for (unsigned b = 0; b < 3; ++b) {
      double second = 0;
      for (int i = 0; i < Q; ++i) second += w(i) * c(i)[a] * c(i)[b];
      EXPECT_NEAR(second, c_s2 * delta(static_cast<int>(a), static_cast<int>(b)), eps);
      for (unsigned d = 0; d < 3; ++d) {
        double third = 0;
        for (int i = 0; i < Q; ++i) third += w(i) * c(i)[a] * c(i)[b] * c(i)[d];
        EXPECT_NEAR(third, 0, eps);
        for (unsigned e = 0; e < 3; ++e) {
          double fourth = 0;
          for (int i = 0; i < Q; ++i) fourth += w(i) * c(i)[a] * c(i)[b] * c(i)[d] * c(i)[e];
          const auto k = [](unsigned m, unsigned n) {
            return delta(static_cast<int>(m), static_cast<int>(n));
          };
          EXPECT_NEAR(fourth,
                      c_s2 * c_s2 * (k(a, b) * k(d, e) + k(a, d) * k(b, e) + k(a, e) * k(b, d)),
                      eps);
        }
      }
    }
  }
}

TEST(D3Q19, HoldsEachVelocityOnceWithItsOpposite) {
  for (int i = 0; i < Q; ++i) {
    const auto v = c(i);
    const auto o = c(opposite(i));
    for (unsigned axis = 0; axis < 3; ++axis) EXPECT_EQ(v[axis], -o[axis]);
    EXPECT_EQ(opposite(opposite(i)), i);
    EXPECT_LE(v[0] * v[0] + v[1] * v[1] + v[2] * v[2], 2);
    for (int j = 0; j < i; ++j) EXPECT_NE(c(j), v);
  }
}

}  // namespace
