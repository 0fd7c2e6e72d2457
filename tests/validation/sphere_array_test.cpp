#include "validation/sphere_array.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

namespace {

using namespace ductile;

struct Array {
  double radius;  // over L
  double K;
  int L;  // for a radius of ten lattice spacings or more
};
// Zick & Homsy 1982, table 2; volume fractions 0.027 to 0.216.
constexpr std::array<Array, 4> table = {
    {{0.186105, 2.008, 54}, {0.248140, 2.810, 42}, {0.310175, 4.292, 34}, {0.372210, 7.442, 32}}};

// A surface of the 4-point kernel is felt half a lattice spacing further out than its markers are:
// with them on the sphere, the drag is too high by an error of first order.
TEST(SphereArray, DragApproachesZickAndHomsyAtFirstOrder) {
  const auto& [ratio, K, L] = table[0];
  const double coarse = test::drag_coefficient(32, ratio * 32, K, 0) / K - 1;
  const double fine = test::drag_coefficient(L, ratio * L, K, 0) / K - 1;
  std::printf("radius %.2f: +%.2f%%, radius %.2f: +%.2f%%\n", ratio * 32, 100 * coarse, ratio * L,
              100 * fine);
  EXPECT_GT(fine, 0);
  EXPECT_GT(std::log(coarse / fine) / std::log(static_cast<double>(L) / 32), 0.9);
}

TEST(SphereArray, DragIsThatOfZickAndHomsyForTheHydrodynamicRadius) {
  for (const auto& [ratio, K, L] : table) {
    const double drag = test::drag_coefficient(L, ratio * L, K, test::retraction);
    std::printf("R/L = %.6f, L = %d: K = %.3f, %+.2f%%\n", ratio, L, drag, 100 * (drag / K - 1));
    EXPECT_NEAR(drag, K, 0.05 * K);
  }
}

}  // namespace
