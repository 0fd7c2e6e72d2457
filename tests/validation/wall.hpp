// A rigid sphere that is driven towards a plane wall.
#pragma once

#include <cmath>
#include <numbers>

#include "ductile/coupling/coupler.hpp"
#include "ductile/suspension/markers.hpp"
#include "validation/support.hpp"

namespace ductile::test {

/// Brenner, Chem. Eng. Sci. 16, 242 (1961), summed anew: force over 6 pi eta a U at gaps of a and
/// of 0.4 a.
constexpr double wall_law_far = 2.125536;
constexpr double wall_law_near = 3.73562;

/// That force as the gap passes through `gap`, in lattice units as the radius; markers lie
/// `inwards` of the surface, with that slip, in dx/eta. The fluid is a cube of `size` radii between
/// walls at both ends of z.
inline double wall_resistance(double radius, double gap, double inwards, double size,
                              double slip = 0) {
  const int L = static_cast<int>(std::lround(size * radius));
  fluid::Options options = box(L, L, L, 1.0);
  options.boundary[2] = fluid::Boundary::halfway;
  fluid::Fluid fluid(MPI_COMM_SELF, options);
  // Until viscosity has gone some four radii.
  const auto steps = std::lround(120 * radius * radius);
  const double speed = 0.12 * radius / static_cast<double>(steps);
  rigid::Options towards;
  towards.motion = rigid::Motion::prescribed;
  const double height = radius + gap + speed * static_cast<double>(steps);
  rigid::Body body = sphere(radius, towards, {L / 2.0, L / 2.0, height - 0.5}, inwards,
                            Interior::fluid, slip / fluid.viscosity());
  body.prescribe({0, 0, -speed}, Eigen::Vector3d::Zero());
  suspension::RigidMarkers markers(body);
  coupling::Coupler coupler(fluid, {{0, &markers}}, 1);
  for (long n = 0; n < steps; ++n) coupler.step();
  return body.hydrodynamic_force().z() /
         (6 * std::numbers::pi * fluid.viscosity() * radius * speed);
}

}  // namespace ductile::test
