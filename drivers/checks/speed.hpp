// What a run costs, and how fast this machine is as far as `ductile bench` has told.
#pragma once

#include <optional>
#include <string>

#include "ductile/suspension/plan.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Node updates a second of the fluid alone.
struct FluidSpeed {
  double double_precision = 0;
  double single_storage = 0;    ///< and arithmetic in double
  double single_precision = 0;  ///< both
  /// The one of them that is a fluid's with these options.
  double& of(const fluid::Options& options) {
    if (options.storage == fluid::Precision::double_precision) return double_precision;
    return options.arithmetic == fluid::Precision::double_precision ? single_storage
                                                                    : single_precision;
  }
};

/// What bodies cost in each time step: seconds of one core. Nodes are those of the boxes around
/// bodies, in which forces act and velocities are told.
struct BodyCosts {
  double row = 0;          ///< of each row of a box along z, which splits a row of the lattice
  double node = 0;         ///< of a node, over one where no force acts
  double node_read = 0;    ///< of a node, if any body asks for velocities before the step
  double node_update = 0;  ///< of a node, in each round of corrections
  double marker = 0;       ///< of a vertex of an explicit capsule
  double marker_pass = 0;  ///< of a marker of a rigid body, in each round and once more
  double implicit = 0;     ///< of a vertex of a capsule of the implicit scheme that is soft
  double stiff = 0;        ///< on top of that, times the square root of k_s in lattice units
};

/// What is known of a machine.
struct KnownSpeed {
  int ranks = 1;     ///< on which `fluid` was measured
  FluidSpeed fluid;  ///< on all of them
  FluidSpeed alone;  ///< on one
  BodyCosts bodies;
};

/// Keeps the speed for known_speed(), in `ductile/bench.toml` under $XDG_CACHE_HOME or ~/.cache;
/// gives the file's path, or nothing if it could not be written.
std::optional<std::string> keep_speed(const KnownSpeed& speed);
/// What the last keep_speed() on this machine has kept; nothing if there is none that can be read.
std::optional<KnownSpeed> known_speed();
/// Cores that this process may use.
int core_count();
/// A cautious guess of a machine with so many cores, which share nothing: a third to a half of what
/// the development machine does (doc/performance.md).
KnownSpeed guessed_speed(int cores);

/// Bytes of the fluid's populations on all ranks.
double population_bytes(const suspension::Plan& plan);
/// The box that is laid around a body: its rows along z, and the nodes in each.
struct BoxSize {
  double rows = 0;
  double length = 0;
};
BoxSize box_around(const suspension::BodyPlan& body);

/// Seconds of a time step, by what is computed.
struct StepTime {
  double fluid = 0;
  double boxes = 0;   ///< force and velocity around bodies
  double bodies = 0;  ///< markers, membranes and rigid bodies, on the rank that has most to do
  [[nodiscard]] double total() const { return fluid + boxes + bodies; }
};

/// Of a plan on so many ranks. Fluid and boxes are shared; a body is worked on by one rank, as
/// suspension::owners() has it.
StepTime expected_step(const suspension::Plan& plan, int ranks, const KnownSpeed& speed);

}  // namespace ductile::drivers
