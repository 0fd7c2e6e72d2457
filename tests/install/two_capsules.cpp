// Two soft capsules in a square channel, coupled through the installed ductile::suspension: a
// driver of one's own. Build it as CMakeLists.txt beside it does; run it alone or under mpirun.
#include <petscsys.h>

#include <cmath>
#include <cstdio>

#include "ductile/suspension/suspension.hpp"

namespace {

using namespace ductile;

// A plan says all in lattice units: dx = dt = rho0 = 1. Units turns the paper's numbers into them,
// lengths in W (half the channel's width), times in W^2/nu, velocities in nu/W.
suspension::Plan plan() {
  suspension::Plan plan;
  plan.fluid.nodes = {24, 24, 72};  // across, across, along: 2 W x 2 W x 6 W
  const auto wall = fluid::Boundary::halfway;
  plan.fluid.boundary = {wall, wall, fluid::Boundary::periodic};
  plan.fluid.tau = 1;
  plan.units = suspension::Plan::channel_units(plan.fluid);
  plan.drive(10);  // Re = 2 W U_max/nu

  // Skalak membranes of La = k_s a/(rho nu^2) = 10 and radius .4 W, on either side of the axis.
  // Each advances by the scheme named here; a class of your own goes in as
  // membrane::scheme<Own>("own").
  const double a = plan.units.lattice_length(0.4);
  suspension::CapsulePlan capsule;
  capsule.moduli.k_s = plan.units.lattice_shear_modulus(10, a);
  capsule.moduli.k_a = 2 * capsule.moduli.k_s;
  capsule.moduli.k_b = 2.87e-3 * capsule.moduli.k_s * a * a;
  capsule.moduli.k_v = 1.5;
  capsule.integrator = membrane::find_scheme("explicit-euler");
  for (const double side : {1, -1}) {
    suspension::BodyPlan body;
    body.name = side > 0 ? "lead" : "lag";
    body.shape = surface::make_shape("sphere", a);
    body.frequency = surface::frequency_for_edge(a, 1.2);
    body.centre = plan.units.lattice_position({0.2 * side, 0, 0.5 * side});
    body.kind = capsule;
    plan.bodies.push_back(body);
  }
  return plan;
}

// The loop is yours: the library takes steps and tells on request how things are.
int run() {
  suspension::Suspension pair(plan(), PETSC_COMM_WORLD);
  bool good = true;
  for (const double stop : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    while (pair.time() < stop) pair.step();
    const suspension::Sample now = pair.sample();  // every rank calls, rank 0 gets it
    if (pair.rank() != 0) continue;
    const auto &lead = now.bodies[0], &lag = now.bodies[1];
    std::printf("t = %.2f  x = %.4f, %.4f  dz = %.4f  deformation %.4f\n", now.time, lead["x"],
                lag["x"], axial_distance(now), lead["deformation"]);
    // Soft capsules leave the walls for the axis, keep their volume, and mirror each other.
    good = good && std::abs(lead["x"] + lag["x"]) < 0.01 && std::abs(lead["volume_error"]) < 0.01 &&
           (now.time == 0 || lead["x"] < 0.2);
  }
  return good ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) return 1;
  int code = 1;
  try {
    code = run();
  } catch (const std::exception& error) {  // coupling::BodyFailure: which body, step and why
    std::fprintf(stderr, "%s\n", error.what());
  }
  return PetscFinalize() == 0 ? code : 1;
}
