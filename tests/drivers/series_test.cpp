#include "analysis/series.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "analysis/verdict.hpp"

namespace ductile::drivers {
namespace {

constexpr double pi = std::numbers::pi;

// A parabola's curvature is constant, as the spline's is at both ends.
TEST(UniformSeries, FollowsAParabolaExactly) {
  const auto parabola = [](double t) { return 2 - 3 * t + 0.7 * t * t; };
  UniformSeries s;
  double t = 1;
  for (int i = 0; i < 12; ++i) {
    s.add(t, parabola(t));
    t += i % 3 == 0 ? 0.25 : 1.3;
  }
  ASSERT_GT(s.size(), 90U);
  for (std::size_t i = 0; i < s.size(); ++i) EXPECT_NEAR(s[i], parabola(s.time(i)), 1e-11) << i;
}

TEST(UniformSeries, TakesTwoSamplesForALine) {
  UniformSeries s;
  s.add(1, 2);
  s.add(1.25, 4.5);
  ASSERT_EQ(s.size(), 3U);
  EXPECT_NEAR(s.time(2), 1.2, 1e-14);
  EXPECT_NEAR(s[2], 4, 1e-13);
}

// The error of a cubic spline of spacing h: (h omega)^4/384 to leading order, 0.0159 here. With
// four samples a period a straight line between them misses 0.29.
TEST(UniformSeries, ShowsSwingsOfEightUnitsInSamplesTwoApart) {
  UniformSeries s;
  double worst = 0;
  for (int k = 0; k < 60; ++k) {
    const std::size_t firm = s.firm();
    s.add(2 * k, std::sin(2 * pi * (2 * k + 1) / 8));
    for (std::size_t i = firm; i < s.firm(); ++i) {
      if (s.time(i) > 8) {
        worst = std::max(worst, std::abs(s[i] - std::sin(2 * pi * (s.time(i) + 1) / 8)));
      }
    }
  }
  EXPECT_LE(worst, 0.04);
  EXPECT_NEAR(s.time(s.firm() - 1), 2 * 57, 1e-9);
}

TEST(UniformSeries, KeepsItsFirmValues) {
  UniformSeries s;
  std::vector<double> firm;
  for (int k = 0; k < 50; ++k) {
    s.add(0.37 * k, std::sin(2 * pi * 0.37 * k / 0.9) + std::sin(2 * pi * 0.37 * k / 13));
    for (std::size_t i = 0; i < firm.size(); ++i) ASSERT_EQ(s[i], firm[i]);
    while (firm.size() < s.firm()) firm.push_back(s[firm.size()]);
  }
  EXPECT_EQ(firm.size(), UniformSeries::steps(0.37 * 47 - 0.05) + 1);
}

// A Hann window over n periods, n >= 2, has its zeros there: sin(pi n) = 0.
TEST(UniformSeries, SmoothMeanIsBlindToOscillationsThatFitAndNearlySoToOthers) {
  UniformSeries fits;
  UniformSeries does_not;
  for (int i = 0; i <= 300; ++i) {
    const double t = 0.1 * i;
    fits.add(t, 1 + std::sin(2 * pi * t / 5));
    does_not.add(t, 1 + std::sin(2 * pi * t / 8));
  }
  EXPECT_NEAR(fits.smooth_mean(300, 20), 1, 1e-12);
  // |sin(pi n)/(pi n (1 - n^2))| = 0.0243 at n = 2.5
  EXPECT_NEAR(does_not.smooth_mean(300, 20), 1, 0.0244);
}

TEST(Outlook, FindsTheLimitOfAnExponentialExactly) {
  UniformSeries s;
  for (int i = 0; i <= 450; ++i) s.add(0.1 * i, 6 - 5 * std::exp(-0.1 * i / 20));
  const auto o = outlook(s, 450, rules::distance);
  ASSERT_TRUE(o);
  EXPECT_EQ(o->state, Outlook::State::dying);
  EXPECT_NEAR(o->limit, 6, 1e-9);
  // The mean of an exponential over a window exceeds its value in the middle, by 3% here.
  EXPECT_NEAR(o->remaining, 5 * std::exp(-45.0 / 20), 0.03 * o->remaining);
}

TEST(Outlook, DoubtsALimitByWhatIsToCome) {
  UniformSeries s;
  for (int i = 0; i <= 450; ++i) s.add(0.1 * i, 6 - 5 * std::exp(-0.1 * i / 20));
  const Outlook o = outlook(s, 450, rules::distance).value();
  EXPECT_NEAR(o.error, 2 * (o.limit - o.level), 1e-9);
  EXPECT_NEAR(o.misfit, 0, 1e-12);
  EXPECT_NEAR(o.band, 0, 1e-9);
  EXPECT_NEAR(o.departure, 0, 1e-9);
}

// A limit approached as 1/t, of which an exponential falls short.
TEST(Outlook, IsHonestOfASlowApproach) {
  UniformSeries s;
  for (int i = 0; i <= 1000; ++i) s.add(0.1 * i, 2 - 8 / (1 + 0.1 * i));
  for (const std::size_t last : {500U, 600U, 800U, 1000U}) {
    const Outlook o = outlook(s, last, rules::distance).value();
    ASSERT_NE(o.state, Outlook::State::moving);
    EXPECT_LT(o.limit, 1.99) << last;
    EXPECT_GE(o.limit + o.error, 2) << last;
    EXPECT_LE(o.error, 0.6) << last;
  }
}

TEST(Outlook, SeesADepartureFromRest) {
  UniformSeries s;
  const auto dz = [](double t) {
    return 1 + 0.05 * std::sin(2 * pi * t / 6) + 0.02 * std::max(0.0, t - 40);
  };
  for (int i = 0; i <= 480; ++i) s.add(0.1 * i, dz(0.1 * i));
  const Outlook rests = outlook(s, 400, rules::distance).value();
  EXPECT_EQ(rests.state, Outlook::State::resting);
  EXPECT_NEAR(rests.band, 0.1, 0.001);
  EXPECT_LE(rests.departure, 0.001);
  EXPECT_TRUE(rests.settled);
  const Outlook leaves = outlook(s, 480, rules::distance).value();
  EXPECT_EQ(leaves.state, Outlook::State::resting);  // the means do not see it yet
  EXPECT_NEAR(leaves.departure, 0.086, 0.001);  // of 0.16: the line through the means sees some
  EXPECT_FALSE(leaves.settled);
}

TEST(Outlook, NeedsItsWholeSpan) {
  UniformSeries s;
  for (int i = 0; i < 400; ++i) s.add(0.1 * i, 1);
  EXPECT_FALSE(outlook(s, 399, rules::distance));
  s.add(40, 1);
  EXPECT_TRUE(outlook(s, 400, rules::distance));
}

TEST(SettlingWatch, TellsStrainThatPilesUpFromStrainThatSettles) {
  SettlingWatch settles(rules::strain);
  SettlingWatch piles_up(rules::strain);
  SettlingWatch wobbles(rules::strain);
  EXPECT_FALSE(settles.outlook());
  for (int i = 0; i <= 360; ++i) {
    const double t = 0.1 * i;
    settles.update(t, .0018 * (1 - std::exp(-t / 3)) - .0004 * std::exp(-t / 13));
    piles_up.update(t, .0021 + .0013 * std::max(0.0, t - 1));  // N = 36 with edges of 0.62
    wobbles.update(t, .0018 * (1 + 0.2 * std::sin(2 * pi * t / 4.2)));
  }
  EXPECT_TRUE(settles.outlook().value().settled);
  EXPECT_FALSE(piles_up.outlook().value().settled);
  EXPECT_TRUE(wobbles.outlook().value().settled);
}

}  // namespace
}  // namespace ductile::drivers
