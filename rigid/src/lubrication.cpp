#include "ductile/rigid/lubrication.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace ductile::rigid {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

// Fluid that a surface moves with it within a step, per area: 1/lambda, see Body::Body().
constexpr double layer = 2.6;
// A step's velocity per force over that of the layer: 0.91 to 1.48 (a = 3.5 to 12, tau = 0.6 and
// 1, density ratios 0.7 to 3, two and five corrections).
constexpr double largest_response = 1.5;
// Of an overlap, what a step takes back: more would throw spheres apart that start too near.
constexpr double recovery = 0.1;
constexpr int most_sweeps = 200;

double height(const Lubrication::Sphere& sphere) {
  return sphere.roughness * sphere.radius;
}

template <class... Parts>
[[noreturn]] void reject(const Parts&... parts) {
  std::ostringstream message;
  message << "lubrication: ";
  (message << ... << parts);
  throw std::invalid_argument(message.str());
}

}  // namespace

namespace {

// L of (1).
double weak(double gap) {
  return gap < shear_reach ? std::log(shear_reach / gap) - 1 + gap / shear_reach : 0;
}

}  // namespace

double film_resistance(double a, double b, double gap, double viscosity) {
  if (gap >= film_reach) return 0;
  const double c = film_reach;
  const double beta = b / a;
  const double cube = std::pow(1 + beta, 3);
  const double logarithm = std::log(c / gap);
  const double singular = 1 / gap - 1 / c - 2 / c * logarithm + (c - gap) / (c * c);
  return 6 * pi * viscosity * a *
         (2 * beta * beta / cube * (a + b) / 2 * singular +
          beta * (1 + 7 * beta + beta * beta) / (5 * cube) * weak(gap));
}

double film_mobility(const Surface& surface, const Solid& solid, double density_ratio) {
  double area = 0;
  for (const double a : surface.areas) area += a;
  return largest_response / (layer * area + (density_ratio - 1) * solid.volume);
}

Lubrication::Lubrication(std::vector<Sphere> spheres, double viscosity,
                         std::array<double, 2> periods)
    : spheres_(std::move(spheres)),
      viscosity_(viscosity),
      periods_(periods),
      before_(spheres_.size(), Vector3d::Zero()),
      squeezing_(spheres_.size(), Vector3d::Zero()),
      forces_(spheres_.size()) {
  for (const Sphere& sphere : spheres_) {
    if (!(sphere.radius > 0) || !std::isfinite(sphere.radius))
      reject("radius = ", sphere.radius, ": it must be positive");
    if (!(sphere.roughness > 0) || !std::isfinite(sphere.roughness))
      reject("roughness = ", sphere.roughness, ": it must be positive");
    if (!(sphere.mobility >= 0) || !std::isfinite(sphere.mobility))
      reject("mobility = ", sphere.mobility, ": it must be finite and not negative");
  }
  if (!(viscosity > 0) || !std::isfinite(viscosity))
    reject("viscosity = ", viscosity, ": it must be positive");
  for (const double period : periods) {
    if (!(period >= 0) || !std::isfinite(period))
      reject("period = ", period, ": it must be positive, or 0 for none");
  }
}

void Lubrication::find_films(std::span<const SphereMotion> motions) {
  films_.clear();
  for (std::size_t a = 0; a < spheres_.size(); ++a) {
    for (std::size_t b = a + 1; b < spheres_.size(); ++b) {
      const Vector3d apart = motions[a].position - motions[b].position;
      const double radii = spheres_[a].radius + spheres_[b].radius;
      // Images of b that may be near a, by y and by z.
      std::array<std::vector<double>, 2> shifts{std::vector<double>{0}, {0}};
      for (std::size_t k = 0; k < 2; ++k) {
        const double period = periods_[k];
        if (period == 0) continue;
        const double distance = apart[static_cast<int>(k) + 1];
        shifts[k].clear();
        const auto last = std::floor((distance + radii + film_reach) / period);
        for (double n = std::ceil((distance - radii - film_reach) / period); n <= last; ++n)
          shifts[k].push_back(n * period);
      }
      for (const double y : shifts[0]) {
        for (const double z : shifts[1]) {
          const Vector3d line = apart - Vector3d(0, y, z);
          const double distance = line.norm();
          const double gap = distance - radii;
          if (!(gap < film_reach) || distance == 0) continue;
          const double least = (height(spheres_[a]) + height(spheres_[b])) / 2;
          films_.push_back({a, b, line / distance, gap - least,
                            film_resistance(spheres_[a].radius, spheres_[b].radius,
                                            std::max(gap, least), viscosity_),
                            weak(std::max(gap, least))});
        }
      }
    }
  }
}

// Given the velocity with which the two would approach each other without this film.
double Lubrication::force_of(const Film& film, double approach) const {
  const double mobility = spheres_[film.a].mobility + spheres_[film.b].mobility;
  const double force = film.resistance * approach / (1 + film.resistance * mobility);
  // Where they touch, at a gap of 0 by its measure here.
  const double allowed = film.gap > 0 ? film.gap : recovery * film.gap;
  if (mobility == 0 || approach - mobility * force <= allowed) return force;
  return (approach - allowed) / mobility;
}

// squeezing_ <- (1), with velocities at the end of the step.
void Lubrication::squeeze(std::span<const SphereMotion> motions) {
  const std::size_t n = spheres_.size();
  free_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    free_[i] = motions[i].velocity;
    if (started_ != 0 && spheres_[i].mobility > 0)
      free_[i] += motions[i].velocity - before_[i] - spheres_[i].mobility * squeezing_[i];
    before_[i] = motions[i].velocity;
  }
  started_ = 1;
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    double change = 0;
    double largest = 0;
    for (Film& film : films_) {
      const double mobility = spheres_[film.a].mobility + spheres_[film.b].mobility;
      const double approach =
          film.normal.dot(free_[film.b] - free_[film.a]) + mobility * film.force;
      const double force = force_of(film, approach);
      const Vector3d more = (force - film.force) * film.normal;
      free_[film.a] += spheres_[film.a].mobility * more;
      free_[film.b] -= spheres_[film.b].mobility * more;
      change = std::max(change, std::abs(force - film.force));
      largest = std::max(largest, std::abs(force));
      film.force = force;
    }
    if (change <= 1e-12 * largest) break;
  }
  std::ranges::fill(squeezing_, Vector3d::Zero());
  for (const Film& film : films_) {
    squeezing_[film.a] += film.force * film.normal;
    squeezing_[film.b] -= film.force * film.normal;
  }
}

// forces_ += (2).
void Lubrication::shear(std::span<const SphereMotion> motions) {
  for (const Film& film : films_) {
    const double a = spheres_[film.a].radius;
    const double b = spheres_[film.b].radius;
    const Vector3d& n = film.normal;
    const auto along = [&n](const Vector3d& v) -> Vector3d { return v - n.dot(v) * n; };
    const Vector3d u = along(motions[film.a].velocity - motions[film.b].velocity);
    const Vector3d omega_a = along(motions[film.a].angular_velocity);
    const Vector3d omega_b = along(motions[film.b].angular_velocity);
    const double size = pi * viscosity_ * film.shear;
    const double sum = a + b;
    const double A = size * 8 * a * b * (2 * a * a + a * b + 2 * b * b) / (5 * sum * sum * sum);
    const double B_a = size * 4 * a * a * b * (4 * a + b) / (5 * sum * sum);
    const double B_b = size * 4 * b * b * a * (4 * b + a) / (5 * sum * sum);
    const double C_aa = size * 16 * a * a * a * b / (5 * sum);
    const double C_bb = size * 16 * b * b * b * a / (5 * sum);
    const double C_ab = size * 4 * a * a * b * b / (5 * sum);
    const Vector3d force = -A * u + (B_a * omega_a + B_b * omega_b).cross(n);
    forces_[film.a].force += force;
    forces_[film.b].force -= force;
    forces_[film.a].torque += B_a * n.cross(u) - C_aa * omega_a - C_ab * omega_b;
    forces_[film.b].torque += B_b * n.cross(u) - C_bb * omega_b - C_ab * omega_a;
  }
}

std::span<const FilmForce> Lubrication::forces(std::span<const SphereMotion> motions) {
  if (motions.size() != spheres_.size())
    reject(motions.size(), " motions for ", spheres_.size(), " spheres");
  find_films(motions);
  squeeze(motions);
  for (std::size_t i = 0; i < forces_.size(); ++i) forces_[i] = {squeezing_[i], Vector3d::Zero()};
  shear(motions);
  return forces_;
}

template <class Self, class Io>
void Lubrication::transfer_parts(Self& self, const Io& io) {
  const auto transfer = [&](std::string_view name, auto& vectors) {
    if (!vectors.empty()) io(name, {vectors.data()->data(), 3 * vectors.size()});
  };
  io("started", {&self.started_, 1});
  transfer("velocities", self.before_);
  transfer("forces", self.squeezing_);
}

void Lubrication::save(const StateWriter& write) const {
  transfer_parts(*this, write);
}

void Lubrication::load(const StateReader& read) {
  Lubrication loaded(*this);
  transfer_parts(loaded, read);
  *this = std::move(loaded);
}

}  // namespace ductile::rigid
