#include "ductile/suspension/plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>

#include "ductile/fluid/duct.hpp"
#include "ductile/surface/sphere.hpp"

namespace ductile::suspension {

double half_width(int nodes, fluid::Boundary walls) {
  return walls == fluid::Boundary::regularized ? (nodes - 1) / 2.0 : nodes / 2.0;
}

double poiseuille_coefficient(double half_width_y, bool side_walls) {
  return side_walls ? fluid::DuctFlow({1.0, half_width_y}, 1.0, 1.0).maximum() : 0.5;
}

Units Plan::channel_units(const fluid::Options& fluid) {
  double y = (fluid.nodes[1] - 1) / 2.0;
  if (fluid.mirror == fluid::Mirror::between_nodes) y = -0.5;
  if (fluid.mirror == fluid::Mirror::on_node) y = 0;
  return {suspension::half_width(fluid.nodes[0], fluid.boundary[0]),
          lattice_viscosity(fluid.tau),
          {(fluid.nodes[0] - 1) / 2.0, y, fluid.nodes[2] / 2.0}};
}

void Plan::drive(double reynolds) {
  const double W = units.half_width();
  const double nu = units.viscosity();
  u_max = units.lattice_velocity(reynolds / 2);
  const double alpha =
      u_max * nu / (poiseuille_coefficient(half_width_y() / W, side_walls()) * W * W);
  fluid.force = {0, 0, alpha};
}

void Plan::ride(double velocity) {
  // By way of the velocity at rest, which then comes back to the last bit.
  const auto ride = [&](double& wall) { wall = wall + fluid.lattice_velocity - velocity; };
  for (std::size_t side = 0; side < 2; ++side) {
    ride(fluid.wall_velocity[0][side].z());
    if (side_walls() && (side == 1 || fluid.mirror == fluid::Mirror::none))
      ride(fluid.wall_velocity[1][side].z());
  }
  fluid.lattice_velocity = velocity;
}

void Plan::check() const {
  const auto refuse = [](const std::string& what) { throw std::invalid_argument("plan: " + what); };
  if (units.viscosity() != lattice_viscosity(fluid.tau)) {
    refuse("the units have the viscosity " + std::to_string(units.viscosity()) +
           ", the fluid of tau = " + std::to_string(fluid.tau) + " has " +
           std::to_string(lattice_viscosity(fluid.tau)) +
           ": make units by channel_units() once the fluid is final");
  }
  const auto [low, high] = wall_velocity();
  if (start == Start::developed && (fluid.boundary[0] == fluid::Boundary::periodic ||
                                    fluid.boundary[2] != fluid::Boundary::periodic ||
                                    (side_walls() && (low != 0 || high != 0)))) {
    refuse(
        "no developed flow is known but along z between walls across x that do not move, or "
        "plates: start at rest");
  }
  std::set<std::string> names;
  for (const BodyPlan& body : bodies) {
    if (body.name.empty() || !names.insert(body.name).second)
      refuse("body name '" + body.name + "' is empty or taken: give each body its own");
    if (!body.shape) refuse("body " + body.name + " has no shape");
    const bool off_plane = std::abs(body.centre.y() - units.origin().y()) > 1e-9;
    if (fluid.mirror != fluid::Mirror::none && has_films(body) && off_plane) {
      refuse("body " + body.name +
             ", a sphere with slip, is not on the mirror plane, and has no film with its image: "
             "take away the slip, or the mirror");
    }
  }
}

double Plan::half_width_y() const {
  int nodes = fluid.nodes[1];
  if (fluid.mirror == fluid::Mirror::between_nodes) nodes = 2 * nodes;
  if (fluid.mirror == fluid::Mirror::on_node) nodes = 2 * nodes - 1;
  return half_width(nodes, fluid.boundary[1]);
}

std::int64_t Plan::node_count() const {
  return static_cast<std::int64_t>(fluid.nodes[0]) * fluid.nodes[1] * fluid.nodes[2];
}

double Plan::mach(double lattice_velocity) const {
  const auto [low, high] = wall_velocity();
  double fastest = 0;
  for (const double u : {0.0, u_max, low, high})
    fastest = std::max(fastest, std::abs(u - lattice_velocity));
  return std::sqrt(3.0) * fastest;
}

InitialFlow::InitialFlow(const Plan& plan)
    : half_width_{plan.units.half_width(), plan.half_width_y()},
      axis_(plan.units.origin()),
      force_over_viscosity_(plan.fluid.force.z() / plan.units.viscosity()),
      wall_velocity_(plan.wall_velocity()),
      side_walls_(plan.side_walls()) {
  if (plan.start == Start::developed)
    duct_.emplace(half_width_, plan.fluid.force.z(), plan.units.viscosity());
}

fluid::NodeState InitialFlow::at(double x, double y) const {
  fluid::NodeState state;
  if (!duct_) return state;
  const auto [w, half_width_y] = half_width_;
  x -= axis_.x();
  y -= axis_.y();
  if (!side_walls_) {
    const double shear = (wall_velocity_[1] - wall_velocity_[0]) / (2 * w);
    state.velocity.z() = force_over_viscosity_ / 2 * (w * w - x * x) +
                         0.5 * (wall_velocity_[0] + wall_velocity_[1]) + shear * x;
    state.gradient(0, 2) = -force_over_viscosity_ * x + shear;
  } else if (std::abs(x) < w && std::abs(y) < half_width_y) {
    state.velocity.z() = duct_->velocity(x, y);
    const Eigen::Vector2d gradient = duct_->gradient(x, y);
    state.gradient(0, 2) = gradient.x();
    state.gradient(1, 2) = gradient.y();
  }
  return state;
}

bool has_films(const BodyPlan& body) {
  const RigidPlan* kind = body.rigid();
  return kind != nullptr && kind->slip > 0 && kind->density_ratio >= 1 &&
         dynamic_cast<const surface::Sphere*>(body.shape.get()) != nullptr;
}

std::vector<int> owners(const Plan& plan, int ranks) {
  const std::size_t count = plan.bodies.size();
  const auto place = [&](std::size_t body) {
    const double z = plan.bodies[body].centre.z() / plan.length();
    return z - std::floor(z);
  };
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, place);
  std::vector<int> owners(count);
  for (std::size_t k = 0; k < count; ++k) {
    // Where the k-th would be if they were equally far apart.
    owners[order[k]] =
        static_cast<int>((2 * k + 1) * static_cast<std::size_t>(ranks) / (2 * count));
  }
  return owners;
}

fluid::Fluid make_fluid(const Plan& plan, MPI_Comm comm) {
  fluid::Fluid fluid(comm, plan.fluid);
  if (plan.start == Start::rest && plan.fluid.lattice_velocity == 0) return fluid;
  const InitialFlow flow(plan);
  // The same for a whole column of nodes, which initialise() visits one after the other.
  std::array<int, 2> column = {-1, -1};
  fluid::NodeState state;
  fluid.initialise([&](int i, int j, int /*k*/) {
    if (column == std::array<int, 2>{i, j}) return state;
    column = {i, j};
    state = flow.at(i, j);
    state.velocity.z() -= plan.fluid.lattice_velocity;
    return state;
  });
  return fluid;
}

}  // namespace ductile::suspension
