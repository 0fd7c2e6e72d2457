#include "run/recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace ductile::drivers {
namespace {

std::vector<std::string> names(const Scenario& scenario) {
  std::vector<std::string> list;
  for (const BodyOptions& body : scenario.bodies) list.push_back(body.name);
  return list;
}

/// Nothing where no frames are asked for.
std::optional<Surfaces> make_surfaces(const Case& given, const std::filesystem::path& directory) {
  const auto& [scenario, plan, schedule] = given;
  if (schedule.surfaces == 0 && schedule.fields == 0) return std::nullopt;
  std::vector<SurfaceMesh> meshes;
  for (const suspension::BodyPlan& body : plan.bodies) {
    surface::Mesh mesh = body.mesh();
    meshes.push_back({body.name, mesh.vertices.size(), std::move(mesh.triangles)});
  }
  std::optional<FluidLattice> lattice;
  if (schedule.fields > 0) {
    lattice.emplace();
    for (std::size_t a = 0; a < 3; ++a) {
      lattice->nodes[a] = static_cast<std::size_t>(plan.fluid.nodes[a]);
    }
    lattice->origin = plan.units.position(Eigen::Vector3d::Zero());
    lattice->spacing = plan.units.length(1);
    lattice->mirror = plan.fluid.mirror;
  }
  return std::optional<Surfaces>(
      std::in_place, directory, std::move(meshes),
      Channel{plan.units.length(plan.half_width_y()), plan.units.length(plan.length())}, lattice);
}

}  // namespace

Recorder::Recorder(const Case& given, const std::filesystem::path& directory, bool force,
                   const std::string& scenario_text, std::vector<std::string> warnings)
    : given_(given),
      directory_(directory, force),
      trajectory_(directory_.trajectory(), names(given.scenario)),
      judge_(given.scenario.run.stop_distance),
      lateral_(given.plan.bodies.size(), SettlingWatch(rules::lateral)),
      strain_(given.plan.bodies.size(), SettlingWatch(rules::strain)),
      volume_error_(given.plan.bodies.size(), 0.0),
      warnings_(std::move(warnings)) {
  directory_.write_scenario(scenario_text);
  surfaces_ = make_surfaces(given, directory);
}

Recorder::Finding Recorder::take(const suspension::Sample& sample) {
  trajectory_.write(sample);
  samples_.push_back(sample);
  for (std::size_t b = 0; b < sample.bodies.size(); ++b) {
    const suspension::BodySample& body = sample.bodies[b];
    lateral_[b].update(sample.time, body["x"]);
    if (!body.capsule) continue;
    strain_[b].update(sample.time, body["strain_energy"]);
    volume_error_[b] = std::max(volume_error_[b], std::abs(body["volume_error"]));
  }
  if (!pair()) return Finding::go_on;
  judge_.update(sample);
  if (judge_.parted()) return Finding::too_far;
  return judge_.verdict().decided() && given_.scenario.run.until_decided ? Finding::decided
                                                                         : Finding::go_on;
}

void Recorder::write_frame(double time, const std::vector<suspension::SurfaceState>& surfaces,
                           const suspension::FluidState* fluid) {
  surfaces_->write(time, surfaces, fluid);
}

bool Recorder::take_gaps(double time, const std::vector<suspension::Gap>& gaps) {
  return contacts_.update(time, gaps);
}

void Recorder::warn(const std::string& warning) {
  fmt::print(stderr, "warning: {}\n", warning);
  warnings_.push_back(warning);
}

CapsuleSummary Recorder::summarise_capsule(std::size_t body,
                                           const membrane::SolveStatistics& solver,
                                           std::vector<std::string>& warnings) const {
  const suspension::BodySample& sample = samples_.back().bodies[body];
  const BodyOptions& options = given_.scenario.bodies[body];
  CapsuleSummary capsule;
  capsule.k_v = options.membrane.volume_modulus;
  capsule.volume_error_max = volume_error_[body];
  capsule.deformation = sample["deformation"];
  capsule.strain_energy = sample["strain_energy"];
  capsule.strain = strain_[body].outlook();
  capsule.solver = solver;
  if (capsule.volume_error_max > 0.01) {
    warnings.push_back("the volume of " + options.name +
                       " changed by more than 1%; raise volume_modulus");
  }
  // An oscillating pair's strain swings along.
  const PairClass verdict = judge_.verdict().pair_class;
  const bool swings = pair() && (verdict == PairClass::damped || verdict == PairClass::bounded);
  if (capsule.strain && !capsule.strain->settled && !swings) {
    warnings.push_back("the strain energy of " + options.name +
                       (capsule.strain->rate > 0 ? " still grows" : " still falls") +
                       "; see doc/equations.md on the mobility");
  }
  return capsule;
}

Summary Recorder::summarise(RunStatus status,
                            const std::vector<membrane::SolveStatistics>& solvers) const {
  const suspension::Sample& last = samples_.back();
  Summary summary;
  summary.warnings = warnings_;
  summary.scenario = given_.scenario.name;
  summary.status = status;
  if (pair()) {
    summary.verdict = judge_.verdict();
    summary.dz = axial_distance(last);
    const double length = given_.plan.units.length(given_.plan.length());
    if (judge_.verdict().decided() && judge_.verdict().pair_class != PairClass::unstable &&
        std::abs(*summary.dz) > 0.5 * length) {
      summary.warnings.emplace_back(
          "dz is beyond half of the channel's length, where the nearest neighbour is a periodic "
          "image; use a longer channel");
    }
  }
  for (std::size_t b = 0; b < last.bodies.size(); ++b) {
    BodySummary body;
    body.name = given_.scenario.bodies[b].name;
    body.position = last.bodies[b].position();
    body.velocity = last.bodies[b].velocity();
    body.lateral = lateral_[b].outlook();
    if (last.bodies[b].capsule) body.capsule = summarise_capsule(b, solvers[b], summary.warnings);
    summary.bodies.push_back(std::move(body));
  }
  for (const Contact& contact : contacts_.all()) {
    const suspension::Gap& gap = contact.smallest;
    const double distance = std::max(0.0, gap.distance);
    summary.contacts.push_back({given_.plan.bodies[gap.body].name,
                                gap.to == suspension::Gap::To::body
                                    ? given_.plan.bodies[gap.other].name
                                    : across_name(given_.plan, gap),
                                given_.plan.units.length(distance), distance, contact.time,
                                contact.since, contact.crossed()});
    summary.warnings.push_back(description(given_.plan, contact));
  }
  return summary;
}

}  // namespace ductile::drivers
