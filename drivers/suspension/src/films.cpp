#include "films.hpp"

#include <numbers>
#include <utility>

namespace ductile::suspension {

std::unique_ptr<Films> Films::make(const Plan& plan) {
  std::vector<std::size_t> bodies;
  std::vector<rigid::Lubrication::Sphere> spheres;
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const BodyPlan& body = plan.bodies[b];
    if (!has_films(body)) continue;
    bodies.push_back(b);
    const RigidPlan& kind = *body.rigid();
    const double inner = body.shape->radius() - kind.retraction;
    const double mobility = rigid::film_mobility(4 * std::numbers::pi * inner * inner,
                                                 (kind.density_ratio - 1) * body.shape->volume());
    spheres.push_back({body.shape->radius(), mobility, kind.roughness});
  }
  if (bodies.size() < 2) return nullptr;
  const auto period = [&](std::size_t axis) {
    return plan.fluid.boundary[axis] == fluid::Boundary::periodic ? plan.fluid.nodes[axis] : 0.0;
  };
  return std::unique_ptr<Films>(new Films(
      std::move(bodies), {std::move(spheres), plan.units.viscosity(), {period(1), period(2)}}));
}

Films::Films(std::vector<std::size_t> bodies, rigid::Lubrication lubrication)
    : bodies_(std::move(bodies)), lubrication_(std::move(lubrication)) {}

}  // namespace ductile::suspension
