#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "validation/support.hpp"

namespace {

using namespace ductile;

// Drag on a sphere held in a simple cubic array of side L, as F = 6 pi eta R K U, U the superficial
// mean velocity: K. The body force on the whole cell, L^3 f, is what holds it.
// The approach to the steady state is slow, L^3/(6 pi eta R K) steps; it starts at the mean
// velocity that goes with the drag `guess`, and ends when the velocity has stopped changing.
double drag_coefficient(int L, double radius, double guess, double inwards) {
  constexpr double eta = 1.0 / 6.0;
  constexpr double f = 1e-6;
  const double cell = std::pow(L, 3);
  const double stokes = 6 * std::numbers::pi * eta * radius;
  fluid::Options options = test::box(L, L, L, 1.0);
  options.collision = fluid::Collision::trt;
  options.force = {0, 0, f};
  fluid::Fluid fluid(MPI_COMM_SELF, options);
  fluid.initialise([&](int, int, int) {
    fluid::NodeState s;
    s.velocity[2] = f * cell / (stokes * guess);
    return s;
  });
  rigid::Options held;
  held.motion = rigid::Motion::prescribed;
  rigid::Body body = test::sphere(radius, held, Eigen::Vector3d::Constant(L / 2.0 + 0.2), inwards);
  drivers::RigidMarkers markers(body);
  coupling::Coupler coupler(fluid, {{0, &markers}}, 1);
  const auto mean_velocity = [&] { return fluid.totals().momentum.z() / cell; };
  const int interval = static_cast<int>(0.1 * cell / (stokes * guess));
  double before = mean_velocity();
  for (int n = 0; n < 60; ++n) {
    for (int step = 0; step < interval; ++step) coupler.step();
    const double now = mean_velocity();
    // What is left of an exponential is ten times what the last tenth of its time has changed.
    if (n > 2 && std::abs(now - before) < 3e-4 * now) break;
    before = now;
  }
  return f * cell / (stokes * mean_velocity());
}

struct Array {
  double radius;  // over L
  double K;
  int L;  // for a radius of ten lattice spacings or more
};
// Zick & Homsy 1982, table 2; volume fractions 0.027 to 0.343.
constexpr std::array<Array, 5> table = {{{0.186105, 2.008, 54},
                                         {0.248140, 2.810, 42},
                                         {0.310175, 4.292, 34},
                                         {0.372210, 7.442, 32},
                                         {0.434245, 15.4, 36}}};

// A surface of the 4-point kernel is felt half a lattice spacing further out than its markers are:
// with them on the sphere, the drag is too high by an error of first order.
TEST(SphereArray, DragApproachesZickAndHomsyAtFirstOrder) {
  const auto& [ratio, K, L] = table[0];
  const double coarse = drag_coefficient(32, ratio * 32, K, 0) / K - 1;
  const double fine = drag_coefficient(L, ratio * L, K, 0) / K - 1;
  std::printf("radius %.2f: +%.2f%%, radius %.2f: +%.2f%%\n", ratio * 32, 100 * coarse, ratio * L,
              100 * fine);
  EXPECT_GT(fine, 0);
  EXPECT_GT(std::log(coarse / fine) / std::log(static_cast<double>(L) / 32), 0.9);
}

TEST(SphereArray, DragIsThatOfZickAndHomsyForTheHydrodynamicRadius) {
  for (const auto& [ratio, K, L] : table) {
    const double drag = drag_coefficient(L, ratio * L, K, test::retraction);
    std::printf("R/L = %.6f, L = %d: K = %.3f, %+.2f%%\n", ratio, L, drag, 100 * (drag / K - 1));
    EXPECT_NEAR(drag, K, 0.05 * K);
  }
}

}  // namespace
