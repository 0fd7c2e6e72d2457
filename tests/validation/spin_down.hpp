// A sphere that spins in a fluid at rest and is left to itself: exact laws, and the body's motion.
//
// Times are in a^2/nu, spins in the initial one, omega_0. With s the Laplace variable the fluid
// outside takes the torque 8 pi eta a^3 [1 + s/(3 (1 + sqrt s))] (Lamb 1932, art. 334; Landau &
// Lifshitz 1987, sect. 24, problem), so that
//
//     Omega = (omega_0/s) J/[1 + s/(3 (1 + sqrt s)) + J]
//
// where J s is the torque that the body's angular momentum stands for: (ratio - 1) s/15 of the
// excess mass, s/15 of a solid of the fluid's density, G/3 of fluid that fills a shell and turned
// with it: G = x i_1'(x)/i_1(x) - 1, x = sqrt s, i_1 = cosh x/x - sinh x/x^2.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "validation/support.hpp"

namespace ductile::test {

/// The function whose Laplace transform is F, at t > 0, by Talbot's contour (Abate & Valko, Int. J.
/// Numer. Meth. Engng 60, 979, 2004): F must be analytic but on the negative real axis and 0. To
/// some 12 digits.
template <class Transform>
double inverse_laplace(const Transform& F, double t) {
  constexpr int M = 24;
  const double r = 2.0 * M / (5 * t);
  double sum = 0.5 * std::exp(r * t) * F(std::complex<double>(r)).real();
  for (int k = 1; k < M; ++k) {
    const double theta = k * std::numbers::pi / M;
    const double cotangent = 1 / std::tan(theta);
    const std::complex<double> s = r * theta * std::complex<double>(cotangent, 1);
    const double sigma = theta + (theta * cotangent - 1) * cotangent;
    sum += (std::exp(t * s) * F(s) * std::complex<double>(1, sigma)).real();
  }
  return r / M * sum;
}

/// omega/omega_0 at t, in a^2/nu, by the law above. Fluid inside of a body lighter than it has no
/// such law: the spin then grows without end.
inline double spin_law(double density_ratio, Interior interior, double t) {
  using Complex = std::complex<double>;
  return inverse_laplace(
      [&](Complex s) {
        const Complex x = std::sqrt(s);
        const Complex G = x / (1.0 / std::tanh(x) - 1.0 / x) - 3.0;
        const Complex J =
            (density_ratio - 1) * s / 15.0 + (interior == Interior::solid ? s / 15.0 : G / 3.0);
        return J / s / (1.0 + s / (3.0 * (1.0 + x)) + J);
      },
      t);
}

/// A sphere that begins to turn in a periodic cube, 5 a wide, of fluid at rest outside of it.
struct SpinDown {
  double radius = 8;
  double density_ratio = 1;
  Interior interior = Interior::fluid;
  double retraction = 0;
};

/// omega/omega_0 at the times, which ascend, in a^2/nu; tau = 1.
inline std::vector<double> spins(const SpinDown& given, const std::vector<double>& times) {
  const double omega = 8e-3 / given.radius;
  const int L = static_cast<int>(5 * given.radius);
  fluid::Fluid fluid(MPI_COMM_SELF, box(L, L, L, 1.0));
  rigid::State state;
  state.position = Eigen::Vector3d::Constant(L / 2.0) + Eigen::Vector3d(0.2, 0.1, -0.3);
  state.angular_velocity = {0, 0, omega};
  fluid.initialise([&](int i, int j, int k) {
    fluid::NodeState node;
    const Eigen::Vector3d r = Eigen::Vector3d(i, j, k) - state.position;
    if (r.norm() < given.radius) node.velocity = state.angular_velocity.cross(r);
    return node;
  });
  rigid::Options options;
  options.density_ratio = given.density_ratio;
  rigid::Body body = sphere(given.radius, options, state, given.retraction, given.interior);
  suspension::RigidMarkers markers(body);
  coupling::Coupler coupler(fluid, {{0, &markers}}, 1);
  const auto spin = [&] { return body.state().angular_velocity.z() / omega; };
  std::vector<double> found;
  double before = 1;
  for (const double t : times) {
    const double end = t * given.radius * given.radius / fluid.viscosity();
    while (static_cast<double>(fluid.time()) < end) {
      before = spin();
      coupler.step();
    }
    found.push_back(spin() + (before - spin()) * (static_cast<double>(fluid.time()) - end));
  }
  return found;
}

}  // namespace ductile::test
