#include "scenario/plan.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "ductile/suspension/felt_surface.hpp"
#include "scenario/defaults.hpp"

namespace ductile::drivers {
namespace {

using suspension::Units;

suspension::CapsulePlan capsule_plan(const BodyOptions& body, const surface::Shape& shape,
                                     const fluid::Options& fluid, const Units& units) {
  suspension::CapsulePlan plan;
  const double radius = shape.radius();
  membrane::Moduli& moduli = plan.moduli;
  moduli.law = body.membrane.law;
  moduli.k_s = units.lattice_shear_modulus(body.laplace, radius);
  moduli.k_a = body.membrane.area_ratio * moduli.k_s;
  const double factor =
      suspension::felt_modulus_factor(shape, body.membrane.retraction.value(), moduli, fluid);
  moduli.k_s *= factor;
  moduli.k_a *= factor;
  // The rate at which a mode relaxes is k_s/(eta a), times k_b/(k_s a^2) where it is bending's:
  // with the radius that the fluid feels for a, and the membrane's own in the latter.
  const double inner = radius - body.membrane.retraction.value();
  moduli.k_b = body.membrane.bending * moduli.k_s * inner * inner;
  moduli.k_v = units.lattice_pressure(body.membrane.volume_modulus);
  plan.mobility = body.membrane.mobility;
  plan.retraction = body.membrane.retraction.value();
  plan.integrator = membrane::find_scheme(body.membrane.integrator);
  plan.integrator_options = {body.membrane.theta, body.membrane.substeps, body.membrane.step_cuts};
  return plan;
}

suspension::BodyPlan body_plan(const BodyOptions& body, const fluid::Options& fluid,
                               const Units& units) {
  suspension::BodyPlan plan;
  plan.name = body.name;
  const double radius = units.lattice_length(body.radius);
  plan.shape = surface::make_shape(body.shape, radius);
  plan.centre = units.lattice_position({body.x, body.y, body.z});
  plan.rotation = Eigen::AngleAxisd(body.rotation_angle * std::numbers::pi / 180,
                                    Eigen::Vector3d(body.rotation_axis.data()).stableNormalized())
                      .toRotationMatrix();
  const bool capsule = body.kind == BodyKind::capsule;
  const int frequency = capsule ? body.membrane.frequency : body.rigid.frequency;
  const double edge = capsule ? body.membrane.edge : body.rigid.edge;
  plan.frequency = mesh_frequency(frequency, edge, radius, units.half_width());
  if (capsule) {
    plan.kind = capsule_plan(body, *plan.shape, fluid, units);
  } else {
    plan.kind = suspension::RigidPlan{body.density_ratio,  body.rigid.iterations,
                                      body.rigid.memory,   body.rigid.retraction.value(),
                                      body.rigid.interior, body.rigid.slip.value(),
                                      body.rigid.roughness};
  }
  return plan;
}

// The mean over bodies of the mean velocity along z that the initial flow has on their surfaces,
// which is near to what a body without force is carried with (Faxen).
double velocity_of_bodies(const suspension::Plan& plan) {
  constexpr int coarse = 4;
  const suspension::InitialFlow flow(plan);
  double sum = 0;
  for (const suspension::BodyPlan& body : plan.bodies) {
    surface::Mesh mesh = body.shape->mesh(std::min(body.frequency, coarse));
    surface::place(mesh, body.rotation, body.centre);
    double of_body = 0;
    for (const Eigen::Vector3d& x : mesh.vertices) of_body += flow.at(x.x(), x.y()).velocity.z();
    sum += of_body / static_cast<double>(mesh.vertices.size());
  }
  return plan.bodies.empty() ? 0 : sum / static_cast<double>(plan.bodies.size());
}

fluid::Options fluid_options(const ChannelOptions& channel, const FluidOptions& options) {
  const double W = suspension::half_width(channel.nodes, channel.walls);
  const bool on_nodes = channel.walls == fluid::Boundary::regularized && channel.side_walls;
  const int width_y = static_cast<int>(std::lround(2 * W * channel.half_width_y));
  fluid::Options fluid;
  fluid.nodes = {channel.nodes, width_y + (on_nodes ? 1 : 0),
                 static_cast<int>(std::lround(channel.length * W))};
  if (channel.symmetry == Symmetry::y) {
    fluid.mirror = fluid.nodes[1] % 2 == 0 ? fluid::Mirror::between_nodes : fluid::Mirror::on_node;
    fluid.nodes[1] = (fluid.nodes[1] + 1) / 2;
  }
  fluid.boundary = {channel.walls, channel.side_walls ? channel.walls : fluid::Boundary::periodic,
                    fluid::Boundary::periodic};
  fluid.tau = options.tau;
  fluid.collision = options.collision;
  fluid.magic = options.magic;
  fluid.equilibrium = options.equilibrium;
  fluid.storage = options.storage;
  fluid.arithmetic = options.arithmetic;
  return fluid;
}

}  // namespace

bool Schedule::due(std::int64_t step, double interval) {
  if (!(interval > 0)) return false;
  const double nearest = std::round(static_cast<double>(step) / interval);
  return std::llround(nearest * interval) == step;
}

Case planned(Scenario scenario) {
  const ChannelOptions& channel = scenario.channel;
  suspension::Plan plan;
  plan.fluid = fluid_options(channel, scenario.fluid);
  plan.start = channel.start;
  plan.units = suspension::Plan::channel_units(plan.fluid);
  const Units& units = plan.units;
  plan.drive(channel.reynolds);
  for (std::size_t side = 0; side < 2; ++side) {
    plan.fluid.wall_velocity[0][side].z() = units.lattice_velocity(channel.wall_velocity[side]);
  }
  plan.gravity = units.lattice_acceleration(Eigen::Vector3d(channel.gravity.data()));
  for (const BodyOptions& body : scenario.bodies)
    plan.bodies.push_back(body_plan(body, plan.fluid, units));

  if (scenario.fluid.frame == LatticeFrame::bodies) {
    plan.ride(velocity_of_bodies(plan));
    plan.follow = true;
  }

  const OutputOptions& output = scenario.output;
  const Schedule schedule{
      units.lattice_steps(scenario.run.time_limit), output.every * units.steps_per_time(),
      output.surfaces_every * units.steps_per_time(), output.field_every * units.steps_per_time()};
  return {std::move(scenario), std::move(plan), schedule};
}

}  // namespace ductile::drivers
