#include "scenario/defaults.hpp"

#include <algorithm>
#include <cmath>

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

double default_stop_distance(const ChannelOptions& channel) {
  return std::min(RunLimits{}.stop_distance, std::max(channel.length - 2, channel.length / 2));
}

}  // namespace ductile::drivers
