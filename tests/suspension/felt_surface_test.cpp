#include "ductile/suspension/felt_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "ductile/fluid/delta.hpp"
#include "ductile/surface/biconcave.hpp"
#include "ductile/surface/sphere.hpp"

namespace {

using namespace ductile;
using suspension::felt_modulus_factor;
using suspension::felt_retraction;

fluid::Options relaxing(double tau) {
  fluid::Options options;
  options.tau = tau;
  return options;
}

membrane::Moduli skalak(double k_a) {
  membrane::Moduli moduli;
  moduli.k_s = 1;
  moduli.k_a = k_a;
  return moduli;
}

double second_moment() {
  constexpr int steps = 4000;
  double sum = 0;
  for (int n = 0; n < steps; ++n) {
    const double r = 2 * (n + 0.5) / steps;
    sum += 2 * r * r * fluid::phi(r) * 2 / steps;
  }
  return sum;
}

// Two draws from a Gaussian of the kernel's second moment m are 2 sqrt(m/pi) apart in the mean.
TEST(FeltSurface, AFlatOneIsFeltHalfTheMeanDistanceOfTwoDrawsFurtherOut) {
  const double flat = std::sqrt(second_moment() / std::numbers::pi);
  EXPECT_NEAR(felt_retraction(surface::Biconcave(7.2), relaxing(1)), flat, 1e-3);
  EXPECT_NEAR(felt_retraction(surface::Sphere(4000), relaxing(1)), flat, 2e-3);
}

// By a Stokes calculation of its own, markers on a sphere of b against a strained flow, each pair
// with the Oseen tensor of the kernel's two Gaussians, 500 markers: stresslets over that of radius
// a are 1 for b = a - retraction at a = 5 and 10.
TEST(FeltSurface, ACurvedOneFurther) {
  const double m = second_moment();
  for (const double a : {5.0, 7.2, 10.0, 18.0}) {
    const double found = felt_retraction(surface::Sphere(a), relaxing(1));
    EXPECT_NEAR(found, std::sqrt(m / std::numbers::pi) + 1.43 / a, 0.015) << a;
  }
  // On a lattice of twice the nodes the surface moves inwards by about half as much of the radius.
  EXPECT_LT(felt_retraction(surface::Sphere(10), relaxing(1)),
            felt_retraction(surface::Sphere(5), relaxing(1)));
  EXPECT_LE(felt_retraction(surface::Sphere(1), relaxing(1)), 0.5);
}

// Stresslet and octupole are right at these, by a calculation of its own (Bessel functions and
// quadrature of SciPy).
TEST(FeltSurface, ARigidSphereSlipsToo) {
  struct Place {
    double a, retraction, slip;
  };
  for (const Place& known : {Place{4.8, 0.5385, 0.0372},
                             {6, 0.4485, 0.0653},
                             {7.2, 0.3888, 0.0914},
                             {9.6, 0.3119, 0.1351},
                             {14.4, 0.2291, 0.1948}}) {
    const auto found = suspension::felt_place(surface::Sphere(known.a), relaxing(1));
    EXPECT_NEAR(found.retraction, known.retraction, 1e-3) << known.a;
    EXPECT_NEAR(found.slip, known.slip, 1e-3) << known.a;
  }
  // A large one has all of it in the slip, as flat surfaces may.
  const auto flat = suspension::felt_place(surface::Sphere(4000), relaxing(1));
  EXPECT_NEAR(flat.retraction, 0, 1e-3);
  EXPECT_NEAR(flat.slip, std::sqrt(second_moment() / std::numbers::pi), 2e-3);
  // Without slip what is left to the retraction is all of it.
  const surface::Sphere sphere(7.2);
  const auto place = suspension::felt_place(sphere, relaxing(1));
  EXPECT_NEAR(felt_retraction(sphere, relaxing(1), place.slip), place.retraction, 1e-5);
  EXPECT_EQ(suspension::felt_place(surface::Biconcave(7.2), relaxing(1)).slip, 0);
}

TEST(FeltSurface, FollowsTheMagicParameter) {
  const surface::Sphere sphere(7.2);
  const double at_1 = felt_retraction(sphere, relaxing(1));
  EXPECT_NEAR(felt_retraction(sphere, relaxing(0.6)) - at_1, 0.4 * 0.24, 0.015);
  fluid::Options trt = relaxing(0.6);
  trt.collision = fluid::Collision::trt;
  trt.magic = 0.25;
  EXPECT_EQ(suspension::magic_of(trt), suspension::magic_of(relaxing(1)));
  EXPECT_EQ(felt_retraction(sphere, trt), at_1);
}

// In weak shear D/Ca is (15/4)(2 + s)/(1 + s), s = C/(1 + C), for C = k_a/k_s. Measured in a box of
// ten radii (Ca = 0.002, a strain of 0.6, which the box raises by 1%) with moduli as given and this
// retraction: 5.402, 5.435, 5.470 at a = 5 for C = 1, 2, 10, and 5.754, 5.673 at a = 7 for 1, 2.
TEST(FeltSurface, ModuliMakeUpForWhatItDoesToACapsulesForces) {
  const auto factor = [](double a, double C) {
    const surface::Sphere sphere(a);
    return felt_modulus_factor(sphere, felt_retraction(sphere, relaxing(1)), skalak(C),
                               relaxing(1));
  };
  const auto law = [](double C) { return 1.01 * 3.75 * (2 + 3 * C) / (1 + 2 * C); };
  EXPECT_NEAR(5.402 / factor(5, 1), law(1), 0.01 * law(1));
  EXPECT_NEAR(5.435 / factor(5, 2), law(2), 0.01 * law(2));
  EXPECT_NEAR(5.470 / factor(5, 10), law(10), 0.01 * law(10));
  EXPECT_NEAR(5.754 / factor(7, 1), law(1), 0.01 * law(1));
  EXPECT_NEAR(5.673 / factor(7, 2), law(2), 0.01 * law(2));
}

TEST(FeltSurface, ModuliStayWithoutRetractionOrSphere) {
  EXPECT_EQ(felt_modulus_factor(surface::Sphere(7), 0, skalak(2), relaxing(1)), 1);
  EXPECT_EQ(felt_modulus_factor(surface::Biconcave(7), 0.4, skalak(2), relaxing(1)), 1);
  EXPECT_EQ(felt_modulus_factor(surface::Sphere(7), 0.4, {}, relaxing(1)), 1);
  membrane::Moduli neo_hookean = skalak(5);
  neo_hookean.law = membrane::StrainLaw::neo_hookean;
  EXPECT_EQ(felt_modulus_factor(surface::Sphere(7), 0.5, neo_hookean, relaxing(1)),
            felt_modulus_factor(surface::Sphere(7), 0.5, skalak(1), relaxing(1)));
  EXPECT_NEAR(felt_modulus_factor(surface::Sphere(4000), 0.4, skalak(2), relaxing(1)), 1, 1e-3);
}

}  // namespace
