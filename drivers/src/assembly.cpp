#include "assembly.hpp"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <utility>

#include "ductile/fluid/duct.hpp"

namespace ductile::drivers {

fluid::Fluid make_fluid(const Scenario& scenario, const LatticeSetup& setup, MPI_Comm comm) {
  const bool plates = !scenario.channel.side_walls;
  fluid::Options options;
  options.nodes = setup.nodes;
  options.boundary = {scenario.channel.walls,
                      plates ? fluid::Boundary::periodic : scenario.channel.walls,
                      fluid::Boundary::periodic};
  options.mirror = setup.mirror;
  options.wall_velocity[0] = {Eigen::Vector3d(0, 0, setup.wall_velocity[0]),
                              Eigen::Vector3d(0, 0, setup.wall_velocity[1])};
  options.tau = setup.tau;
  options.collision = scenario.fluid.collision;
  options.magic = scenario.fluid.magic;
  options.force = {0, 0, setup.alpha};
  options.storage = scenario.fluid.storage;
  fluid::Fluid fluid(comm, options);
  if (scenario.channel.start == Start::rest) return fluid;

  const double w = setup.half_width;
  const fluid::DuctFlow duct({w, setup.half_width_y}, setup.alpha, setup.nu);
  const Eigen::Vector3d axis = setup.origin();
  // The same for a whole column of nodes, which initialise() visits one after the other.
  std::array<int, 2> column = {-1, -1};
  fluid::NodeState state;
  fluid.initialise([&](int i, int j, int /*k*/) {
    if (column == std::array<int, 2>{i, j}) return state;
    column = {i, j};
    state = {};
    const double x = i - axis.x();
    const double y = j - axis.y();
    if (plates) {
      const double shear = (setup.wall_velocity[1] - setup.wall_velocity[0]) / (2 * w);
      state.velocity.z() = setup.alpha / (2 * setup.nu) * (w * w - x * x) +
                           0.5 * (setup.wall_velocity[0] + setup.wall_velocity[1]) + shear * x;
      state.gradient(0, 2) = -setup.alpha / setup.nu * x + shear;
    } else if (std::abs(x) < w && std::abs(y) < setup.half_width_y) {
      state.velocity.z() = duct.velocity(x, y);
      const Eigen::Vector2d gradient = duct.gradient(x, y);
      state.gradient(0, 2) = gradient.x();
      state.gradient(1, 2) = gradient.y();
    }
    return state;
  });
  return fluid;
}

Assembly::Assembly(const Scenario& scenario, const LatticeSetup& setup, MPI_Comm comm)
    : fluid_(make_fluid(scenario, setup, comm)) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks_);
  std::vector<coupling::Member> members;
  for (std::size_t b = 0; b < scenario.bodies.size(); ++b) {
    if (owner(b) != rank) continue;
    bodies_.push_back({b, make_body(scenario, setup, b)});
    members.push_back({static_cast<int>(b), &bodies_.back().body->markers()});
  }
  coupler_.emplace(fluid_, std::move(members), static_cast<int>(scenario.bodies.size()));
}

const ImmersedBody* Assembly::own(std::size_t body) const {
  for (const Owned& owned : bodies_) {
    if (owned.index == body) return owned.body.get();
  }
  return nullptr;
}

}  // namespace ductile::drivers
