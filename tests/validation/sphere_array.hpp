// Drag in a cubic array of spheres.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "validation/support.hpp"

namespace ductile::test {

// Drag on a sphere held in a simple cubic array of side L, as F = 6 pi eta R K U, U the superficial
// mean velocity: K. The body force on the whole cell, L^3 f, is what holds it.
// The approach to the steady state is slow, L^3/(6 pi eta R K) steps; it starts at the mean
// velocity that goes with the drag `guess`, and ends when the velocity has stopped changing.
// `slip` in dx/eta, as of suspension::FeltPlace.
inline double drag_coefficient(int L, double radius, double guess, double inwards,
                               Interior interior = Interior::fluid, double slip = 0) {
  constexpr double eta = 1.0 / 6.0;
  constexpr double f = 1e-6;
  const double cell = std::pow(L, 3);
  const double stokes = 6 * std::numbers::pi * eta * radius;
  fluid::Options options = box(L, L, L, 1.0);
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
  rigid::Body body =
      sphere(radius, held, Eigen::Vector3d::Constant(L / 2.0 + 0.2), inwards, interior, slip / eta);
  suspension::RigidMarkers markers(body);
  coupling::Coupler coupler(fluid, {{0, &markers}}, 1);
  const auto mean_velocity = [&] { return fluid.totals().momentum.z() / cell; };
  // Dense arrays have less momentum to lose than time to pass it on.
  const double diffusion = L * L / (40 * eta);
  const int interval = static_cast<int>(0.1 * std::max(cell / (stokes * guess), diffusion));
  double before = mean_velocity();
  for (int n = 0; n < 60; ++n) {
    for (int step = 0; step < interval; ++step) coupler.step();
    const double now = mean_velocity();
    // What is left of an exponential is ten times what the last tenth of its time has changed.
    if (n > 9 && std::abs(now - before) < 3e-4 * now) break;
    before = now;
  }
  return f * cell / (stokes * mean_velocity());
}

}  // namespace ductile::test
