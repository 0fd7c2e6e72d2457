#include <gtest/gtest.h>

#include <cmath>

#include "validation/support.hpp"

namespace {

using namespace ductile;

// A capsule larger than its reference holds the pressure p a/k_s = (2/3) [(l^2 - 1)/l +
// C l (l^4 - 1)], l its stretch: the sign and the size of the force that the fluid receives.
TEST(PreInflatedCapsule, HoldsThePressureOfItsTension) {
  constexpr double a = 9;
  constexpr double k_s = 0.05;
  constexpr double C = 2;
  fluid::Fluid fluid(MPI_COMM_SELF, test::box(48, 48, 48, 1.0));
  membrane::Moduli moduli;
  moduli.k_s = k_s;
  moduli.k_a = C * k_s;
  membrane::CapsuleOptions options;
  options.viscosity = fluid.viscosity();
  options.mobility = 0;  // under pressure the mobility would let fluid through
  const auto capsule =
      test::capsule(a, 1.05, moduli, options, Eigen::Vector3d(23.4, 23.7, 24.1), 1.1);
  suspension::CapsuleMarkers markers(*capsule);
  coupling::Coupler coupler(fluid, {{0, &markers}}, 1);
  for (int n = 0; n < 3000; ++n) coupler.step();

  std::vector<double> density(48 * 48 * 48);
  std::vector<double> velocity(3 * density.size());
  fluid.fields(density, velocity);
  const auto pressure = [&](std::size_t i, std::size_t j, std::size_t k) {
    return (density[(i * 48 + j) * 48 + k] - 1) / 3;
  };
  const double inside = pressure(23, 24, 24);
  const double outside = (pressure(1, 1, 1) + pressure(23, 24, 1) + pressure(1, 24, 24)) / 3;
  const double l = std::cbrt(capsule->shape().volume / capsule->shell().reference_volume());
  EXPECT_NEAR(l, 1.05, 0.005);  // what leaks through, of the stretch
  const double expected = 2.0 / 3.0 * k_s / a * ((l * l - 1) / l + C * l * (std::pow(l, 4) - 1));
  EXPECT_NEAR(inside - outside, expected, 0.03 * expected);
  RecordProperty("pressure_ratio", std::to_string((inside - outside) / expected));
}

// Nothing moves a capsule at rest in a fluid at rest, and nothing deforms it.
TEST(Capsule, AtRestStaysAtRest) {
  fluid::Fluid fluid(MPI_COMM_SELF, test::box(20, 20, 20, 1.0));
  membrane::Moduli moduli;
  moduli.k_s = 0.1;
  moduli.k_a = 0.2;
  moduli.k_b = 0.01;
  moduli.k_v = 0.5;
  membrane::CapsuleOptions options;
  options.viscosity = fluid.viscosity();
  const auto capsule = test::capsule(5, 1, moduli, options, Eigen::Vector3d(9.3, 9.6, 9.8), 1.2);
  const std::vector<double> before(capsule->positions().begin(), capsule->positions().end());
  suspension::CapsuleMarkers markers(*capsule);
  coupling::Coupler coupler(fluid, {{0, &markers}}, 1);
  for (int n = 0; n < 500; ++n) coupler.step();
  for (std::size_t n = 0; n < before.size(); ++n) {
    EXPECT_NEAR(capsule->positions()[n], before[n], 1e-11);
  }
}

}  // namespace
