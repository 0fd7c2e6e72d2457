// The bodies of a scenario, and what they show to the outside.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "ductile/coupling/body.hpp"
#include "ductile/membrane/integrator.hpp"
#include "sample.hpp"
#include "scenario.hpp"
#include "units.hpp"

namespace ductile::drivers {

/// A body in the fluid, on the rank that owns it.
class ImmersedBody {
 public:
  ImmersedBody() = default;
  ImmersedBody(const ImmersedBody&) = delete;
  ImmersedBody& operator=(const ImmersedBody&) = delete;
  virtual ~ImmersedBody() = default;

  /// What the coupler moves.
  [[nodiscard]] virtual coupling::Body& markers() = 0;
  [[nodiscard]] virtual std::span<const double> positions() const = 0;
  /// Velocity of the markers in the latest step, and their force on the fluid where the body knows
  /// it (else empty); lattice units.
  [[nodiscard]] virtual std::span<const double> velocities() const = 0;
  [[nodiscard]] virtual std::span<const double> forces() const = 0;
  /// Its state in the paper's units.
  [[nodiscard]] virtual BodySample sample() const = 0;
  /// What a capsule's integrator has spent so far; zeros of any other body.
  [[nodiscard]] virtual membrane::SolveStatistics solver() const { return {}; }
};

/// Body number `index` of the scenario. `setup` must outlive it.
std::unique_ptr<ImmersedBody> make_body(const Scenario& scenario, const LatticeSetup& setup,
                                        std::size_t index);

/// The triangles of its surface; its markers are the vertices.
std::vector<std::array<int, 3>> surface_triangles(const Scenario& scenario,
                                                  const LatticeSetup& setup, std::size_t index);

}  // namespace ductile::drivers
