#include "ductile/fluid/duct.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace {

using ductile::fluid::DuctFlow;

// Eq. (1), summed to eight digits independently.
TEST(DuctFlow, MatchesTheSeriesOfTheSquareDuct) {
  const DuctFlow flow({1, 1}, 1, 1);
  EXPECT_NEAR(flow.maximum(), 0.29468541, 1e-8);
  EXPECT_NEAR(flow.mean(), 0.14057701, 1e-8);
  EXPECT_NEAR(flow.maximum() / flow.mean(), 2.0962560, 1e-6);
  EXPECT_NEAR(flow.velocity(0.25, 0) / flow.maximum(), 0.9463730, 1e-7);
  EXPECT_NEAR(flow.velocity(0.5, 0) / flow.maximum(), 0.7782524, 1e-7);
  EXPECT_NEAR(flow.velocity(0, 0.75) / flow.maximum(), 0.4741637, 1e-7);
  EXPECT_NEAR(flow.velocity(-0.5, 0.5) / flow.maximum(), 0.6147051, 1e-7);
}

TEST(DuctFlow, MatchesTheSeriesOfTheOneToTwoDuctEitherWayRound) {
  for (const DuctFlow& flow : {DuctFlow({1, 2}, 1, 1), DuctFlow({2, 1}, 1, 1)}) {
    EXPECT_NEAR(flow.maximum(), 0.45548733, 1e-8);
    EXPECT_NEAR(flow.maximum() / flow.mean(), 1.9917963, 1e-6);
  }
}

TEST(DuctFlow, ScalesAsForceOverViscosity) {
  const DuctFlow flow({3, 3}, 0.5, 0.2);
  EXPECT_NEAR(flow.maximum(), 0.29468541 * 0.5 * 9 / 0.2, 1e-6);
}

TEST(DuctFlow, GradientIsTheDerivative) {
  constexpr double h = 1e-5;
  for (const auto& half : {std::array<double, 2>{1, 1}, {1, 2}, {2, 1}}) {
    const DuctFlow flow(half, 1, 1);
    for (const double x : {-0.9, -0.3, 0.0, 0.55}) {
      for (const double y : {-0.7, 0.1, 0.8}) {
        const Eigen::Vector2d g = flow.gradient(x, y);
        EXPECT_NEAR(g[0], (flow.velocity(x + h, y) - flow.velocity(x - h, y)) / (2 * h), 1e-8);
        EXPECT_NEAR(g[1], (flow.velocity(x, y + h) - flow.velocity(x, y - h)) / (2 * h), 1e-8);
      }
    }
  }
}

TEST(DuctFlow, VanishesAtTheWalls) {
  const DuctFlow flow({1, 2}, 1, 1);
  EXPECT_EQ(flow.velocity(1, 0.3), 0);
  EXPECT_EQ(flow.velocity(0.2, -2), 0);
  EXPECT_NEAR(flow.velocity(1 - 1e-9, 0.3), 0, 1e-7);
}

TEST(DuctFlow, RejectsWhatIsNoDuct) {
  EXPECT_THROW(DuctFlow({0, 1}, 1, 1), std::invalid_argument);
  EXPECT_THROW(DuctFlow({1, -1}, 1, 1), std::invalid_argument);
  EXPECT_THROW(DuctFlow({1, 1}, 1, 0), std::invalid_argument);
}

}  // namespace
