// Defaults that follow from other keys.
#pragma once

#include "ductile/surface/shape.hpp"
#include "ductile/suspension/felt_surface.hpp"
#include "scenario/scenario.hpp"

namespace ductile::drivers {

constexpr double paper_volume_modulus = 75000;  ///< rho nu^2/W^2

/// [membrane] volume_modulus, in rho nu^2/W^2: the paper's 75000, or where that is above 1.5 in
/// lattice units, what 1.5 comes to, rounded down to three digits. The explicit scheme bears more,
/// unless the capsule or tau is small (analysis/stability.hpp).
double default_volume_modulus(const ChannelOptions& channel, const FluidOptions& fluid);

/// Frequency of a body's mesh: the key of that name, or if that is 0, as the key edge demands; all
/// lengths in lattice spacings.
int mesh_frequency(int frequency, double edge, double radius, double half_width);

/// The least density ratio at which a rigid body is stable, by rigid::least_density_ratio: with
/// fluid inside in the whole channel or on the plane of symmetry of half of it, as a solid in
/// either. All lengths in lattice spacings, retraction below the radius, `missed` as of
/// rigid::Surface. A coarse mesh, which has a little less area, stands for a fine one.
double least_density_ratio(const surface::Shape& shape, int frequency, double retraction,
                           double missed, bool half_channel, suspension::Interior interior);

/// retraction of a body, in lattice spacings: what makes its surface felt where it is
/// (suspension::felt_retraction), of a solid 0.2 more, as inner shells make it felt further out; at
/// most half of the radius. Takes the shape and the radius of the body.
double default_retraction(const ChannelOptions& channel, const FluidOptions& fluid,
                          const BodyOptions& body, double slip, bool solid = false);
/// Of a rigid body with fluid inside, and its slip (suspension::felt_place); alike.
suspension::FeltPlace default_place(const ChannelOptions& channel, const FluidOptions& fluid,
                                    const BodyOptions& body);

/// interior of a rigid body: a solid where it is too light to be stable with fluid inside, else
/// fluid. Takes all else that is said of the body.
suspension::Interior default_interior(const ChannelOptions& channel, const FluidOptions& fluid,
                                      const BodyOptions& body);

/// [run] stop_distance, in W: 10, or in a shorter channel its length less 2, or half its length if
/// that is more.
double default_stop_distance(const ChannelOptions& channel);

}  // namespace ductile::drivers
