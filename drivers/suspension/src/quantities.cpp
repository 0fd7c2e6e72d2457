#include <algorithm>
#include <array>
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
             [](const Observation& o) {
               return o.moments.volume / o.capsule->shell().reference_volume() - 1;
             }},
    // Without stiffness there is neither strain energy nor a unit for it.
    Quantity{"strain_energy", "k_s*a^2", capsules,
             [](const Observation& o) {
               const double unit = o.plan.energy_unit();
               return unit > 0 ? o.capsule->energies().strain / unit : 0;
             }},
    Quantity{"slip", "nu/W", every_body,
             [](const Observation& o) { return o.units.velocity(o.slip); }},
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

}  // namespace ductile::suspension
