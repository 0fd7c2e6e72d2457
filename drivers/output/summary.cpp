#include "output/summary.hpp"

#include <fmt/format.h>

#include "output/file.hpp"
#include "output/json.hpp"

namespace ductile::drivers {

namespace {

std::optional<bool> settled(const std::optional<Outlook>& outlook) {
  return outlook ? std::optional(outlook->settled) : std::nullopt;
}

std::optional<double> rate(const std::optional<Outlook>& outlook) {
  return outlook ? std::optional(outlook->rate) : std::nullopt;
}

/// Where it heads for, if it heads anywhere.
std::optional<double> limit(const std::optional<Outlook>& outlook) {
  return outlook && outlook->state != Outlook::State::moving ? std::optional(outlook->limit)
                                                             : std::nullopt;
}

std::optional<double> error(const std::optional<Outlook>& outlook) {
  return limit(outlook) ? std::optional(outlook->error) : std::nullopt;
}

void add_body(Json& json, const BodySummary& body, std::int64_t steps) {
  json.open('{');
  json.add("name", body.name);
  json.add("position_W", body.position);
  json.add("velocity_nu_over_W", body.velocity);
  json.add("x_settled", settled(body.lateral));
  json.add("x_limit_W", limit(body.lateral));
  json.add("x_limit_error_W", error(body.lateral));
  json.add("x_rate_nu_over_W", rate(body.lateral));
  if (body.capsule) {
    const CapsuleSummary& capsule = *body.capsule;
    json.add("k_v_rho_nu2_over_W2", capsule.k_v);
    json.add("volume_error_max", capsule.volume_error_max);
    json.add("deformation", capsule.deformation);
    json.add("strain_energy_over_ks_a2", capsule.strain_energy);
    json.add("strain_energy_settled", settled(capsule.strain));
    json.add("strain_energy_rate", rate(capsule.strain));
    add_solver(json, capsule.solver, steps);
  }
  json.close('}');
}

void add_contact(Json& json, const ContactSummary& contact) {
  json.open('{');
  json.add("body", contact.body);
  json.add("other", contact.other);
  json.add("gap_W", contact.gap);
  json.add("gap_dx", contact.gap_nodes);
  json.add("time_W2_over_nu", contact.time);
  json.add("since_W2_over_nu", contact.since);
  json.add("crossed", contact.crossed);
  json.close('}');
}

}  // namespace

std::string_view to_string(RunStatus status) {
  switch (status) {
    case RunStatus::finished:
      return "finished";
    case RunStatus::decided:
      return "decided";
    case RunStatus::stop_distance:
      return "stopped at dz";
    case RunStatus::contact:
      return "contact";
    case RunStatus::time_limit:
      return "time limit";
    case RunStatus::interrupted:
      return "interrupted";
    case RunStatus::walltime:
      return "walltime";
    case RunStatus::blew_up:
      break;
  }
  return "blew up";
}

void add_blow_up(Json& json, const BlowUp& blow_up) {
  json.open('{', "blow_up");
  json.add("step", blow_up.step);
  json.add("body", blow_up.body.empty() ? "fluid" : blow_up.body);
  json.add("vertex", blow_up.vertex);
  json.add("place_W", blow_up.place);
  json.add("reason", blow_up.reason);
  json.add("likely_cause", blow_up.cause);
  json.close('}');
}

void add_solver(Json& json, const membrane::SolveStatistics& solver, std::int64_t steps) {
  if (solver.solves == 0) return;
  const auto per_step = [steps](std::int64_t count) {
    return static_cast<double>(count) / static_cast<double>(steps);
  };
  json.open('{', "solver");
  json.add("solves", solver.solves);
  json.add("newton_iterations", solver.newton_iterations);
  json.add("krylov_iterations", solver.krylov_iterations);
  json.add("newton_iterations_per_step", per_step(solver.newton_iterations));
  json.add("krylov_iterations_per_step", per_step(solver.krylov_iterations));
  json.add("tangents", solver.tangents);
  json.add("step_cuts", solver.step_cuts);
  json.close('}');
}

std::string to_json(const Summary& summary) {
  Json json;
  json.open('{');
  json.add("scenario", summary.scenario);
  json.add("status", to_string(summary.status));
  if (summary.blow_up) add_blow_up(json, *summary.blow_up);
  if (!summary.contact_reason.empty()) json.add("contact_reason", summary.contact_reason);
  if (summary.verdict) {
    json.add("verdict", to_string(summary.verdict->pair_class));
    json.add("verdict_reason", summary.verdict->reason);
    json.add("verdict_time", summary.verdict->time);
  }
  if (summary.dz) json.add("dz_W", *summary.dz);
  if (summary.verdict) {
    json.add("dz_limit_W", limit(summary.verdict->distance));
    json.add("dz_limit_error_W", error(summary.verdict->distance));
  }
  json.add("time_W2_over_nu", summary.time);
  json.add("steps", summary.steps);
  json.open('[', "bodies");
  for (const auto& body : summary.bodies) add_body(json, body, summary.steps);
  json.close(']');
  json.open('[', "contacts");
  for (const auto& contact : summary.contacts) add_contact(json, contact);
  json.close(']');
  json.open('[', "warnings");
  for (const auto& warning : summary.warnings) json.add({}, warning);
  json.close(']');
  json.open('{', "parameters");
  for (const auto& [key, value] : summary.parameters) json.add_json(key, value);
  json.close('}');
  json.add("wall_time_s", summary.wall_time);
  json.add("updates_per_second", summary.updates_per_second);
  json.add("ranks", summary.ranks);
  json.open('[', "legs");
  for (const Leg& leg : summary.legs) add_leg(json, leg);
  json.close(']');
  if (summary.profile) {
    json.open('{', "profile");
    add_profile(json, *summary.profile);
    json.close('}');
  }
  json.open('{', "versions");
  for (const auto& [name, version] : summary.versions) json.add(name, version);
  json.close('}');
  json.close('}');
  return json.text();
}

void write_summary(const std::filesystem::path& file, const Summary& summary) {
  write_atomically(file, to_json(summary), Durability::system);
}

}  // namespace ductile::drivers
