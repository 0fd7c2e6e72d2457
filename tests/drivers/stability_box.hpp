// Real runs of a capsule in a small box, to find whether an integrator is stable.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/stability.hpp"
#include "ductile/coupling/coupler.hpp"
#include "ductile/fluid/fluid.hpp"
#include "ductile/membrane/capsule.hpp"
#include "ductile/surface/biconcave.hpp"
#include "ductile/surface/mesh.hpp"
#include "ductile/surface/shape.hpp"
#include "ductile/suspension/markers.hpp"

namespace ductile::test {

inline surface::Mesh rest_shape(const drivers::StabilityProblem& p) {
  return surface::make_shape(p.shape, p.radius)->mesh(p.frequency);
}

/// Whether a capsule with `scale` times the problem's moduli fails: one that drifts with a uniform
/// flow, its vertices off by 1e-5 at random. It fails if the elastic energy of the disturbance
/// grows a millionfold, or doubles in the second half of the run and is not down to round-off.
inline bool fails_in_box(const drivers::StabilityProblem& p, const membrane::Scheme& scheme,
                         double scale, int steps) {
  const surface::Mesh reference = rest_shape(p);
  double reach = 0;
  for (const Eigen::Vector3d& v : reference.vertices) reach = std::max(reach, v.norm());
  const int nodes = static_cast<int>(std::ceil(2 * reach)) + 10;

  fluid::Options options;
  options.nodes = {nodes, nodes, nodes};
  options.tau = p.tau;
  options.collision = p.collision;
  options.magic = p.magic;
  fluid::Fluid fluid(MPI_COMM_SELF, options);
  // The mesh meets the lattice anew all the time, as in a channel.
  fluid::NodeState drift;
  drift.velocity = {0, 0, 0.047};
  fluid.initialise([&](int, int, int) { return drift; });

  surface::Mesh mesh = reference;
  surface::place(mesh, p.rotation, Eigen::Vector3d(-0.3, -0.6, -0.2).array() + nodes / 2.0);
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  for (Eigen::Vector3d& v : mesh.vertices) {
    for (double& x : v) x += 1e-5 * normal(generator);
  }
  membrane::Moduli moduli = p.moduli;
  for (double* k : {&moduli.k_s, &moduli.k_a, &moduli.k_b, &moduli.k_v}) *k *= scale;
  membrane::CapsuleOptions capsule_options;
  capsule_options.mobility = p.mobility;
  capsule_options.viscosity = fluid.viscosity();
  capsule_options.integrator = membrane::make_integrator(scheme);
  membrane::Capsule capsule(reference, mesh.vertices, moduli, capsule_options);
  suspension::CapsuleMarkers markers(capsule);
  coupling::Coupler coupler(fluid, {{0, &markers}}, 1);

  // The elastic energy of a mode that swings passes through zero: the largest of a few swings
  // counts.
  constexpr int window = 25;
  const double start = capsule.energies().total();
  double half_way = 0;
  double end = 0;
  try {
    for (int n = 1; n <= steps; ++n) {
      coupler.step();
      const double energy = capsule.energies().total();
      if (energy > 1e6 * start) return true;
      if (std::abs(n - steps / 2) < window) half_way = std::max(half_way, energy);
      if (n > steps - window) end = std::max(end, energy);
    }
  } catch (const coupling::BodyFailure&) {
    return true;
  }
  return end > std::max(2 * half_way, 1e-5 * start);
}

}  // namespace ductile::test
