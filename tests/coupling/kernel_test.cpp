#include "ductile/coupling/kernel.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <random>

#include "ductile/coupling/stencils.hpp"

namespace {

using namespace ductile;
using namespace ductile::coupling;

constexpr double tolerance = 1e-12;

TEST(Kernel, KeepsPeskinsConditionsAtAnyOffset) {
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

TEST(Kernel, IsContinuousAndEndsAtTwo) {
  for (const double r : {0.0, 1.0, 2.0}) {
    EXPECT_NEAR(phi(r - 1e-12), phi(r + 1e-12), 1e-5);  // square-root ends
    EXPECT_EQ(phi(r), phi(-r));
  }
  EXPECT_EQ(phi(2), 0);
  EXPECT_EQ(phi(2.5), 0);
  EXPECT_NEAR(phi(0), 0.5, tolerance);
  EXPECT_NEAR(phi(1), 0.25, tolerance);
}

std::vector<double> random_numbers(std::size_t count, double low, double high, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(low, high);
  std::vector<double> v(count);
  for (double& x : v) x = number(random);
  return v;
}

fluid::Patch patch_of(std::array<int, 3> size) {
  fluid::Patch patch;
  patch.size = size;
  patch.pitch = size[2] + 2 * fluid::Patch::pad;
  const auto count = static_cast<std::size_t>(size[0] * size[1] * patch.pitch);
  for (std::size_t a = 0; a < 3; ++a) {
    patch.force[a].assign(count, 0);
    patch.velocity[a].assign(count, 0);
  }
  return patch;
}

double sum_of_own(const fluid::Patch& patch, const std::function<double(std::size_t)>& f) {
  double sum = 0;
  for (int i = 0; i < patch.size[0]; ++i) {
    for (int j = 0; j < patch.size[1]; ++j) {
      for (int k = 0; k < patch.size[2]; ++k) sum += f(static_cast<std::size_t>(patch.at(i, j, k)));
    }
  }
  return sum;
}

// F . (J u) = (J^T F) . u, with and without a periodic z in which stencils meet both ends.
TEST(ImmersedBoundary, SpreadIsAdjointOfInterpolate) {
  for (const int period : {0, 12}) {
    fluid::Patch patch = patch_of({10, 10, 12});
    constexpr std::size_t markers = 200;
    std::vector<double> x = random_numbers(3 * markers, 1.0, 8.0, 2);
    if (period > 0) {
      for (std::size_t m = 0; m < markers; ++m) x[3 * m + 2] = 6 * x[3 * m + 2] - 20;
    }
    const std::vector<double> force = random_numbers(3 * markers, -1, 1, 3);
    const std::vector<double> u = random_numbers(3 * patch.velocity[0].size(), -1, 1, 4);
    for (std::size_t a = 0; a < 3; ++a) {
      for (int i = 0; i < 10; ++i) {
        for (int j = 0; j < 10; ++j) {
          for (int k = 0; k < 12; ++k) {
            const auto n = static_cast<std::size_t>(patch.at(i, j, k));
            patch.velocity[a][n] = u[3 * n + a];
          }
        }
      }
    }
    Stencils stencils;
    stencils.locate(x);
    stencils.spread(force, patch, period);
    std::vector<double> partial(12 * markers, 0.0);
    stencils.interpolate(patch, period, partial);
    double markers_side = 0;
    double size = 0;
    for (std::size_t n = 0; n < 3 * markers; ++n) {
      const double velocity =
          partial[4 * n] + partial[4 * n + 1] + partial[4 * n + 2] + partial[4 * n + 3];
      markers_side += force[n] * velocity;
      size += std::abs(force[n] * velocity);
    }
    double nodes_side = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      nodes_side += sum_of_own(
          patch, [&](std::size_t n) { return patch.force[a][n] * patch.velocity[a][n]; });
      double total = 0;
      for (std::size_t m = 0; m < markers; ++m) total += force[3 * m + a];
      EXPECT_NEAR(sum_of_own(patch, [&](std::size_t n) { return patch.force[a][n]; }), total,
                  1e-12);
    }
    EXPECT_NEAR(markers_side, nodes_side, 1e-13 * size);
  }
}

// What a lesser machine would run gives the same bits.
TEST(ImmersedBoundary, IsTheSameWithEachInstructionSet) {
  constexpr std::size_t markers = 100;
  const std::vector<double> x = random_numbers(3 * markers, 1.0, 8.0, 12);
  const std::vector<double> force = random_numbers(3 * markers, -1, 1, 13);
  fluid::Patch expected = patch_of({10, 10, 12});
  std::vector<double> expected_partial;
  std::vector<double> expected_response;
  for (const auto set : {fluid::InstructionSet::baseline, fluid::InstructionSet::avx2,
                         fluid::InstructionSet::avx512}) {
    if (!fluid::available(set)) continue;
    fluid::Patch patch = patch_of({10, 10, 12});
    Stencils stencils(set);
    stencils.locate(x);
    stencils.spread(force, patch, 0);
    patch.velocity = patch.force;
    std::vector<double> partial(12 * markers, 0.0);
    stencils.interpolate(patch, 0, partial);
    MarkerResponse response(set);
    response.locate(x);
    std::vector<double> velocity(3 * markers);
    response.apply(force, velocity);
    if (set == fluid::InstructionSet::baseline) {
      expected = patch;
      expected_partial = partial;
      expected_response = velocity;
      EXPECT_GT(*std::max_element(velocity.begin(), velocity.end()), 0);
    }
    EXPECT_EQ(patch.force, expected.force);
    EXPECT_EQ(partial, expected_partial);
    EXPECT_EQ(velocity, expected_response);
  }
}

// sum over nodes of (X - x) x f vanishes: spreading keeps the torque about the marker.
TEST(ImmersedBoundary, SpreadKeepsForceAndTorque) {
  fluid::Patch patch = patch_of({6, 6, 6});
  const std::vector<double> x = {2.3, 2.71, 2.05};
  const std::vector<double> force = {1, -2, 0.5};
  Stencils stencils;
  stencils.locate(x);
  stencils.spread(force, patch, 0);
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      for (int k = 0; k < 6; ++k) {
        const auto n = static_cast<std::size_t>(patch.at(i, j, k));
        const Eigen::Vector3d r(i - x[0], j - x[1], k - x[2]);
        torque += r.cross(Eigen::Vector3d(patch.force[0][n], patch.force[1][n], patch.force[2][n]));
      }
    }
  }
  EXPECT_LT(torque.norm(), 1e-14);
}

TEST(ImmersedBoundary, InterpolationIsExactForLinearFields) {
  fluid::Patch patch = patch_of({8, 8, 8});
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) {
      for (int k = 0; k < 8; ++k) {
        patch.velocity[1][static_cast<std::size_t>(patch.at(i, j, k))] = 1 + 2 * i - j + 0.5 * k;
      }
    }
  }
  const std::vector<double> x = {3.14, 2.72, 4.67};
  Stencils stencils;
  stencils.locate(x);
  std::vector<double> partial(12, 0.0);
  stencils.interpolate(patch, 0, partial);
  EXPECT_NEAR(partial[4] + partial[5] + partial[6] + partial[7], 1 + 2 * x[0] - x[1] + 0.5 * x[2],
              1e-13);
}

TEST(Response, IsSymmetricAndPositiveSemiDefinite) {
  constexpr std::size_t markers = 40;
  const std::vector<double> x = random_numbers(3 * markers, -4, 4, 5);
  MarkerResponse response;
  response.locate(x);
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

}  // namespace
