#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "validation/support.hpp"

namespace {

using namespace ductile;

// Drag on a sphere held in a simple cubic array of side L, as F = 6 pi eta R K U, U the superficial
// mean velocity: K. The body force on the whole cell, L^3 f, is what holds it.
double drag_coefficient(int L, double radius, double retraction) {
  fluid::Options options = test::box(L, L, L, 1.0);
  options.collision = fluid::Collision::trt;
  constexpr double f = 1e-6;
  options.force = {0, 0, f};
  fluid::Fluid fluid(MPI_COMM_SELF, options);
  rigid::Options held;
  held.motion = rigid::Motion::prescribed;
  rigid::Body body = test::sphere(radius - retraction, held, Eigen::Vector3d::Constant(L / 2.0), 1);
  drivers::RigidMarkers markers(body);
  coupling::Coupler coupler(fluid, {{0, &markers}}, 1);
  double mean = 0;
  for (int n = 0; n < 40 * L; ++n) {
    coupler.step();
    if (n % 100 != 99) continue;
    const double now = fluid.totals().momentum.z() / std::pow(L, 3);
    if (std::abs(now - mean) < 1e-4 * std::abs(now)) break;
    mean = now;
  }
  mean = fluid.totals().momentum.z() / std::pow(L, 3);
  return f * std::pow(L, 3) / (6 * std::numbers::pi * fluid.viscosity() * radius * mean);
}

// Zick & Homsy 1982, table 2.
TEST(SphereArray, DragIsThatOfZickAndHomsy) {
  for (const auto& [ratio, K] : std::vector<std::array<double, 2>>{
           {0.186105, 2.008}, {0.248140, 2.810}, {0.310175, 4.292}, {0.372210, 7.442}}) {
    for (const int L : {32, 64}) {
      for (const double r : {0.0, 0.3, 0.4}) {
        std::printf("R/L %g L %d retraction %g: K %g, %.2f%% off\n", ratio, L, r,
                    drag_coefficient(L, ratio * L, r),
                    100 * (drag_coefficient(L, ratio * L, r) / K - 1));
      }
      if (L == 32) continue;
    }
  }
}

}  // namespace
