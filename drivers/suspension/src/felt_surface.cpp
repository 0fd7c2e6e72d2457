#include "ductile/suspension/felt_surface.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "ductile/surface/sphere.hpp"

namespace ductile::suspension {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using std::numbers::pi;

// The mean of r^2 over Peskin's phi.
constexpr double second_moment = 0.524;
// What 1/4 - magic adds to the retraction: spheres held in a stream at tau = 0.6, 0.8 and 1.
constexpr double magic_share = 0.4;
// Found up to here, at a radius of 3.
constexpr double largest_retraction = 1;
// Radii between which mobility() is computed: below, the kernel is as wide as the sphere, and no
// place is right; above, all goes as 1/a.
constexpr double least_radius = 3;
constexpr double largest_radius = 100;
// The same for what is found from the octupole: above, it hardly tells one place from another.
constexpr double largest_of_octupole = 18;

// Of mode l of the unit viscosity's Stokes flow: the velocity (u_n, u_t) at radius r for the force
// per area (f_n, f_t) there, as fields f_n Y e_r + f_t r grad Y. Forces are smoothed and velocities
// averaged with a Gaussian of the kernel's second moment m: a factor exp(-m k^2) on the transverse
// wave number k.
template <int l>
Matrix2d mobility(double r) {
  static_assert(l == 2 || l == 3);
  // The integrand is even and ends in nothing, so that equal steps converge faster than any power:
  // with these, some five for each radian of k r, to 1e-10.
  const int steps = 2 * static_cast<int>(std::ceil(24 * r));
  constexpr double L = l * (l + 1);
  const double last = 7 / std::sqrt(second_moment);
  Matrix2d m = Matrix2d::Zero();
  for (int n = 1; n <= steps; ++n) {
    const double k = last * n / steps;
    const double x = k * r;
    const double sine = std::sin(x);
    const double cosine = std::cos(x);
    // Spherical Bessel functions; their differences lose digits at small x.
    const double j1 = x < 0.1 ? x / 3 * (1 - x * x / 10) : (sine / x - cosine) / x;
    const double j2 = x < 0.1 ? x * x / 15 * (1 - x * x / 14) : 3 * j1 / x - sine / x;
    const double j3 = x < 0.1 ? x * x * x / 105 * (1 - x * x / 18) : 5 * j2 / x - j1;
    const double normal = L * (l == 2 ? j2 : j3) / x;
    const double tangential = l == 2 ? j1 - 2 * j2 / x : j2 - 3 * j3 / x;
    const double weight = (n % 2 == 0 ? 2 : 4) * std::exp(-second_moment * k * k);
    m(0, 0) += weight * normal * normal / L;
    m(0, 1) += weight * normal * tangential;
    m(1, 1) += weight * tangential * tangential;
  }
  m *= 2 / pi * r * r * last / steps / 3;
  m(1, 0) = m(0, 1) / L;
  return m;
}

double by_magic(const fluid::Options& fluid) {
  return magic_share * (0.25 - magic_of(fluid));
}

// The force per area, over eta E, with which a sphere's markers at radius r hold against a
// straining flow E x: 5 (1, 1/2) if nothing is smoothed.
Vector2d holding_force(double r) {
  return mobility<2>(r).lu().solve(r * Vector2d(1, 0.5));
}

// Strength of the multipole, in parts of that of a sphere of radius a, with which markers at radius
// r hold against grad(r^l Y). `answer` is mobility<l>(r) with what is added to it.
template <int l>
double multipole(const Matrix2d& answer, double r, double a) {
  const Vector2d f = answer.lu().solve(Vector2d(l, 1));
  constexpr double exact = l * (2 * l - 1) * (2 * l + 1) * (2 * l + 1) / (l + 1.0);
  return std::pow(r / a, 2 * l - 1) * r * (l * f[0] + l * (l + 1) * f[1]) / exact;
}

// The slip along the surface with which markers at radius r have the stresslet of a sphere of
// radius a: velocity per tangential force per area.
double slip_for_stresslet(double r, double a) {
  const Matrix2d without = mobility<2>(r);
  double low = 0;
  double high = 1;
  while (high - low > 1e-9) {
    const double middle = (low + high) / 2;
    Matrix2d answer = without;
    answer(1, 1) += middle;
    (multipole<2>(answer, r, a) > 1 ? low : high) = middle;
  }
  return high;
}

// By how much the octupole of such markers is too large.
double octupole_excess(double r, double a) {
  Matrix2d answer = mobility<3>(r);
  answer(1, 1) += slip_for_stresslet(r, a);
  return multipole<3>(answer, r, a) - 1;
}

// Part of the displacement of a membrane of shear modulus 1 along its normal, r^2 times this, under
// that force: from the equilibrium of a thin shell, its modulus of dilation being `dilation`.
double yielding(const Vector2d& force, double dilation) {
  return force[0] * (1 / (4 * dilation) + 0.375) + 0.75 * force[1];
}

// Modulus of dilation over that of shear, k_s/3, at small strain.
double dilation_over_shear(const membrane::Moduli& moduli) {
  return moduli.law == membrane::StrainLaw::skalak ? 1 + 2 * moduli.k_a / moduli.k_s : 3;
}

// Whether a shape's surface keeps a quarter of what is inside when it moves inwards.
bool has_room(const surface::Shape& shape, double inwards) {
  try {
    (void)shape.mesh(4, -inwards / 0.75);
  } catch (const std::invalid_argument&) {
    return false;
  }
  return true;
}

bool is_sphere(const surface::Shape& shape) {
  return dynamic_cast<const surface::Sphere*>(&shape) != nullptr;
}

}  // namespace

double magic_of(const fluid::Options& fluid) {
  return fluid.collision == fluid::Collision::trt ? fluid.magic
                                                  : (fluid.tau - 0.5) * (fluid.tau - 0.5);
}

namespace {

// What flat surfaces take, of retraction and slip together.
const double flat = std::sqrt(second_moment / pi);

// In a fluid of magic 1/4: of a sphere whose radius is between the bounds.
double retraction_for_stresslet(double a, double slip) {
  double low = 0;
  double high = largest_retraction;
  while (high - low > 1e-9) {
    const double middle = (low + high) / 2;
    Matrix2d answer = mobility<2>(a - middle);
    answer(1, 1) += slip;
    (multipole<2>(answer, a - middle, a) > 1 ? low : high) = middle;
  }
  return high;
}

}  // namespace

double felt_retraction(const surface::Shape& shape, const fluid::Options& fluid, double slip) {
  const double rest = std::max(0.0, flat - slip);
  if (!is_sphere(shape)) {
    double retraction = rest + by_magic(fluid);
    while (!has_room(shape, retraction)) retraction *= 0.95;
    return retraction;
  }
  const double a = std::clamp(shape.radius(), least_radius, largest_radius);
  const double curved =
      rest + (retraction_for_stresslet(a, slip) - rest) * std::min(1.0, a / shape.radius());
  return std::min({curved + by_magic(fluid), largest_retraction, shape.radius() / 2});
}

FeltPlace felt_place(const surface::Shape& shape, const fluid::Options& fluid) {
  if (!is_sphere(shape)) return {felt_retraction(shape, fluid), 0};
  const double a = std::clamp(shape.radius(), least_radius, largest_of_octupole);
  // Of two places the one further inside: from without slip inwards the octupole's excess falls,
  // passes 0, and comes back to it.
  constexpr double step = 0.02;
  double high = retraction_for_stresslet(a, 0);
  double low = high - step;
  for (; octupole_excess(a - low, a) > 0; low -= step) high = low;
  while (high - low > 1e-6) {
    const double middle = (low + high) / 2;
    (octupole_excess(a - middle, a) > 0 ? high : low) = middle;
  }
  const double scale = std::min(1.0, a / shape.radius());
  return {std::min({high * scale + by_magic(fluid), largest_retraction, shape.radius() / 2}),
          flat - (flat - slip_for_stresslet(a - high, a)) * scale};
}

double felt_modulus_factor(const surface::Shape& shape, double retraction,
                           const membrane::Moduli& moduli, const fluid::Options& fluid) {
  if (retraction == 0 || moduli.k_s == 0 || !is_sphere(shape)) return 1;
  const double a = std::clamp(shape.radius(), least_radius, largest_radius);
  const double r = a - (retraction - by_magic(fluid));
  const double dilation = dilation_over_shear(moduli);
  const Vector2d f = holding_force(r);
  const double factor = r * r / (a * a) * yielding(f, dilation) / yielding({5, 2.5}, dilation);
  return 1 + (factor - 1) * std::min(1.0, a / shape.radius());
}

}  // namespace ductile::suspension
