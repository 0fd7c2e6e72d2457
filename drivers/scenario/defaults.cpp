#include "scenario/defaults.hpp"

#include <algorithm>
#include <cmath>

#include "ductile/rigid/body.hpp"
#include "ductile/surface/mesh.hpp"
#include "ductile/suspension/felt_surface.hpp"

namespace ductile::drivers {

double default_volume_modulus(const ChannelOptions& channel, const FluidOptions& fluid) {
  constexpr double sound = 1.5;  // lattice units
  const suspension::Units units(suspension::half_width(channel.nodes, channel.walls),
                                suspension::lattice_viscosity(fluid.tau), Eigen::Vector3d::Zero());
  const double bearable = units.pressure(sound);
  if (bearable >= paper_volume_modulus) return paper_volume_modulus;
  const double unit = std::pow(10.0, std::floor(std::log10(bearable)) - 2);
  return std::floor(bearable / unit) * unit;
}

int mesh_frequency(int frequency, double edge, double radius, double half_width) {
  // A body that cannot fit is refused later, without the cost of its mesh.
  return frequency > 0 ? frequency
                       : surface::frequency_for_edge(std::min(radius, half_width), edge);
}

double least_density_ratio(const surface::Shape& shape, int frequency, double retraction,
                           double missed, bool half_channel, suspension::Interior interior) {
  constexpr int fine = 24;
  if (interior == suspension::Interior::solid) {
    return rigid::least_density_ratio(
        rigid::lined(shape, std::min(frequency, fine), retraction, missed), rigid::solid_of(shape),
        rigid::Options{}.relaxation);
  }
  rigid::Surface surface = rigid::markers_of(shape.mesh(std::min(frequency, fine)), missed);
  const double scale = 1 - retraction / shape.radius();
  for (Eigen::Vector3d& marker : surface.markers) marker *= scale;
  for (double& area : surface.areas) area *= scale * scale;
  return rigid::least_density_ratio(surface, rigid::solid_of(shape), rigid::Options{}.relaxation,
                                    half_channel);
}

namespace {

fluid::Options collision_of(const FluidOptions& fluid) {
  fluid::Options options;
  options.tau = fluid.tau;
  options.collision = fluid.collision;
  options.magic = fluid.magic;
  return options;
}

}  // namespace

double default_retraction(const ChannelOptions& channel, const FluidOptions& fluid,
                          const BodyOptions& body, double slip, bool solid) {
  constexpr double shells = 0.2;
  const double radius = body.radius * suspension::half_width(channel.nodes, channel.walls);
  if (!(radius >= 2)) return 0;  // refused later
  const double felt = suspension::felt_retraction(*surface::make_shape(body.shape, radius),
                                                  collision_of(fluid), slip);
  return solid ? std::min(felt + shells, radius / 2) : felt;
}

suspension::FeltPlace default_place(const ChannelOptions& channel, const FluidOptions& fluid,
                                    const BodyOptions& body) {
  const double radius = body.radius * suspension::half_width(channel.nodes, channel.walls);
  if (!(radius >= 2)) return {};  // refused later
  return suspension::felt_place(*surface::make_shape(body.shape, radius), collision_of(fluid));
}

suspension::Interior default_interior(const ChannelOptions& channel, const FluidOptions& fluid,
                                      const BodyOptions& body) {
  const double half_width = suspension::half_width(channel.nodes, channel.walls);
  const double radius = body.radius * half_width;
  const RigidOptions& options = body.rigid;
  // A radius of 2 is the least that is accepted, and needs no shells.
  if (body.density_ratio >= 1 || radius < 2) return suspension::Interior::fluid;
  const double least = least_density_ratio(
      *surface::make_shape(body.shape, radius),
      mesh_frequency(options.frequency, options.edge, radius, half_width),
      options.retraction.value(), options.slip.value() / suspension::lattice_viscosity(fluid.tau),
      channel.symmetry == Symmetry::y, suspension::Interior::fluid);
  return body.density_ratio < least ? suspension::Interior::solid : suspension::Interior::fluid;
}

double default_stop_distance(const ChannelOptions& channel) {
  return std::min(RunLimits{}.stop_distance, std::max(channel.length - 2, channel.length / 2));
}

}  // namespace ductile::drivers
