#include "checks/advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "analysis/contacts.hpp"
#include "checks/geometry.hpp"
#include "checks/speed.hpp"
#include "scenario/defaults.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {
namespace {

using suspension::Plan;

constexpr double sound_mach = 0.15;
constexpr double smallest_radius = 4;  // lattice spacings
constexpr double sound_lead = 0.01;    // of waves of length 2 a, of the flow's velocity

/// What lowers the largest part of a load.
std::string_view cure(const StabilityLoad& load) {
  if (load.volume >= std::max(load.shear, load.bending)) return "lower volume_modulus or fluid.tau";
  if (load.bending > load.shear) return "raise edge or lower bending, mobility or fluid.tau";
  return "lower laplace or fluid.tau";
}

/// By what part of the flow's velocity U waves of wave number k run ahead of it, over k^2:
/// doc/equations.md, "Galilean invariance". In bgk magic is (tau - 1/2)^2.
constexpr double lead_of_waves(double tau, double magic) {
  return 2.0 / 3 * ((tau - 0.5) * (tau - 0.5) - (23 * magic + 1) / 35);
}

/// Of bgk nothing is said: `keys` bound its tau so that it carries waves well enough; nor of a
/// lattice that moves with the bodies, which carries what is about them nowhere.
void warn_of_collision(const Plan& plan, std::vector<std::string>& list) {
  const double tau = plan.fluid.tau;
  const double magic = plan.fluid.magic;
  if (plan.fluid.collision == fluid::Collision::bgk || plan.bodies.empty() || plan.follow) return;
  const auto radius_of = [](const suspension::BodyPlan& body) { return body.shape->radius(); };
  const auto smallest = std::ranges::min_element(plan.bodies, {}, radius_of);
  const double radius = radius_of(*smallest);
  constexpr double most_of_bgk = lead_of_waves(1, 0.25);
  const double lead = lead_of_waves(tau, magic) * std::pow(std::numbers::pi / radius, 2);
  if (std::abs(lead_of_waves(tau, magic)) <= most_of_bgk || std::abs(lead) <= sound_lead) return;
  list.push_back(fmt::format(
      "trt with tau_odd = {:.3g} carries what is as small as {} {:.1f}% too {}, which shifts "
      "positions across the channel by a like part, more than bgk does: take fluid.collision = "
      "\"bgk\", fluid.tau = {:.2g} or channel.nodes = {}",
      0.5 + magic / (tau - 0.5),
      body_name(plan, static_cast<std::size_t>(smallest - plan.bodies.begin())),
      100 * std::abs(lead), lead > 0 ? "fast" : "slowly", 0.5 + std::sqrt((23 * magic + 1) / 35),
      nodes_for_gap(plan, radius, radius * std::sqrt(std::abs(lead) / sound_lead))));
}

void warn_of_flow(const Plan& plan, std::vector<std::string>& list) {
  if (plan.mach() > sound_mach) {
    list.push_back(
        fmt::format("Mach number {:.2f}: errors of compressibility go as its square; "
                    "more nodes or a lower tau reduce it",
                    plan.mach()));
  }
  const auto [low, high] = plan.wall_velocity();
  const bool carried = plan.u_max != 0 && low == 0 && high == 0 && plan.gravity.isZero(0);
  if (plan.fluid.equilibrium == fluid::Equilibrium::incompressible && !plan.bodies.empty() &&
      !(carried && plan.follow)) {
    list.push_back(fmt::format(
        "an incompressible equilibrium shifts bodies that move on the lattice, more than a "
        "compressible one does, as {}: take {}fluid.equilibrium = \"compressible\"",
        plan.follow ? "where gravity or walls move them" : "on a lattice at rest",
        carried ? "fluid.frame = \"bodies\" or " : ""));
  }
  for (const Gap& gap : gaps(plan)) {
    if (gap.to == Gap::To::body && gap.distance < resolved_gap - round_off &&
        !has_film(plan, gap)) {
      list.push_back(fmt::format(
          "the gap between {} and {} is {:.1f} lattice spacings, under the {} that resolve the "
          "flow in it; channel.nodes = {} would do",
          body_name(plan, gap.body), body_name(plan, gap.other), gap.distance, resolved_gap,
          nodes_for_gap(plan, gap.distance, resolved_gap)));
    }
  }
}

// `unpredicted` gathers the names of capsules without a model.
void warn_of_body(const Plan& plan, std::size_t index, StabilityModels& models,
                  std::vector<std::string>& list, std::vector<std::string>& unpredicted) {
  const suspension::BodyPlan& body = plan.bodies[index];
  const std::string name = body_name(plan, index);
  if (body.shape->radius() < smallest_radius) {
    list.push_back(
        fmt::format("the radius of {} is {:.1f} lattice spacings; under {} results are "
                    "crude",
                    name, body.shape->radius(), smallest_radius));
  }
  const suspension::CapsulePlan* capsule = body.capsule();
  if (capsule == nullptr) return;
  const double edge =
      surface::icosphere_edge(body.shape->radius() - body.retraction(), body.frequency);
  if (capsule->mobility == 0 && edge < 1) {
    list.push_back(
        fmt::format("{} has edges of {:.2f} lattice spacings and no mobility: strain "
                    "that the lattice cannot see will pile up; watch its strain energy",
                    name, edge));
  }
  const membrane::SchemeTraits& traits = capsule->integrator.traits;
  if (traits.weights.empty() && std::isinf(traits.reach)) return;  // no model need be measured
  const StabilityModel* model = models[index];
  if (model == nullptr) {
    unpredicted.push_back(body.name);
    return;
  }
  const std::string warning = stability_warning(capsule->integrator, *model);
  if (!warning.empty()) list.push_back(name + " is at " + warning);
}

}  // namespace

std::string size_text(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.1f} MB", bytes / 1e6)
                     : fmt::format("{:.2f} GB", bytes / 1e9);
}

std::string percentages(const StabilityLoad& load, std::string_view integrator) {
  return fmt::format("{:.0f}% of the limit of {} (shear {:.0f}%, bending {:.0f}%, volume {:.0f}%)",
                     100 * load.total, integrator, 100 * load.shear, 100 * load.bending,
                     100 * load.volume);
}

std::string judgement(const membrane::Scheme& scheme, const StabilityModel& model) {
  const membrane::Scheme& advised = advised_scheme(model);
  if (scheme.name == advised.name) return "the cheapest that is stable here";
  if (!relied_on(scheme, model)) {
    std::string_view said = "not tried at such stiffness";
    if (!scheme.traits.weights.empty()) {
      said =
          model.load(scheme.traits.weights).total > 1 ? "unstable here" : "too near to its limit";
    }
    return fmt::format("{}; take {}", said, advised.name);
  }
  return scheme.traits.cost > advised.traits.cost
             ? fmt::format("stable here, but {} is too and costs less", advised.name)
             : fmt::format("stable here, as {} is", advised.name);
}

std::string stability_warning(const membrane::Scheme& scheme, const StabilityModel& model) {
  if (relied_on(scheme, model)) return "";
  const bool has_weights = !scheme.traits.weights.empty();
  const StabilityLoad load =
      model.load((has_weights ? scheme : membrane::reference_scheme()).traits.weights);
  const std::string where = !has_weights
                                ? fmt::format("beyond the {:g} times up to which {} is relied on",
                                              scheme.traits.reach, scheme.name)
                                : (load.total > 1 ? "where it is unstable" : "too near to rely on");
  return fmt::format("{}, {}: take membrane.integrator = \"{}\", or {}",
                     percentages(load, (has_weights ? scheme : membrane::reference_scheme()).name),
                     where, advised_scheme(model).name, cure(load));
}

std::vector<std::string> warnings(const Case& given, StabilityModels& models) {
  const Plan& plan = given.plan;
  std::vector<std::string> list;
  warn_of_flow(plan, list);
  warn_of_collision(plan, list);
  std::vector<std::string> unpredicted;
  for (std::size_t i = 0; i < plan.bodies.size(); ++i)
    warn_of_body(plan, i, models, list, unpredicted);
  if (!unpredicted.empty()) {
    list.push_back(fmt::format(
        "the stability of {} is not predicted, which would take long: `ductile check --thorough` "
        "does it",
        some_of(unpredicted)));
  }
  return list;
}

std::vector<std::string> warnings(const Case& given, double patience) {
  StabilityModels models(given.plan, patience);
  return warnings(given, models);
}

std::vector<std::string> notes(const Case& given) {
  const auto& [scenario, plan, schedule] = given;
  std::vector<std::string> list;
  const auto rounded = [&list](std::string_view key, double wanted, double is) {
    if (std::abs(is - wanted) > round_off)
      list.push_back(fmt::format("{} = {} is {:.6g} in whole nodes", key, wanted, is));
  };
  rounded("channel.half_width_y", scenario.channel.half_width_y,
          plan.units.length(plan.half_width_y()));
  rounded("channel.length", scenario.channel.length, plan.units.length(plan.length()));
  // Volume modulus, and who has it.
  std::vector<std::pair<double, std::vector<std::string>>> reduced;
  for (const BodyOptions& body : scenario.bodies) {
    const double k_v = body.membrane.volume_modulus;
    if (body.kind == BodyKind::rigid || k_v >= paper_volume_modulus) continue;
    auto same =
        std::ranges::find(reduced, k_v, &std::pair<double, std::vector<std::string>>::first);
    if (same == reduced.end()) same = reduced.insert(same, {k_v, {}});
    same->second.push_back(body.name);
  }
  for (const auto& [k_v, names] : reduced) {
    list.push_back(fmt::format(
        "volume_modulus of {} is {:g} rho nu^2/W^2 ({:.2g} in lattice units), not the paper's "
        "{:g} ({:.2g}): see the volume error",
        some_of(names), k_v, plan.units.lattice_pressure(k_v), paper_volume_modulus,
        plan.units.lattice_pressure(paper_volume_modulus)));
  }
  // What is asked for, and nothing asks: a roughness where no two can touch.
  if (std::ranges::count_if(plan.bodies, suspension::has_films) < 2) {
    std::vector<std::string> rough;
    for (const suspension::BodyPlan& body : plan.bodies) {
      if (body.rigid() != nullptr && body.rigid()->roughness != rigid::usual_roughness)
        rough.push_back(body.name);
    }
    if (!rough.empty()) {
      list.push_back(fmt::format(
          "roughness of {} has no effect: only rigid spheres with slip have films, and there are "
          "no two",
          some_of(rough)));
    }
  }
  return list;
}

}  // namespace ductile::drivers
