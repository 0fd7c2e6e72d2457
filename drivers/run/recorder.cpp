#include "run/recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <utility>

#include "run/blow_up.hpp"
#include "scenario/difference.hpp"
#include "scenario/errors.hpp"
#include "scenario/reader.hpp"
#include "scenario/writer.hpp"

namespace ductile::drivers {
namespace {

std::vector<std::string> names(const Scenario& scenario) {
  std::vector<std::string> list;
  for (const BodyOptions& body : scenario.bodies) list.push_back(body.name);
  return list;
}

std::vector<bool> capsules(const Scenario& scenario) {
  std::vector<bool> list;
  for (const BodyOptions& body : scenario.bodies) list.push_back(body.kind == BodyKind::capsule);
  return list;
}

// A part of the recorder's state as numbers, and back.
using Numbers = std::vector<double>;

// A checksum takes two numbers: a double holds 53 bits.
constexpr std::uint64_t low_half = 0xffffffff;
constexpr unsigned half_bits = 32;

Numbers numbers_of(const std::vector<Frame>& frames) {
  Numbers numbers;
  for (const Frame& frame : frames) {
    numbers.insert(numbers.end(), {frame.time, frame.fluid ? 1.0 : 0.0, frame.fluid.value_or(0),
                                   static_cast<double>(frame.checksum >> half_bits),
                                   static_cast<double>(frame.checksum & low_half)});
    for (const Frame::Given& given : frame.bodies)
      numbers.push_back((given.velocity ? 1 : 0) + (given.force ? 2 : 0));
  }
  return numbers;
}

std::vector<Frame> frames_of(const Numbers& numbers, std::size_t bodies) {
  constexpr std::size_t head = 5;
  std::vector<Frame> frames;
  for (std::size_t n = 0; n + head + bodies <= numbers.size(); n += head + bodies) {
    const auto high = static_cast<std::uint64_t>(numbers[n + 3]);
    const auto low = static_cast<std::uint64_t>(numbers[n + 4]);
    Frame& frame =
        frames.emplace_back(Frame{numbers[n], std::nullopt, {}, (high << half_bits) | low});
    if (numbers[n + 1] != 0) frame.fluid = numbers[n + 2];
    for (std::size_t b = 0; b < bodies; ++b) {
      const int given = static_cast<int>(numbers[n + head + b]);
      frame.bodies.push_back({(given & 1) != 0, (given & 2) != 0});
    }
  }
  return frames;
}

constexpr std::size_t crossing = 4;  // added to the number of a kind of gap whose sides cross

Numbers numbers_of(const Contacts& contacts) {
  Numbers numbers;
  for (const Contact& contact : contacts.all()) {
    const suspension::Gap& gap = contact.smallest;
    const std::size_t kind = static_cast<std::size_t>(gap.to) + (gap.crossed ? crossing : 0);
    for (const auto index : {kind, gap.body, gap.other})
      numbers.push_back(static_cast<double>(index));
    numbers.insert(numbers.end(),
                   {static_cast<double>(gap.side), gap.distance, contact.time, contact.since});
  }
  return numbers;
}

Contacts contacts_of(const Numbers& numbers) {
  constexpr std::size_t each = 7;
  std::vector<Contact> contacts;
  for (std::size_t n = 0; n + each <= numbers.size(); n += each) {
    Contact& contact = contacts.emplace_back();
    const auto kind = static_cast<std::size_t>(numbers[n]);
    contact.smallest.to = static_cast<suspension::Gap::To>(kind % crossing);
    contact.smallest.crossed = kind >= crossing;
    contact.smallest.body = static_cast<std::size_t>(numbers[n + 1]);
    contact.smallest.other = static_cast<std::size_t>(numbers[n + 2]);
    contact.smallest.side = static_cast<int>(numbers[n + 3]);
    contact.smallest.distance = numbers[n + 4];
    contact.time = numbers[n + 5];
    contact.since = numbers[n + 6];
  }
  return Contacts(std::move(contacts));
}

constexpr std::size_t numbers_of_leg = 4 + RunProfile::parts;

Numbers numbers_of(const std::vector<Leg>& legs) {
  Numbers numbers;
  for (const Leg& leg : legs) {
    numbers.insert(numbers.end(), {static_cast<double>(leg.from), static_cast<double>(leg.to),
                                   static_cast<double>(leg.ranks), leg.wall_time});
    numbers.insert(numbers.end(), leg.core_time.begin(), leg.core_time.end());
  }
  return numbers;
}

std::vector<Leg> legs_of(const Numbers& numbers) {
  std::vector<Leg> legs;
  for (std::size_t n = 0; n + numbers_of_leg <= numbers.size(); n += numbers_of_leg) {
    Leg& leg = legs.emplace_back();
    leg.from = static_cast<std::int64_t>(numbers[n]);
    leg.to = static_cast<std::int64_t>(numbers[n + 1]);
    leg.ranks = static_cast<int>(numbers[n + 2]);
    leg.wall_time = numbers[n + 3];
    std::copy_n(&numbers[n + 4], RunProfile::parts, leg.core_time.begin());
  }
  return legs;
}

std::string lines(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += text + '\n';
  return all;
}

std::vector<std::string> texts(const std::string& lines) {
  std::vector<std::string> all;
  std::istringstream in(lines);
  for (std::string line; std::getline(in, line);) all.push_back(line);
  return all;
}

/// A checkpoint of a run with another scenario.
struct OtherScenario : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace

Recorder::Recorder(const Case& given, const std::filesystem::path& directory, bool force,
                   const std::string& scenario_text, std::vector<std::string> warnings)
    : given_(given),
      directory_(directory, force),
      log_(std::make_shared<const Log>(directory_.log(), false)),
      scenario_text_(scenario_text),
      judge_(given.scenario.run.stop_distance),
      lateral_(given.plan.bodies.size(), SettlingWatch(rules::lateral)),
      strain_(given.plan.bodies.size(), SettlingWatch(rules::strain)),
      volume_error_(given.plan.bodies.size(), 0.0),
      warnings_(std::move(warnings)) {
  directory_.write_scenario(scenario_text);
  trajectory_.emplace(directory_.trajectory(), names(given.scenario), capsules(given.scenario));
  if (frames_wanted()) make_surfaces({});
}

Recorder::Recorder(const Case& given, const std::filesystem::path& directory,
                   const std::string& scenario_text, const std::vector<std::string>& warnings)
    : given_(given),
      directory_(directory),
      log_(std::make_shared<const Log>(directory_.log(), true)),
      scenario_text_(scenario_text),
      judge_(given.scenario.run.stop_distance),
      lateral_(given.plan.bodies.size(), SettlingWatch(rules::lateral)),
      strain_(given.plan.bodies.size(), SettlingWatch(rules::strain)),
      volume_error_(given.plan.bodies.size(), 0.0) {
  std::vector<std::filesystem::path> refused;
  std::string other;  // what the latest has of another scenario
  for (const auto& file : {directory_.checkpoint(), directory_.checkpoint_before()}) {
    if (!std::filesystem::exists(file)) continue;
    try {
      auto checkpoint = std::make_unique<Checkpoint>(file);
      go_on(*checkpoint);
      checkpoint_ = std::move(checkpoint);
      break;
    } catch (const OtherScenario& difference) {
      if (other.empty()) other = difference.what();
      refused.push_back(file);
    } catch (const OutputError&) {
      throw;
    } catch (const std::runtime_error& reason) {
      say(stderr, "warning: {}\n", reason.what());
      refused.push_back(file);
    }
  }
  if (!checkpoint_ && !other.empty()) {
    throw InputError(fmt::format("{}: {}: of a run that goes on, [run] alone may be another",
                                 directory_.scenario().string(), other));
  }
  if (!other.empty()) {
    say(stderr, "warning: {} is of another run: scenario.toml has {}\n", refused.front().string(),
        other);
  }
  if (!checkpoint_ && !refused.empty()) {
    throw CheckpointError(
        fmt::format("{}: no checkpoint is left that the run could go on from: start it anew with "
                    "`ductile run {} -o DIR`",
                    directory.string(), directory_.scenario().string()));
  }
  const bool begun =
      checkpoint_ ||
      Trajectory::is_of(directory_.trajectory(), names(given.scenario), capsules(given.scenario));
  if (!begun || (!checkpoint_ && std::filesystem::exists(directory_.summary()))) {
    throw InputError(fmt::format(
        "{}: has results, and no checkpoint of a run that could go on: start it anew with "
        "`ductile run {} -o DIR`",
        directory.string(), directory_.scenario().string()));
  }
  // The good one must not give way to a refused one when the next is written.
  for (const auto& file : refused) std::filesystem::rename(file, directory_.checkpoint_refused());
  for (const std::string& warning : warnings) {
    if (std::ranges::find(warnings_, warning) == warnings_.end()) warnings_.push_back(warning);
  }
  // What came of the end before is not true any more.
  std::filesystem::remove(directory_.summary());
  for (const auto& file : directory_.plots()) std::filesystem::remove(file);
  directory_.write_scenario(scenario_text);
  if (checkpoint_) return;
  say(stderr, "{}: has no checkpoint yet, and starts from t = 0\n", directory.string());
  trajectory_.emplace(directory_.trajectory(), names(given.scenario), capsules(given.scenario));
  if (frames_wanted()) make_surfaces({});
}

void Recorder::go_on(const Checkpoint& checkpoint) {
  if (const auto other = difference(
          parse_scenario(Document(checkpoint.text("scenario"), "scenario")), given_.scenario)) {
    throw OtherScenario(*other);
  }
  const Numbers steps = checkpoint.numbers("record/steps");
  if (steps.size() != 2)
    throw CheckpointError(fmt::format("{} has no record/steps", checkpoint.path().string()));
  Course course;
  course.last_row = static_cast<std::int64_t>(steps[0]);
  course.last_frame = static_cast<std::int64_t>(steps[1]);
  course.legs = legs_of(checkpoint.numbers("record/legs"));
  Trajectory::Extent rows;
  std::istringstream(checkpoint.text("record/rows")) >> rows.bytes >> rows.checksum;
  std::vector<Frame> frames =
      frames_of(checkpoint.numbers("record/frames"), given_.plan.bodies.size());
  Contacts contacts = contacts_of(checkpoint.numbers("record/contacts"));
  std::vector<std::string> warnings = texts(checkpoint.text("record/warnings"));
  // All is there, before anything that came later is cut off.
  Surfaces::require(directory_.path(), frames);
  trajectory_.emplace(directory_.trajectory(), names(given_.scenario), capsules(given_.scenario),
                      rows, samples_);
  if (frames_wanted()) {
    make_surfaces(std::move(frames));
  } else {  // a blow-up's
    Surfaces::remove(directory_.path());
  }
  contacts_ = std::move(contacts);
  warnings_ = std::move(warnings);
  course_ = std::move(course);
  for (const suspension::Sample& sample : samples_) judge(sample);
}

void Recorder::save(NewCheckpoint& checkpoint, const Course& course) {
  trajectory_->flush();
  if (surfaces_) surfaces_->flush();
  const Trajectory::Extent rows = trajectory_->extent();
  checkpoint.put("scenario", scenario_text_);
  checkpoint.put("record/steps", Numbers{static_cast<double>(course.last_row),
                                         static_cast<double>(course.last_frame)});
  checkpoint.put("record/legs", numbers_of(course.legs));
  checkpoint.put("record/rows", fmt::format("{} {}", rows.bytes, rows.checksum));
  checkpoint.put("record/frames", surfaces_ ? numbers_of(surfaces_->frames()) : Numbers());
  checkpoint.put("record/contacts", numbers_of(contacts_));
  checkpoint.put("record/warnings", lines(warnings_));
}

void Recorder::write(const Summary& summary) {
  trajectory_->flush();
  if (surfaces_) surfaces_->flush();
  write_summary(directory_.summary(), summary);
}

bool Recorder::frames_wanted() const {
  return given_.schedule.surfaces > 0 || given_.schedule.fields > 0;
}

void Recorder::make_surfaces(std::vector<Frame> frames) {
  const suspension::Plan& plan = given_.plan;
  std::vector<SurfaceMesh> meshes;
  for (const suspension::BodyPlan& body : plan.bodies) {
    surface::Mesh mesh = body.mesh();
    meshes.push_back({body.name, mesh.vertices.size(), std::move(mesh.triangles)});
  }
  FluidLattice lattice;
  for (std::size_t a = 0; a < 3; ++a)
    lattice.nodes[a] = static_cast<std::size_t>(plan.fluid.nodes[a]);
  lattice.origin = plan.units.position(Eigen::Vector3d::Zero());
  lattice.spacing = plan.units.length(1);
  lattice.mirror = plan.fluid.mirror;
  surfaces_.emplace(
      directory_.path(), std::move(meshes),
      Channel{plan.units.length(plan.half_width_y()), plan.units.length(plan.length())}, lattice,
      std::move(frames), system_toml(given_.scenario));
}

Recorder::Finding Recorder::take(const suspension::Sample& sample) {
  warn_of_speed(sample);
  trajectory_->write(sample);
  samples_.push_back(sample);
  judge(sample);
  return found();
}

// Once. What is too fast at the start has been refused.
void Recorder::warn_of_speed(const suspension::Sample& sample) {
  if (sample.mach <= largest_mach ||
      std::ranges::any_of(warnings_, [](const auto& text) { return text.starts_with(too_fast); }))
    return;
  warn(
      fmt::format("{}: at t = {:.4g} bodies or walls are at Mach number {:.2f}, at most {} is "
                  "sound: lower what drives them or fluid.tau, or raise channel.nodes",
                  too_fast, sample.time, sample.mach, largest_mach));
}

void Recorder::judge(const suspension::Sample& sample) {
  for (std::size_t b = 0; b < sample.bodies.size(); ++b) {
    const suspension::BodySample& body = sample.bodies[b];
    lateral_[b].update(sample.time, body["x"]);
    if (!body.capsule) continue;
    strain_[b].update(sample.time, body["strain_energy"]);
    volume_error_[b] = std::max(volume_error_[b], std::abs(body["volume_error"]));
  }
  if (pair()) judge_.update(sample);
}

Recorder::Finding Recorder::found() const {
  if (!pair()) return Finding::go_on;
  if (judge_.parted()) return Finding::too_far;
  return judge_.verdict().decided() && given_.scenario.run.until_decided ? Finding::decided
                                                                         : Finding::go_on;
}

void Recorder::write_frame(double time, const std::vector<suspension::SurfaceState>& surfaces,
                           const suspension::FluidState* fluid) {
  surfaces_->write(time, surfaces, fluid);
}

void Recorder::write_wreck(const suspension::Sample& sample,
                           const std::vector<suspension::SurfaceState>& surfaces,
                           const suspension::FluidState& fluid) {
  if (samples_.empty() || sample.time > samples_.back().time) trajectory_->write(sample);
  if (!surfaces_) make_surfaces({});
  if (surfaces_->frames().empty() || sample.time > surfaces_->frames().back().time)
    surfaces_->write(sample.time, surfaces, &fluid);
}

bool Recorder::take_gaps(double time, const std::vector<suspension::Gap>& gaps) {
  return contacts_.update(time, gaps);
}

void Recorder::warn(const std::string& warning) {
  if (std::ranges::find(warnings_, warning) != warnings_.end()) return;
  say(stderr, "warning: {}\n", warning);
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
  summary.parameters = parameters(given_.scenario);
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
    summary.contacts.push_back({given_.plan.bodies[gap.body].name,
                                gap.to == suspension::Gap::To::body
                                    ? given_.plan.bodies[gap.other].name
                                    : across_name(given_.plan, gap),
                                given_.plan.units.length(gap.distance), gap.distance, contact.time,
                                contact.since, contact.crossed()});
    summary.warnings.push_back(description(given_.plan, contact));
  }
  return summary;
}

}  // namespace ductile::drivers
