#include "films.hpp"

#include <utility>

#include "ductile/suspension/body.hpp"

namespace ductile::suspension {

std::unique_ptr<Films> Films::make(const Plan& plan) {
  std::vector<std::size_t> bodies;
  std::vector<rigid::Lubrication::Sphere> spheres;
  const double viscosity = plan.units.viscosity();
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const BodyPlan& body = plan.bodies[b];
    if (!has_films(body)) continue;
    bodies.push_back(b);
    const RigidPlan& kind = *body.rigid();
    const double mobility = rigid::film_mobility(markers_of(body, viscosity),
                                                 rigid::solid_of(*body.shape), kind.density_ratio);
    spheres.push_back({body.shape->radius(), mobility, kind.roughness});
  }
  if (bodies.size() < 2) return nullptr;
  const auto period = [&](std::size_t axis) {
    return plan.fluid.boundary[axis] == fluid::Boundary::periodic ? plan.fluid.nodes[axis] : 0.0;
  };
  return std::unique_ptr<Films>(
      new Films(std::move(bodies), {std::move(spheres), viscosity, {period(1), period(2)}}));
}

Films::Films(std::vector<std::size_t> bodies, rigid::Lubrication lubrication)
    : bodies_(std::move(bodies)), lubrication_(std::move(lubrication)) {}

}  // namespace ductile::suspension
