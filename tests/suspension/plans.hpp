// Plans of suspensions, put together for tests.
#pragma once

#include <array>
#include <string>

#include "ductile/suspension/plan.hpp"

namespace ductile::test {

using suspension::BodyPlan;
using suspension::CapsulePlan;
using suspension::Plan;

/// A channel with walls half way, Re = 10.
inline Plan channel(std::array<int, 3> nodes) {
  Plan plan;
  plan.fluid.nodes = nodes;
  plan.fluid.boundary = {fluid::Boundary::halfway, fluid::Boundary::halfway,
                         fluid::Boundary::periodic};
  plan.fluid.tau = 0.9;
  plan.units = Plan::channel_units(plan.fluid);
  plan.drive(10);
  return plan;
}

/// Without a kind: a capsule of no stiffness.
inline BodyPlan body(const Plan& plan, const std::string& name, const std::string& shape,
                     const Eigen::Vector3d& at, double radius = 0.3) {
  BodyPlan body;
  body.name = name;
  body.shape = surface::make_shape(shape, plan.units.lattice_length(radius));
  body.frequency = surface::frequency_for_edge(body.shape->radius(), 1.2);
  body.centre = plan.units.lattice_position(at);
  return body;
}

/// The paper's membrane, of a body of radius 0.3.
inline CapsulePlan capsule(const Plan& plan, const membrane::Scheme& scheme, double laplace) {
  const double a = plan.units.lattice_length(0.3);
  CapsulePlan capsule;
  capsule.moduli.k_s = plan.units.lattice_shear_modulus(laplace, a);
  capsule.moduli.k_a = 2 * capsule.moduli.k_s;
  capsule.moduli.k_b = 2.87e-3 * capsule.moduli.k_s * a * a;
  capsule.moduli.k_v = 1;
  capsule.integrator = scheme;
  return capsule;
}

}  // namespace ductile::test
