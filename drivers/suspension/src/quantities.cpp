#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

#include "ductile/suspension/sample.hpp"

namespace ductile::suspension {
namespace {

using enum Quantity::Of;

Eigen::Vector3d position(const Observation& o) {
  return o.units.position(o.centroid);
}
Eigen::Vector3d velocity(const Observation& o) {
  return o.units.velocity(o.displacement);
}

Eigen::Vector3d omega(const Observation& o) {
  return o.units.angular_velocity(o.angular_velocity);
}

// In degrees above -180, up to 180.
double degrees(double radians) {
  const double angle = radians * (180 / std::numbers::pi);
  return angle > -180 ? angle : 180;
}

// Of the longest axis of the second moments' block of x and z, from z towards x, above -90 and up
// to 90; 0 where the two axes are alike.
double inclination(const Observation& o) {
  const Eigen::Matrix3d& moments = o.moments.inertia;
  const double across = 2 * moments(0, 2);
  const double along = moments(2, 2) - moments(0, 0);
  const bool round = std::hypot(across, along) <= 1e-9 * (moments(2, 2) + moments(0, 0));
  return round ? 0 : degrees(std::atan2(across, along)) / 2;
}

double phase(const Observation& o) {
  const Eigen::Vector3d arm = o.marker - o.centroid;
  return degrees(std::atan2(arm.x(), arm.z()));
}

double tilt(const Observation& o) {
  return degrees(std::asin(std::min(1.0, std::abs(o.moments.shortest_axis().y()))));
}

const Eigen::Quaterniond& orientation(const Observation& o) {
  return o.rigid->state().orientation;
}
double force(const Observation& o, Eigen::Index axis) {
  return o.units.force(o.rigid->hydrodynamic_force()[axis]);
}
double torque(const Observation& o, Eigen::Index axis) {
  return o.units.torque(o.rigid->hydrodynamic_torque()[axis]);
}

const std::array table = {
    // Position and velocity come first: motion_quantities counts them.
    Quantity{"x", "W", every_body, [](const Observation& o) { return position(o).x(); }},
    Quantity{"y", "W", every_body, [](const Observation& o) { return position(o).y(); }},
    Quantity{"z", "W", every_body, [](const Observation& o) { return position(o).z(); }},
    Quantity{"vx", "nu/W", every_body, [](const Observation& o) { return velocity(o).x(); }},
    Quantity{"vy", "nu/W", every_body, [](const Observation& o) { return velocity(o).y(); }},
    Quantity{"vz", "nu/W", every_body, [](const Observation& o) { return velocity(o).z(); }},
    // Taylor's D.
    Quantity{"deformation", "1", capsules,
             [](const Observation& o) { return o.moments.taylor_deformation(); }},
    // (V - V0)/V0.
    Quantity{"volume_error", "1", capsules,
             [](const Observation& o) { return o.capsule->volume_error(); }},
    // Without stiffness there is neither strain energy nor a unit for it.
    Quantity{"strain_energy", "k_s*a^2", capsules,
             [](const Observation& o) {
               const double unit = o.plan.energy_unit();
               return unit > 0 ? o.capsule->energies().strain / unit : 0;
             }},
    Quantity{"slip", "nu/W", every_body,
             [](const Observation& o) { return o.units.velocity(o.slip); }},
    Quantity{"omega_x", "nu/W^2", every_body, [](const Observation& o) { return omega(o).x(); }},
    Quantity{"omega_y", "nu/W^2", every_body, [](const Observation& o) { return omega(o).y(); }},
    Quantity{"omega_z", "nu/W^2", every_body, [](const Observation& o) { return omega(o).z(); }},
    Quantity{"inclination", "deg", capsules, inclination},
    Quantity{"phase", "deg", capsules, phase},
    Quantity{"tilt", "deg", capsules, tilt},
    // Body frame to space frame.
    Quantity{"qw", "1", rigid_bodies, [](const Observation& o) { return orientation(o).w(); }},
    Quantity{"qx", "1", rigid_bodies, [](const Observation& o) { return orientation(o).x(); }},
    Quantity{"qy", "1", rigid_bodies, [](const Observation& o) { return orientation(o).y(); }},
    Quantity{"qz", "1", rigid_bodies, [](const Observation& o) { return orientation(o).z(); }},
    // Of the fluid on the solid in the latest step, see rigid::Body; 0 before the first.
    Quantity{"force_x", "rho*nu^2", rigid_bodies, [](const Observation& o) { return force(o, 0); }},
    Quantity{"force_y", "rho*nu^2", rigid_bodies, [](const Observation& o) { return force(o, 1); }},
    Quantity{"force_z", "rho*nu^2", rigid_bodies, [](const Observation& o) { return force(o, 2); }},
    Quantity{"torque_x", "rho*nu^2*W", rigid_bodies,
             [](const Observation& o) { return torque(o, 0); }},
    Quantity{"torque_y", "rho*nu^2*W", rigid_bodies,
             [](const Observation& o) { return torque(o, 1); }},
    Quantity{"torque_z", "rho*nu^2*W", rigid_bodies,
             [](const Observation& o) { return torque(o, 2); }},
};

std::size_t row_of(std::string_view name) {
  const auto* const row = std::ranges::find(table, name, &Quantity::name);
  if (row == table.end()) throw std::out_of_range("no quantity is called " + std::string(name));
  return static_cast<std::size_t>(row - table.begin());
}

}  // namespace

std::span<const Quantity> quantities() {
  return table;
}

double BodySample::operator[](std::string_view name) const {
  return values[row_of(name)];
}
double& BodySample::operator[](std::string_view name) {
  return values[row_of(name)];
}

BodySample sample(const Observation& body) {
  BodySample sample;
  sample.capsule = body.capsule != nullptr;
  for (std::size_t q = 0; q < table.size(); ++q) {
    if (table[q].applies(sample.capsule)) sample.values[q] = table[q].get(body);
  }
  return sample;
}

std::vector<double> distances_ahead(std::span<const double> z, double length) {
  std::vector<double> place;  // in the channel
  for (const double along : z) place.push_back(along - length * std::floor(along / length));
  std::vector<std::size_t> order(z.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t b) { return place[b]; });
  std::vector<double> distances(z.size());
  for (std::size_t n = 0; n < order.size(); ++n) {
    const bool last = n + 1 == order.size();
    const std::size_t next = order[last ? 0 : n + 1];
    distances[order[n]] = place[next] - place[order[n]] + (last ? length : 0);
  }
  return distances;
}

}  // namespace ductile::suspension
