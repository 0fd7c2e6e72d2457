// The slip that multi-direct forcing leaves in a fluid, with and without a memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "ductile/fluid/duct.hpp"
#include "validation/support.hpp"

namespace {

using namespace ductile;

constexpr int nodes = 24;
constexpr double centre = (nodes - 1) / 2.0;

struct Forcing {
  int corrections;
  double memory;
};
constexpr Forcing five{5, 0};
constexpr Forcing remembering{2, 0.9};

struct Sphere {
  double radius;
  Eigen::Vector3d position;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
};

// The slip of the first sphere over U_max, the largest and the mean rms of the second half of
// `steps`, in the duct's flow at U_max = 0.05.
rigid::Slip slip(const std::vector<Sphere>& spheres, const Forcing& forcing, double density_ratio,
                 int steps) {
  constexpr double maximum = 0.05;
  fluid::Options options = test::box(nodes, nodes, 2 * nodes, 1.0);
  options.boundary[0] = options.boundary[1] = fluid::Boundary::halfway;
  const double nu = (options.tau - 0.5) / 3;
  options.force[2] = maximum / fluid::DuctFlow({nodes / 2.0, nodes / 2.0}, 1, nu).maximum();
  const fluid::DuctFlow duct({nodes / 2.0, nodes / 2.0}, options.force[2], nu);
  fluid::Fluid fluid(MPI_COMM_SELF, options);
  fluid.initialise([&](int i, int j, int) {
    fluid::NodeState s;
    s.velocity[2] = duct.velocity(i - centre, j - centre);
    const Eigen::Vector2d g = duct.gradient(i - centre, j - centre);
    s.gradient(0, 2) = g[0];
    s.gradient(1, 2) = g[1];
    return s;
  });
  std::vector<std::unique_ptr<rigid::Body>> bodies;
  std::vector<std::unique_ptr<suspension::RigidMarkers>> markers;
  std::vector<coupling::Member> members;
  for (const Sphere& sphere : spheres) {
    rigid::Options body;
    body.corrections = forcing.corrections;
    body.memory = forcing.memory;
    body.density_ratio = density_ratio;
    body.gravity = sphere.gravity;
    bodies.push_back(
        std::make_unique<rigid::Body>(test::sphere(sphere.radius, body, sphere.position, 0)));
    markers.push_back(std::make_unique<suspension::RigidMarkers>(*bodies.back()));
    members.push_back({static_cast<int>(members.size()), markers.back().get()});
  }
  coupling::Coupler coupler(fluid, members, static_cast<int>(members.size()));
  rigid::Slip result;
  for (int n = 0; n < steps; ++n) {
    coupler.step();
    if (n < steps / 2) continue;
    result.max = std::max(result.max, bodies[0]->slip().max / maximum);
    const int counted = steps - steps / 2;
    result.rms += bodies[0]->slip().rms / maximum / counted;
  }
  return result;
}

TEST(Memory, LetsTwoCorrectionsDoWhatFiveDoWithout) {
  const std::vector<Sphere> one = {{0.4 * nodes / 2, {centre + 0.2 * nodes / 2, centre, nodes}}};
  const rigid::Slip slip_5 = slip(one, five, 1, 400);
  const rigid::Slip slip_2 = slip(one, {2, 0}, 1, 400);
  const rigid::Slip with_memory = slip(one, remembering, 1, 400);
  std::printf("rms slip over U_max: 5 corrections %.6f, 2 %.6f, 2 with memory %.6f\n", slip_5.rms,
              slip_2.rms, with_memory.rms);
  // Measured: as much as with five, and five times as much with two alone.
  EXPECT_LT(with_memory.rms, 1.2 * slip_5.rms);
  EXPECT_GT(slip_2.rms, 3 * slip_5.rms);
}

class NearContact : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(DensityRatios, NearContact, ::testing::Values(0.5, 1, 2, 5));

// A gap of one lattice spacing, gravity driving the spheres past each other.
TEST_P(NearContact, LeavesLessSlipAndStaysStableWithMemory) {
  const double ratio = GetParam();
  const double g = ratio == 1 ? 0 : 1e-5 / std::abs(ratio - 1);
  const std::vector<Sphere> pair = {
      {4, {centre + 0.17 - 4.5, centre + 0.31, nodes + 0.07}, {0, 0, -g}},
      {4, {centre + 0.17 + 4.5, centre + 0.31, nodes + 0.07}, {0, 0, g}}};
  const rigid::Slip without = slip(pair, five, ratio, 300);
  const rigid::Slip with_memory = slip(pair, remembering, ratio, 300);
  std::printf("density ratio %.1f: rms slip over U_max %.6f, with memory %.6f\n", ratio,
              without.rms, with_memory.rms);
  EXPECT_LT(with_memory.rms, without.rms);
  EXPECT_LT(with_memory.max, without.max);
}

}  // namespace
