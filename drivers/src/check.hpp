// What a scenario would be when run: whether it fits, how near it comes to the limits of the
// method, and what it costs.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bench.hpp"
#include "scenario.hpp"
#include "units.hpp"

namespace ductile::drivers {

/// Smallest distance between two surfaces.
struct Gap {
  enum class To { wall, body, image };
  To to = To::wall;
  std::size_t body = 0;   ///< index in Scenario::bodies
  std::size_t other = 0;  ///< the other body's index; for a wall, its axis: 0 for x, 1 for y
  double distance = 0;    ///< lattice spacings; negative where they overlap
};

/// The gaps of every body to the nearer wall of each axis, to every other body (the nearest image
/// of it) and to its own images. That between two biconcave cells is taken between the vertices of
/// fine meshes, a few per cent too long for very small gaps; where bodies overlap only the sign of
/// the distance counts.
std::vector<Gap> gaps(const Scenario& scenario, const LatticeSetup& setup);

/// Throws ScenarioError if a body is in a wall or in another body, or if there are too few nodes
/// across a gap: 2 lattice spacings to a wall, so that the kernel's stencil stays in the fluid, 1
/// between bodies.
void check_geometry(const Scenario& scenario, const LatticeSetup& setup);

/// Throws ScenarioError if the channel is said to be symmetric and the mesh of a body is not.
void check_symmetry(const Scenario& scenario, const LatticeSetup& setup);

/// What a user should know before trusting the run, one line each. Predicts the stability of
/// capsules with an explicit integrator (stability.hpp), which takes a moment.
std::vector<std::string> warnings(const Scenario& scenario, const LatticeSetup& setup);

/// What the lattice or a default has made of the scenario that is not as the paper or the user has
/// it, one line each: a smaller volume modulus, lengths rounded to whole nodes.
std::vector<std::string> notes(const Scenario& scenario, const LatticeSetup& setup);

/// Bytes of the fluid's populations on all ranks.
double population_bytes(const Scenario& scenario, const LatticeSetup& setup);

/// Node updates a second on so many cores: the share of what `ductile bench` has measured on this
/// machine, or a cautious guess (see check.cpp).
double expected_speed(const Scenario& scenario, int cores, const std::optional<KnownSpeed>& known);
/// Seconds until the time limit at that speed.
double estimated_seconds(const LatticeSetup& setup, double speed);

/// The report of `ductile check`.
std::string report(const Scenario& scenario, const LatticeSetup& setup, int cores,
                   const std::optional<KnownSpeed>& known);

}  // namespace ductile::drivers
