#include "checks/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "analysis/contacts.hpp"
#include "analysis/stability.hpp"
#include "checks/advice.hpp"
#include "checks/disk.hpp"
#include "checks/geometry.hpp"
#include "checks/memory.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {
namespace {

std::string precision_text(const fluid::Options& fluid) {
  if (fluid.storage == fluid::Precision::double_precision) return "double precision";
  if (fluid.arithmetic == fluid::Precision::single_precision) return "single precision";
  return "populations in single precision, arithmetic in double";
}

/// Lines of a label and a content; a line without a label goes on with the one before.
class Lines {
 public:
  void add(std::string_view label, const std::string& content) {
    text_ += fmt::format("{:<10} {}\n", label, content);
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// Of walls that move past each other [nu/W^2].
double shear_rate(const Scenario& scenario) {
  const auto& [low, high] = scenario.channel.wall_velocity;
  return (high - low) / 2;
}

void add_channel(Lines& lines, const Case& given) {
  const auto& [scenario, plan, schedule] = given;
  const ChannelOptions& channel = scenario.channel;
  const auto& nodes = plan.fluid.nodes;
  lines.add("scenario", fmt::format("{}, {} {}", scenario.name, scenario.bodies.size(),
                                    scenario.bodies.size() == 1 ? "body" : "bodies"));
  lines.add("lattice",
            fmt::format("{} x {} x {} = {} nodes{}, {}, W = {} dx", nodes[0], nodes[1], nodes[2],
                        plan.node_count(),
                        channel.symmetry == Symmetry::y ? " at y >= 0, half of the channel" : "",
                        channel.walls == fluid::Boundary::halfway ? "half-way walls"
                                                                  : "regularized walls on nodes",
                        plan.units.half_width()));
  lines.add("",
            fmt::format("half-width along y {:.6g} W, length {:.6g} W",
                        plan.units.length(plan.half_width_y()), plan.units.length(plan.length())));
  lines.add(
      "fluid",
      fmt::format("tau = {}, nu = {:.6g}, {}, {}, {}", plan.fluid.tau, plan.units.viscosity(),
                  plan.fluid.collision == fluid::Collision::bgk
                      ? "bgk"
                      : fmt::format("trt (tau_odd = {:.4g})",
                                    0.5 + plan.fluid.magic / (plan.fluid.tau - 0.5)),
                  plan.fluid.equilibrium == fluid::Equilibrium::incompressible ? "incompressible"
                                                                               : "compressible",
                  precision_text(plan.fluid)));
  lines.add("flow", fmt::format("Re = {}, U_max = {:.6g}, body force {:.6g}, Mach number {:.3f}",
                                channel.reynolds, plan.u_max, plan.fluid.force.z(), plan.mach()));
  if (plan.follow && !plan.bodies.empty()) {
    lines.add("", fmt::format("the lattice goes along with the bodies, at first with {:.4g} nu/W",
                              std::abs(plan.fluid.lattice_velocity) < 1e-12
                                  ? 0.0
                                  : plan.units.velocity(plan.fluid.lattice_velocity)));
  }
  if (const auto& [low, high] = channel.wall_velocity; low != 0 || high != 0) {
    lines.add("", fmt::format("walls at x = -1 and 1 move at {} and {} nu/W, shear rate {:.6g} "
                              "nu/W^2",
                              low, high, shear_rate(scenario)));
  }
  lines.add("time",
            fmt::format("{:.6g} steps per W^2/nu, {} steps until t = {}",
                        plan.units.steps_per_time(), schedule.end, scenario.run.time_limit));
}

void add_capsule(Lines& lines, const BodyOptions& options, const suspension::CapsulePlan& capsule,
                 const StabilityModel* model) {
  const membrane::Moduli& moduli = capsule.moduli;
  lines.add("", fmt::format("La = {}; in lattice units k_s = {:.4g}, k_a = {:.4g}, k_b = {:.4g}, "
                            "k_v = {:.4g}",
                            options.laplace, moduli.k_s, moduli.k_a, moduli.k_b, moduli.k_v));
  const membrane::Scheme& euler = membrane::reference_scheme();
  const membrane::Scheme& scheme = capsule.integrator;
  if (model == nullptr) {
    lines.add("", fmt::format("integrator {}; its stability is not predicted within 0.3 s: add "
                              "--thorough",
                              scheme.name));
    return;
  }
  lines.add("", "stability: " + percentages(model->load(euler.traits.weights), euler.name));
  if (scheme.name != euler.name && !scheme.traits.weights.empty())
    lines.add("", "stability: " + percentages(model->load(scheme.traits.weights), scheme.name));
  lines.add("", fmt::format("integrator {}: {}", scheme.name, judgement(scheme, *model)));
}

/// What shear means for a body: eta rate a/k_s is rate a^2/(nu La), La being k_s a/(rho nu^2).
void add_shear(Lines& lines, const Scenario& scenario, const BodyOptions& body) {
  const double rate = std::abs(shear_rate(scenario));
  if (rate == 0) return;
  const double reynolds = rate * body.radius * body.radius;
  std::string text = fmt::format("in shear: Re_p = rate a^2/nu = {:.4g}", reynolds);
  if (body.kind == BodyKind::capsule) {
    text += body.laplace > 0
                ? fmt::format(", Ca = eta rate a/k_s = {:.4g} (eta rate a/G_s = {:.4g})",
                              reynolds / body.laplace, 3 * reynolds / body.laplace)
                : ", Ca infinite without k_s";
  }
  lines.add("", text);
}

void add_bodies(Lines& lines, const Case& given, StabilityModels& models) {
  for (std::size_t i = 0; i < given.plan.bodies.size(); ++i) {
    const BodyOptions& options = given.scenario.bodies[i];
    const suspension::BodyPlan& body = given.plan.bodies[i];
    const double radius = body.shape->radius();
    const bool sphere = options.shape == "sphere";
    const std::string kind = body.capsule() == nullptr
                                 ? "rigid " + options.shape
                                 : (sphere ? "" : options.shape + " ") + "capsule";
    lines.add("body", fmt::format("{}: {}, a = {:.4g} dx, at ({}, {}, {}) W", body.name, kind,
                                  radius, options.x, options.y, options.z));
    lines.add("", fmt::format("mesh of {} triangles, mean edge of its sphere {:.3g} dx",
                              surface::triangle_count(body.frequency),
                              surface::icosphere_edge(radius, body.frequency)));
    if (const auto* rigid = body.rigid()) {
      const bool solid = rigid->interior == suspension::Interior::solid;
      lines.add("", fmt::format("density ratio {}, {}, {} forcing iterations, memory {}",
                                rigid->density_ratio, solid ? "solid" : "fluid inside",
                                rigid->corrections, rigid->memory));
      lines.add("", fmt::format("markers {:.3g} dx inside of the surface, slip {:.3g} dx: {}",
                                rigid->retraction, rigid->slip,
                                suspension::has_films(body)
                                    ? fmt::format("films between it and its like, which touch at "
                                                  "a roughness of {:g} radii",
                                                  rigid->roughness)
                                    : "no films"));
    } else {
      add_capsule(lines, options, *body.capsule(), models[i]);
    }
    add_shear(lines, given.scenario, options);
  }
}

void add_gaps(Lines& lines, const suspension::Plan& plan) {
  const std::vector<Gap> all = gaps(plan);
  for (const Gap::To to : {Gap::To::wall, Gap::To::body}) {
    const Gap* smallest = nullptr;
    for (const Gap& gap : all) {
      if (gap.to == to && (smallest == nullptr || gap.distance < smallest->distance))
        smallest = &gap;
    }
    if (smallest == nullptr) continue;
    const bool wall = to == Gap::To::wall;
    lines.add("gap",
              fmt::format("{:.4g} dx from {} to {}, the smallest to a {}", smallest->distance,
                          body_name(plan, smallest->body),
                          wall ? wall_name(plan, *smallest) : body_name(plan, smallest->other),
                          wall ? "wall" : "body"));
  }
}

void add_cost(Lines& lines, const Case& given, int cores, const std::optional<KnownSpeed>& known) {
  lines.add("memory",
            fmt::format("{}, {} of it populations", size_text(memory_needed(given).total()),
                        size_text(population_bytes(given.plan))));
  lines.add("disk", fmt::format("{} until the time limit", size_text(disk_needed(given))));
  const KnownSpeed speed = known ? *known : guessed_speed(cores);
  const int most = std::clamp(std::min(cores, speed.ranks), 1, given.plan.fluid.nodes[2]);
  const auto duration = [&](int ranks) {
    const double step = expected_step(given.plan, ranks, speed).total();
    return duration_text(std::max(1.0, step * static_cast<double>(given.schedule.end)));
  };
  const std::string ranks =
      most == 1 ? "1 rank" : fmt::format("{} ranks, {} on 1", most, duration(1));
  lines.add("duration",
            fmt::format("about {} until the time limit on {}, {}", duration(most), ranks,
                        known ? "as `ductile bench` has found here"
                              : "a guess: run `ductile bench` once for a better one"));
  if (given.plan.bodies.empty()) return;
  const StepTime step = expected_step(given.plan, 1, speed);
  const double percent = 100 / step.total();
  lines.add("", fmt::format("of a step on 1 rank the fluid takes {:.0f}%, its nodes around bodies "
                            "{:.0f}% more, bodies {:.0f}%",
                            percent * step.fluid, percent * step.boxes, percent * step.bodies));
}

}  // namespace

std::string report(const Case& given, int cores, const std::optional<KnownSpeed>& known,
                   double patience) {
  StabilityModels models(given.plan, patience);
  Lines lines;
  add_channel(lines, given);
  add_bodies(lines, given, models);
  add_gaps(lines, given.plan);
  add_cost(lines, given, cores, known);
  for (const std::string& note : notes(given)) lines.add("note", note);
  for (const std::string& warning : warnings(given, models)) lines.add("warning", warning);
  if (const std::string lack = memory_lacks(given, {}); !lack.empty()) lines.add("warning", lack);
  return lines.text();
}

}  // namespace ductile::drivers
