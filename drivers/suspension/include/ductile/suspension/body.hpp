// The bodies of a suspension, and what they show to the outside.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "ductile/coupling/body.hpp"
#include "ductile/membrane/integrator.hpp"
#include "ductile/rigid/body.hpp"
#include "ductile/suspension/plan.hpp"
#include "ductile/suspension/sample.hpp"

namespace ductile::suspension {

using membrane::StateReader;
using membrane::StateWriter;

/// A body in the fluid, on the rank that owns it; lattice units. Arrays hold 3 numbers a vertex of
/// BodyPlan::mesh(); spans are valid until the next step.
class Body {
 public:
  Body() = default;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;
  virtual ~Body() = default;

  /// What the coupler moves.
  [[nodiscard]] virtual coupling::Body& markers() = 0;
  /// Where the markers behind the vertices of its surface are; valid until the next step.
  [[nodiscard]] virtual std::span<const double> inner_positions() const = 0;
  /// Where the vertices of its surface are, which lies BodyPlan::retraction() outside of its
  /// markers: a capsule's along the normals there, each the mean of the triangles' by their areas.
  [[nodiscard]] virtual std::vector<double> positions() const = 0;
  /// Velocity of the vertices in the latest step (of a rigid body: the fluid's at its markers, and
  /// what its rotation adds from there to the surface), before the first that of the initial flow
  /// there; and the force of their markers on the fluid where the body knows it (else empty).
  [[nodiscard]] virtual std::vector<double> velocities() const = 0;
  [[nodiscard]] virtual std::span<const double> forces() const = 0;
  [[nodiscard]] virtual Observation observe() const = 0;
  /// Null unless it is rigid.
  [[nodiscard]] virtual rigid::Body* rigid() { return nullptr; }
  /// What a capsule's integrator has spent so far; zeros of any other body.
  [[nodiscard]] virtual membrane::SolveStatistics solver() const { return {}; }

  /// All that determines its future, and what it shows of the latest step.
  virtual void save(const StateWriter& write) const = 0;
  /// Goes on from what another body of the same plan has saved. If `read` throws, the body is good
  /// for nothing but another load().
  virtual void load(const StateReader& read) = 0;
};

/// Body `index` of the plan, which must outlive it. Throws std::invalid_argument as
/// membrane::Capsule or rigid::Body.
std::unique_ptr<Body> make_body(const Plan& plan, std::size_t index);

}  // namespace ductile::suspension
