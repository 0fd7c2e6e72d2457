#include "response.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "support/random_numbers.hpp"

namespace {

using namespace ductile;
using coupling::MarkerResponse;
using ductile::testing_support::random_numbers;

// What a lesser machine would run gives the same bits.
TEST(Response, IsTheSameWithEachInstructionSet) {
  constexpr std::size_t markers = 100;
  const std::vector<double> x = random_numbers(3 * markers, 1.0, 8.0, 12);
  const std::vector<double> force = random_numbers(3 * markers, -1, 1, 13);
  std::vector<double> expected;
  for (const auto set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!available(set)) continue;
    MarkerResponse response(fluid::Mirror::none, set);
    response.locate(x);
    std::vector<double> velocity(3 * markers);
    response.apply(force, velocity);
    if (set == InstructionSet::baseline) {
      expected = velocity;
      EXPECT_GT(*std::max_element(velocity.begin(), velocity.end()), 0);
    }
    EXPECT_EQ(velocity, expected);
  }
}

class OfFluid : public testing::TestWithParam<std::tuple<fluid::Mirror, double>> {};

TEST_P(OfFluid, IsSymmetricAndPositiveSemiDefinite) {
  constexpr std::size_t markers = 40;
  const std::vector<double> x = random_numbers(3 * markers, -4, 4, 5);
  const auto [mirror, share] = GetParam();
  MarkerResponse response(mirror);
  response.locate(x, share);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const std::vector<double> a = random_numbers(3 * markers, -1, 1, 10 + seed);
    const std::vector<double> b = random_numbers(3 * markers, -1, 1, 100 + seed);
    std::vector<double> ra(3 * markers);
    std::vector<double> rb(3 * markers);
    response.apply(a, ra);
    response.apply(b, rb);
    double ab = 0;
    double ba = 0;
    double aa = 0;
    for (std::size_t n = 0; n < a.size(); ++n) {
      ab += a[n] * rb[n];
      ba += b[n] * ra[n];
      aa += a[n] * ra[n];
    }
    EXPECT_NEAR(ab, ba, 1e-13);
    EXPECT_GE(aa, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Response, OfFluid,
                         testing::Values(std::tuple(fluid::Mirror::none, 1.0),
                                         std::tuple(fluid::Mirror::between_nodes, 0.5),
                                         std::tuple(fluid::Mirror::between_nodes, 1.0),
                                         std::tuple(fluid::Mirror::on_node, 0.5),
                                         std::tuple(fluid::Mirror::on_node, 1.0)));

}  // namespace
