#include "ductile/fluid/delta.hpp"

#include <gtest/gtest.h>

#include <random>

namespace {

using namespace ductile::fluid;

constexpr double tolerance = 1e-12;

TEST(Delta, KeepsPeskinsConditionsAtAnyOffset) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> offset(-3, 3);
  for (int n = 0; n < 10000; ++n) {
    const double x = offset(random);
    const Weights w = weights(x);
    double sum = 0;
    double moment = 0;
    double squares = 0;
    std::array<double, 2> parity{};
    for (int k = 0; k < 4; ++k) {
      const double p = w.phi[static_cast<std::size_t>(k)];
      EXPECT_NEAR(p, phi(x - (w.base + k)), tolerance);
      EXPECT_GE(p, 0);
      sum += p;
      moment += (x - (w.base + k)) * p;
      squares += p * p;
      parity[static_cast<std::size_t>(k % 2)] += p;
    }
    EXPECT_NEAR(sum, 1, tolerance);
    EXPECT_NEAR(moment, 0, tolerance);
    EXPECT_NEAR(squares, 3.0 / 8.0, tolerance);
    EXPECT_NEAR(parity[0], 0.5, tolerance);
    EXPECT_NEAR(parity[1], 0.5, tolerance);
  }
}

TEST(Delta, IsContinuousAndEndsAtTwo) {
  for (const double r : {0.0, 1.0, 2.0}) {
    EXPECT_NEAR(phi(r - 1e-12), phi(r + 1e-12), 1e-5);  // square-root ends
    EXPECT_EQ(phi(r), phi(-r));
  }
  EXPECT_EQ(phi(2), 0);
  EXPECT_EQ(phi(2.5), 0);
  EXPECT_NEAR(phi(0), 0.5, tolerance);
  EXPECT_NEAR(phi(1), 0.25, tolerance);
}

}  // namespace
