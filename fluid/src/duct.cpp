#include "ductile/fluid/duct.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace ductile::fluid {
namespace {

constexpr int terms = 400;
constexpr double pi = std::numbers::pi;

// cosh(u)/cosh(v) and sinh(u)/cosh(v) for 0 <= u <= v, v possibly large
double cosh_ratio(double u, double v) {
  return std::exp(u - v) * (1 + std::exp(-2 * u)) / (1 + std::exp(-2 * v));
}
double sinh_ratio(double u, double v) {
  return std::exp(u - v) * (1 - std::exp(-2 * u)) / (1 + std::exp(-2 * v));
}

// Eq. (1) for a force/viscosity of 1 in |x| <= a, |y| <= b. The part of the series that does not
// depend on x is the parabola (b^2 - y^2)/2; what remains converges exponentially off the walls
// x = +-a. Value and gradient.
struct Flow {
  double u = 0;
  double du_dx = 0;
  double du_dy = 0;
};
Flow series(double x, double y, double a, double b) {
  Flow flow{(b * b - y * y) / 2, 0, -y};
  const double scale = 16 * b * b / (pi * pi * pi);
  double sign = 1;
  for (int n = 1; n < 2 * terms; n += 2, sign = -sign) {
    const double k = n * pi / (2 * b);
    const double c = sign * scale / (static_cast<double>(n) * n * n);
    const double ratio = cosh_ratio(k * std::abs(x), k * a);
    flow.u -= c * ratio * std::cos(k * y);
    flow.du_dx -= c * k * std::copysign(sinh_ratio(k * std::abs(x), k * a), x) * std::cos(k * y);
    flow.du_dy += c * k * ratio * std::sin(k * y);
    if (ratio < 1e-17) break;
  }
  return flow;
}

}  // namespace

DuctFlow::DuctFlow(std::array<double, 2> half_width, double force, double viscosity)
    : half_width_(half_width), scale_(force / viscosity) {
  if (!(half_width[0] > 0) || !(half_width[1] > 0)) {
    throw std::invalid_argument("duct: half-widths " + std::to_string(half_width[0]) + ", " +
                                std::to_string(half_width[1]) + " must be positive");
  }
  if (!(viscosity > 0)) {
    throw std::invalid_argument("duct: viscosity " + std::to_string(viscosity) +
                                " must be positive");
  }
}

double DuctFlow::velocity(double x, double y) const {
  const auto [a, b] = half_width_;
  if (std::abs(x) >= a || std::abs(y) >= b) return 0;
  return scale_ * (b <= a ? series(x, y, a, b).u : series(y, x, b, a).u);
}

Eigen::Vector2d DuctFlow::gradient(double x, double y) const {
  const auto [a, b] = half_width_;
  Flow flow;
  if (b <= a) {
    flow = series(x, y, a, b);
  } else {
    flow = series(y, x, b, a);
    std::swap(flow.du_dx, flow.du_dy);
  }
  return scale_ * Eigen::Vector2d(flow.du_dx, flow.du_dy);
}

double DuctFlow::mean() const {
  const double a = std::max(half_width_[0], half_width_[1]);
  const double b = std::min(half_width_[0], half_width_[1]);
  double sum = 0;
  for (int n = 1; n < 2 * terms; n += 2) {
    sum += std::tanh(n * pi * a / (2 * b)) / std::pow(static_cast<double>(n), 5);
  }
  return scale_ * b * b / 3 * (1 - 192 * b / (std::pow(pi, 5) * a) * sum);
}

}  // namespace ductile::fluid
