#include "ductile/rigid/lubrication.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "reject.hpp"

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
// Long trains in contact take about as many as the square of their number.
constexpr int most_sweeps = 1000;
constexpr double converged = 1e-9;

double height(const Lubrication::Sphere& sphere) {
  return sphere.roughness * sphere.radius;
}

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

double film_mobility(double area, double excess_mass) {
  return largest_response / (layer * area + excess_mass);
}

Lubrication::Lubrication(std::vector<Sphere> spheres, double viscosity,
                         std::array<double, 2> periods)
    : spheres_(std::move(spheres)),
      viscosity_(viscosity),
      periods_(periods),
      before_(spheres_.size(), Vector3d::Zero()),
      squeezed_(before_),
      velocity_(before_),
      squeezing_(before_),
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

// Films between two spheres whose centres are `apart`, from b to a, and across y's periodic end.
void Lubrication::add_films(std::size_t a, std::size_t b, const Vector3d& apart) {
  const double radii = spheres_[a].radius + spheres_[b].radius;
  const double reach = radii + film_reach;
  const double period = periods_[0];
  const int first = period == 0 ? 0 : static_cast<int>(std::ceil((apart.y() - reach) / period));
  const int last = period == 0 ? 0 : static_cast<int>(std::floor((apart.y() + reach) / period));
  for (int image = first; image <= last; ++image) {
    const Vector3d line = apart - Vector3d(0, image * period, 0);
    const double distance = line.norm();
    if (!(distance < reach) || distance == 0) continue;
    const double least = (height(spheres_[a]) + height(spheres_[b])) / 2;
    const double gap = std::max(distance - radii, least);
    films_.push_back({a, b, line / distance, distance - radii - least,
                      film_resistance(spheres_[a].radius, spheres_[b].radius, gap, viscosity_),
                      weak(gap)});
  }
}

// Looks along z, where a sphere has only those within reach after it; z comes round again.
void Lubrication::find_films(std::span<const SphereMotion> motions) {
  films_.clear();
  const std::size_t n = spheres_.size();
  const double period = periods_[1];
  double largest = 0;
  std::vector<double> place;
  place.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    largest = std::max(largest, spheres_[i].radius);
    const double z = motions[i].position.z();
    place.push_back(period == 0 ? z : z - period * std::floor(z / period));
  }
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&place](std::size_t i) { return place[i]; });
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t b = order[k];
    for (std::size_t next = k + 1; next < (period == 0 ? n : k + n); ++next) {
      const std::size_t a = order[next % n];
      const double ahead = place[a] + (next < n ? 0 : period) - place[b];
      if (ahead > 2 * largest + film_reach) break;
      Vector3d apart = motions[a].position - motions[b].position;
      apart.z() = ahead;
      add_films(a, b, apart);
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
      free_[i] += motions[i].velocity - before_[i] - spheres_[i].mobility * squeezed_[i];
    velocity_[i] = motions[i].velocity;
  }
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
    if (change <= converged * largest) break;
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

void Lubrication::accept() {
  std::swap(before_, velocity_);
  std::swap(squeezed_, squeezing_);
  started_ = 1;
}

template <class Self, class Io>
void Lubrication::transfer_parts(Self& self, const Io& io) {
  const auto transfer = [&](std::string_view name, auto& vectors) {
    if (!vectors.empty()) io(name, {vectors.data()->data(), 3 * vectors.size()});
  };
  io("started", {&self.started_, 1});
  transfer("velocities", self.before_);
  transfer("forces", self.squeezed_);
}

void Lubrication::save(const StateWriter& write) const {
  transfer_parts(*this, write);
}

void Lubrication::load(const StateReader& read) {
  Lubrication loaded(*this);
  transfer_parts(loaded, read);
  const auto finite = [](const Vector3d& v) { return v.allFinite(); };
  if (!std::isfinite(loaded.started_) || !std::ranges::all_of(loaded.before_, finite) ||
      !std::ranges::all_of(loaded.squeezed_, finite))
    reject("velocities and forces of the step before must be finite");
  *this = std::move(loaded);
}

}  // namespace ductile::rigid
