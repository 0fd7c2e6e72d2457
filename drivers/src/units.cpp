#include "units.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "ductile/fluid/duct.hpp"
#include "ductile/surface/mesh.hpp"
#include "errors.hpp"

namespace ductile::drivers {
namespace {

constexpr double largest_mach = 0.3;
constexpr double sound_volume_modulus = 1.5;  // lattice units

BodySetup body_setup(const BodyOptions& body, const LatticeSetup& lattice) {
  BodySetup setup;
  setup.radius = body.radius * lattice.half_width;
  setup.centre = lattice.to_lattice({body.x, body.y, body.z});
  setup.rotation = Eigen::AngleAxisd(body.rotation_angle * M_PI / 180,
                                     Eigen::Vector3d(body.rotation_axis.data()).normalized())
                       .toRotationMatrix();
  const bool capsule = body.kind == BodyKind::capsule;
  const int frequency = capsule ? body.membrane.frequency : body.rigid.frequency;
  const double edge = capsule ? body.membrane.edge : body.rigid.edge;
  // One that cannot fit is refused later, without the cost of its mesh.
  const double meshed = std::min(setup.radius, lattice.half_width);
  setup.frequency = frequency > 0 ? frequency : surface::frequency_for_edge(meshed, edge);
  if (!capsule) return setup;
  const double nu = lattice.nu;
  const double W = lattice.half_width;
  setup.moduli.law = body.membrane.law;
  setup.moduli.k_s = body.laplace * nu * nu / setup.radius;  // eq. (19)
  setup.moduli.k_a = body.membrane.area_ratio * setup.moduli.k_s;
  setup.moduli.k_b = body.membrane.bending * setup.moduli.k_s * setup.radius * setup.radius;
  setup.moduli.k_v = body.membrane.volume_modulus * nu * nu / (W * W);
  return setup;
}

}  // namespace

double half_width(int nodes, fluid::Boundary walls) {
  return walls == fluid::Boundary::regularized ? (nodes - 1) / 2.0 : nodes / 2.0;
}

double poiseuille_coefficient(double half_width_y, bool side_walls) {
  return side_walls ? fluid::DuctFlow({1.0, half_width_y}, 1.0, 1.0).maximum() : 0.5;
}

double default_volume_modulus(double half_width, double nu) {
  const double sound = sound_volume_modulus * half_width * half_width / (nu * nu);
  if (sound >= paper_volume_modulus) return paper_volume_modulus;
  const double unit = std::pow(10.0, std::floor(std::log10(sound)) - 2);
  return std::floor(sound / unit) * unit;
}

LatticeSetup lattice_setup(const Scenario& scenario) {
  const ChannelOptions& channel = scenario.channel;
  LatticeSetup s;
  const double W = half_width(channel.nodes, channel.walls);
  s.half_width = W;
  const bool on_nodes = channel.walls == fluid::Boundary::regularized && channel.side_walls;
  const int width_y = static_cast<int>(std::lround(2 * W * channel.half_width_y));
  const int nz = static_cast<int>(std::lround(channel.length * W));
  s.nodes = {channel.nodes, width_y + (on_nodes ? 1 : 0), nz};
  if (channel.symmetry == Symmetry::y) {
    s.mirror = s.nodes[1] % 2 == 0 ? fluid::Mirror::between_nodes : fluid::Mirror::on_node;
    s.nodes[1] = (s.nodes[1] + 1) / 2;
  }
  s.half_width_y = width_y / 2.0;
  s.length = nz;
  s.tau = scenario.fluid.tau;
  s.nu = (s.tau - 0.5) / 3;
  const double velocity_unit = s.nu / W;
  s.u_max = channel.reynolds / 2 * velocity_unit;
  s.alpha =
      s.u_max * s.nu / (poiseuille_coefficient(s.half_width_y / W, channel.side_walls) * W * W);
  s.wall_velocity = {channel.wall_velocity[0] * velocity_unit,
                     channel.wall_velocity[1] * velocity_unit};
  s.gravity = Eigen::Vector3d(channel.gravity.data()) * (s.nu * s.nu / (W * W * W));
  s.steps_per_time = W * W / s.nu;
  s.total_steps = s.steps(scenario.run.time_limit);
  if (s.mach() > largest_mach) {
    throw ScenarioError(
        s.u_max >= std::abs(s.wall_velocity[0]) && s.u_max >= std::abs(s.wall_velocity[1])
            ? "channel.reynolds"
            : "channel.wall_velocity",
        fmt::format("makes the Mach number {:.2g}, at most {} is sound: raise channel.nodes to {} "
                    "or lower fluid.tau",
                    s.mach(), largest_mach,
                    static_cast<int>(std::ceil(channel.nodes * s.mach() / largest_mach)) + 1));
  }
  for (const BodyOptions& body : scenario.bodies) s.bodies.push_back(body_setup(body, s));
  return s;
}

std::int64_t LatticeSetup::node_count() const {
  return static_cast<std::int64_t>(nodes[0]) * nodes[1] * nodes[2];
}

double LatticeSetup::mach() const {
  return std::sqrt(3.0) * std::max({u_max, std::abs(wall_velocity[0]), std::abs(wall_velocity[1])});
}

std::int64_t LatticeSetup::steps(double interval) const {
  return interval > 0 ? std::max<std::int64_t>(1, std::llround(interval * steps_per_time)) : 0;
}

Eigen::Vector3d LatticeSetup::origin() const {
  double y = (nodes[1] - 1) / 2.0;
  if (mirror == fluid::Mirror::between_nodes) y = -0.5;
  if (mirror == fluid::Mirror::on_node) y = 0;
  return {(nodes[0] - 1) / 2.0, y, nodes[2] / 2.0};
}

Eigen::Vector3d LatticeSetup::to_lattice(const Eigen::Vector3d& position) const {
  return position * half_width + origin();
}

Eigen::Vector3d LatticeSetup::position(const Eigen::Vector3d& lattice) const {
  return (lattice - origin()) / half_width;
}

}  // namespace ductile::drivers
