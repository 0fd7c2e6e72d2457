#include "ductile/surface/biconcave.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <string>

namespace ductile::surface {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

// Eq. (18): the point s (x, y, z) of the unit sphere goes to a (1.2 x, 1.2 y, 0.6 P(u) z), with
// u = x^2 + y^2 and P the profile.
constexpr double width = 1.2;
constexpr double height = 0.6;
constexpr std::array<double, 3> profile_terms{0.207, 2, -1.123};

constexpr double profile(double u) {
  return profile_terms[0] + profile_terms[1] * u + profile_terms[2] * u * u;
}
constexpr double profile_slope(double u) {
  return profile_terms[1] + 2 * profile_terms[2] * u;
}

// Half the thickness on the axis, and the radius of curvature of the surface there, over a.
constexpr double half_thickness = height * profile(0);
constexpr double dimple = width * width / (2 * height * (profile_slope(0) - profile(0) / 2));

Mesh transformed(int frequency, double radius, double offset) {
  Mesh mesh = icosphere(frequency, radius);
  for (Vector3d& x : mesh.vertices) {
    const double r2 = (x[0] * x[0] + x[1] * x[1]) / (radius * radius);
    // Cross product of the tangents along the sphere's meridian and parallel: regular on the axis
    // and on the rim alike.
    const double slope =
        height * (profile(r2) - 2 * profile_slope(r2) * x[2] * x[2] / (radius * radius));
    const Vector3d normal(slope * x[0], slope * x[1], width * x[2]);
    x[0] *= width;
    x[1] *= width;
    x[2] *= height * profile(r2);
    if (offset != 0) x += offset * normal.normalized();
  }
  return mesh;
}

using Polynomial = std::array<double, 8>;

Polynomial operator*(const Polynomial& p, const std::array<double, 3>& q) {
  Polynomial product{};
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (std::size_t j = 0; j < q.size() && i + j < product.size(); ++j)
      product[i + j] += p[i] * q[j];
  }
  return product;
}

// The integral of p(u) (1 - u)^(alpha - 1) over u from 0 to 1: a sum of Beta functions, with
// B(1, alpha) = 1/alpha and B(n + 1, alpha) = B(n, alpha) n/(n + alpha).
double integral(const Polynomial& p, double alpha) {
  double sum = 0, beta = 1 / alpha;
  for (std::size_t n = 0; n < p.size(); ++n) {
    if (n > 0) beta *= static_cast<double>(n) / (static_cast<double>(n) + alpha);
    sum += p[n] * beta;
  }
  return sum;
}

// The integral of f over t from -1 to 1 by Fejer's first rule, which converges spectrally.
template <class F>
double integral(const F& f) {
  constexpr int n = 128;
  double sum = 0;
  for (int k = 0; k < n; ++k) {
    const double angle = (k + 0.5) * pi / n;
    double weight = 1;
    for (int j = 1; j <= n / 2; ++j) weight -= 2 * std::cos(2 * j * angle) / (4 * j * j - 1);
    sum += 2 * weight / n * f(std::cos(angle));
  }
  return sum;
}

// Volume elements: u = (rho/(1.2 a))^2, so that 2 pi rho drho = 1.44 pi a^2 du, between the heights
// -z and z, z = 0.6 a P(u) (1 - u)^(1/2).
constexpr Polynomial one{1};
constexpr std::array<double, 3> linear{0, 1, 0};

}  // namespace

Biconcave::Biconcave(double radius)
    : Shape(shape_name, radius, {transformed(16, radius, 0).vertices, 0}) {}

Mesh Biconcave::mesh(int frequency, double offset) const {
  if (!(offset > -half_thickness * radius() && offset < dimple * radius())) {
    throw std::invalid_argument("biconcave: offset " + std::to_string(offset) +
                                " must lie between " + std::to_string(-half_thickness * radius()) +
                                " and " + std::to_string(dimple * radius()));
  }
  return transformed(frequency, radius(), offset);
}

bool Biconcave::contains(const Vector3d& point) const {
  const Vector3d p = point / radius();
  const double r2 = (p.x() * p.x() + p.y() * p.y()) / (width * width);
  if (r2 >= 1) return false;
  return std::abs(p.z()) < height * profile(r2) * std::sqrt(1 - r2);
}

double Biconcave::volume() const {
  const double a = radius();
  return 2 * height * width * width * pi * a * a * a * integral(one * profile_terms, 1.5);
}

double Biconcave::area() const {
  // The meridian's length and the parallel's, over z of the unit sphere.
  const double a = radius();
  return 2 * pi * width * a * a * integral([](double z) {
           const double u = 1 - z * z;
           const double slope = height * (profile(u) - 2 * profile_slope(u) * z * z);
           return std::sqrt(width * width * z * z + u * slope * slope);
         });
}

Eigen::Matrix3d Biconcave::inertia() const {
  const double a = radius(), a5 = a * a * a * a * a, w2 = width * width;
  // The integrals of x^2 + y^2 and of z^2 over the volume.
  const double across =
      2 * height * w2 * w2 * pi * a5 * integral(one * profile_terms * linear, 1.5);
  const double along = 2.0 / 3 * height * height * height * w2 * pi * a5 *
                       integral(one * profile_terms * profile_terms * profile_terms, 2.5);
  return Vector3d(across / 2 + along, across / 2 + along, across).asDiagonal();
}

}  // namespace ductile::surface
