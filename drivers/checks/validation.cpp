#include "checks/validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "analysis/contacts.hpp"
#include "checks/geometry.hpp"
#include "scenario/defaults.hpp"
#include "scenario/errors.hpp"

namespace ductile::drivers {
namespace {

using suspension::Plan;

constexpr double wall_gap = suspension::kernel_reach;
constexpr double body_gap = 1;
constexpr double image_gap = 5;

void check_channel(const Scenario& s) {
  const bool moving = s.channel.wall_velocity != std::array<double, 2>{0, 0};
  if (moving && s.channel.side_walls && s.channel.start == suspension::Start::developed) {
    throw ScenarioError("channel.start",
                        "must be \"rest\" where walls move and there are side walls, since no "
                        "developed flow is known for it (or set channel.side_walls = false)");
  }
  const bool symmetric = s.channel.symmetry == Symmetry::y;
  if (symmetric && !s.channel.side_walls) {
    throw ScenarioError("channel.symmetry",
                        "must be \"none\" where channel.side_walls = false: the plane of symmetry "
                        "needs a wall to face");
  }
  if (symmetric && s.channel.gravity[1] != 0) {
    throw ScenarioError("channel.gravity",
                        "must be 0 along y where channel.symmetry = \"y\": set that to \"none\"");
  }
  if (s.run.stop_distance > s.channel.length) {
    throw ScenarioError("run.stop_distance",
                        fmt::format("must be at most channel.length = {}: further away is nearer "
                                    "to the periodic image",
                                    s.channel.length));
  }
}

void check_bodies(const Scenario& s) {
  const bool symmetric = s.channel.symmetry == Symmetry::y;
  for (const BodyOptions& body : s.bodies) {
    const std::string path = "body." + body.name + ".";
    if (body.kind == BodyKind::rigid && body.shape != "sphere")
      throw ScenarioError(path + "shape", "rigid bodies are spheres: remove it");
    if (body.rotation_axis == std::array<double, 3>{0, 0, 0})
      throw ScenarioError(path + "rotation_axis", "must not be zero");
    if (symmetric && body.y != 0) {
      throw ScenarioError(path + "y",
                          "must be 0 where channel.symmetry = \"y\": put the body on the plane of "
                          "symmetry, or set channel.symmetry = \"none\"");
    }
    if (std::abs(body.z) > s.channel.length / 2) {
      throw ScenarioError(path + "z",
                          fmt::format("must be from {} to {}: half of channel.length either way",
                                      -s.channel.length / 2, s.channel.length / 2));
    }
  }
}

void check_mach(const Case& given) {
  const Plan& plan = given.plan;
  if (plan.mach() <= largest_mach) return;
  const auto [low, high] = plan.wall_velocity();
  const bool flow = plan.u_max >= std::max(std::abs(low), std::abs(high));
  const double nodes = std::ceil(given.scenario.channel.nodes * plan.mach() / largest_mach) + 1;
  throw ScenarioError(
      flow ? "channel.reynolds" : "channel.wall_velocity",
      fmt::format("makes the Mach number {:.2g}, at most {} is sound: {}", plan.mach(),
                  largest_mach,
                  nodes <= most_nodes
                      ? fmt::format("raise channel.nodes to {:.0f} or lower fluid.tau", nodes)
                      : "lower it"));
}

/// So many nodes, if a channel may have them, or what else helps.
std::string advised(int nodes, std::string_view otherwise) {
  return nodes <= most_nodes ? fmt::format("raise channel.nodes to {} or {}", nodes, otherwise)
                             : std::string(otherwise);
}

/// What the coupling needs. The kernel reaches two nodes beyond a marker: not onto a wall's own
/// nodes, and not round a periodic channel to where the body's other end reaches.
double least_gap(const Plan& plan, const Gap& gap) {
  constexpr double beyond = 0.01;
  if (gap.to == Gap::To::body) return body_gap;
  if (gap.to == Gap::To::image) return image_gap;
  return plan.fluid.boundary[0] == fluid::Boundary::regularized ? wall_gap + beyond : wall_gap;
}

void check_radii(const Plan& plan) {
  for (std::size_t i = 0; i < plan.bodies.size(); ++i) {
    const double radius = plan.bodies[i].shape->radius();
    if (radius >= 2) continue;
    throw ScenarioError(
        "channel.nodes",
        fmt::format("too few nodes: the radius of {} is {:.2g} lattice spacings, at least 2 are "
                    "needed: {}",
                    body_name(plan, i), radius,
                    advised(nodes_for_gap(plan, radius, 2), "make it larger")));
  }
}

void check_periodic_sides(const Plan& plan) {
  if (plan.side_walls()) return;
  for (std::size_t i = 0; i < plan.bodies.size(); ++i) {
    if (plan.half_width_y() - reach_from_axis(plan, i, 1) >= wall_gap - round_off) continue;
    const double side = plan.bodies[i].centre.y() - plan.units.origin().y();
    throw ScenarioError(
        "body." + plan.bodies[i].name + ".y",
        fmt::format("{} reaches the periodic side at y = {:.6g}, which bodies cannot cross: move "
                    "it or make channel.half_width_y larger",
                    body_name(plan, i),
                    std::copysign(plan.units.length(plan.half_width_y()), side)));
  }
}

[[noreturn]] void refuse_overlap(const Plan& plan, const Gap& gap) {
  const std::string path = "body." + plan.bodies[gap.body].name;
  if (gap.to == Gap::To::wall) {
    throw ScenarioError(path + (gap.other == 0 ? ".x" : ".y"),
                        fmt::format("{} reaches {:.3g} W into {}: move it or make it smaller",
                                    body_name(plan, gap.body), plan.units.length(-gap.distance),
                                    wall_name(plan, gap)));
  }
  if (gap.to == Gap::To::image) {
    throw ScenarioError(path + ".radius",
                        fmt::format("{} overlaps its own periodic image: make the channel longer "
                                    "or the body smaller",
                                    body_name(plan, gap.body)));
  }
  throw ScenarioError("body." + plan.bodies[gap.other].name,
                      fmt::format("overlaps {}: move one of them", body_name(plan, gap.body)));
}

void check_gaps(const Plan& plan) {
  const std::vector<Gap> all = gaps(plan);
  // Overlaps first: no number of nodes cures them.
  for (const Gap& gap : all) {
    if (gap.distance <= 0) refuse_overlap(plan, gap);
  }
  for (const Gap& gap : all) {
    const double least = least_gap(plan, gap);
    if (gap.distance >= least - round_off) continue;
    throw ScenarioError(
        "channel.nodes",
        fmt::format("too few nodes across the gap between {} and {}: {:.2f} lattice spacings, at "
                    "least {} needed: {}",
                    body_name(plan, gap.body), across_name(plan, gap), gap.distance, least,
                    advised(nodes_for_gap(plan, gap.distance, least), "move the body")));
  }
}

/// The mirror image about y = 0 of each vertex of a mesh; nothing if one has none.
std::optional<std::vector<int>> mirror_images(const surface::Mesh& mesh) {
  const auto& x = mesh.vertices;
  std::vector<int> by_x(x.size());
  std::iota(by_x.begin(), by_x.end(), 0);
  const auto x_of = [&x](int v) { return x[static_cast<std::size_t>(v)].x(); };
  std::ranges::sort(by_x, {}, x_of);
  std::vector<int> images;
  for (const Eigen::Vector3d& vertex : x) {
    const Eigen::Vector3d image(vertex.x(), -vertex.y(), vertex.z());
    auto other = std::ranges::lower_bound(by_x, image.x() - round_off, {}, x_of);
    while (other != by_x.end() && x_of(*other) <= image.x() + round_off &&
           (x[static_cast<std::size_t>(*other)] - image).norm() > round_off)
      ++other;
    if (other == by_x.end() || x_of(*other) > image.x() + round_off) return std::nullopt;
    images.push_back(*other);
  }
  return images;
}

/// Whether a mesh of about unit size is its own mirror image about y = 0.
bool is_symmetric(const surface::Mesh& mesh) {
  const auto images = mirror_images(mesh);
  if (!images) return false;
  const auto sorted = [](std::array<int, 3> triangle) {
    std::ranges::sort(triangle);
    return triangle;
  };
  std::set<std::array<int, 3>> triangles;
  for (const auto& triangle : mesh.triangles) triangles.insert(sorted(triangle));
  return std::ranges::all_of(mesh.triangles, [&](std::array<int, 3> triangle) {
    for (int& vertex : triangle) vertex = (*images)[static_cast<std::size_t>(vertex)];
    return triangles.contains(sorted(triangle));
  });
}

void check_symmetry(const Plan& plan) {
  if (plan.fluid.mirror == fluid::Mirror::none) return;
  const int least = plan.fluid.boundary[1] == fluid::Boundary::regularized ? 4 : 2;
  const int nodes = plan.fluid.nodes[1];
  if (nodes < least) {
    throw ScenarioError("channel.symmetry",
                        fmt::format("leaves {} node{} along y, at least {} are needed: use more "
                                    "channel.nodes, or set it to \"none\"",
                                    nodes, nodes == 1 ? "" : "s", least));
  }
  for (std::size_t i = 0; i < plan.bodies.size(); ++i) {
    const suspension::BodyPlan& body = plan.bodies[i];
    // Division keeps the icosahedron's symmetries and adds none, so a coarse mesh tells.
    surface::Mesh mesh =
        surface::make_shape(body.shape->name(), 1)->mesh(std::min(body.frequency, 4));
    surface::place(mesh, body.rotation, Eigen::Vector3d::Zero());
    if (is_symmetric(mesh)) continue;
    throw ScenarioError(
        "body." + body.name + ".rotation_axis",
        fmt::format("turns the mesh of {} so that it is not its own mirror image about y = 0 to "
                    "{:g} radii: use [0, 1, 0], or set channel.symmetry = \"none\"",
                    body_name(plan, i), round_off));
  }
}

/// Whether each surface can be moved inwards so far.
void check_retractions(const Plan& plan) {
  constexpr int coarse = 4;
  for (const suspension::BodyPlan& body : plan.bodies) {
    try {
      if (const double most = body.shape->radius() / 2; body.retraction() > most) {
        throw std::invalid_argument(fmt::format(
            "{:.3g} dx is more than half of the radius, {:.3g} dx", body.retraction(), most));
      }
      (void)body.shape->mesh(std::min(body.frequency, coarse), -body.retraction());
    } catch (const std::invalid_argument& error) {
      throw ScenarioError("body." + body.name + ".retraction",
                          fmt::format("is too much for a body of this size, use less of it or more "
                                      "channel.nodes: {}",
                                      error.what()));
    }
  }
}

/// Whether each light body is stable.
void check_densities(const Plan& plan) {
  for (const suspension::BodyPlan& body : plan.bodies) {
    const suspension::RigidPlan* kind = body.rigid();
    if (kind == nullptr || kind->density_ratio >= 1) continue;
    const double least = least_density_ratio(
        *body.shape, body.frequency, kind->retraction, kind->slip / plan.units.viscosity(),
        plan.fluid.mirror != fluid::Mirror::none, kind->interior);
    if (kind->density_ratio >= least) continue;
    const bool solid = kind->interior == suspension::Interior::solid;
    throw ScenarioError(
        "body." + body.name + ".density_ratio",
        fmt::format("must be at least {:.3g} for a {} of this size{}: raise it{}", least,
                    solid ? "solid" : "body", solid ? "" : " with fluid inside",
                    !solid           ? ", or set interior = \"solid\""
                    : kind->slip > 0 ? " or channel.nodes, or take less slip"
                                     : " or channel.nodes"));
  }
}

}  // namespace

void validate(const Case& given) {
  check_channel(given.scenario);
  check_bodies(given.scenario);
  check_mach(given);
  check_radii(given.plan);
  check_periodic_sides(given.plan);
  check_gaps(given.plan);
  check_symmetry(given.plan);
  check_retractions(given.plan);
  check_densities(given.plan);
}

}  // namespace ductile::drivers
