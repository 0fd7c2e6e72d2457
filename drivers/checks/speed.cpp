#include "checks/speed.hpp"

#include <fmt/format.h>
#include <sched.h>
#include <toml++/toml.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include "ductile/rigid/body.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {
namespace {

// A name in the file and where its number goes.
struct Entry {
  const char* name;
  double* value;
};

std::array<Entry, 14> entries(KnownSpeed& speed) {
  BodyCosts& bodies = speed.bodies;
  return {{{"double", &speed.fluid.double_precision},
           {"single_storage", &speed.fluid.single_storage},
           {"single", &speed.fluid.single_precision},
           {"double_alone", &speed.alone.double_precision},
           {"single_storage_alone", &speed.alone.single_storage},
           {"single_alone", &speed.alone.single_precision},
           {"row", &bodies.row},
           {"node", &bodies.node},
           {"node_read", &bodies.node_read},
           {"node_update", &bodies.node_update},
           {"marker", &bodies.marker},
           {"marker_pass", &bodies.marker_pass},
           {"implicit", &bodies.implicit},
           {"stiff", &bodies.stiff}}};
}

std::filesystem::path speed_file() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && *cache != '\0') {
    return std::filesystem::path(cache) / "ductile" / "bench.toml";
  }
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0') return {};
  return std::filesystem::path(home) / ".cache" / "ductile" / "bench.toml";
}

// A home may be shared by several machines.
std::string machine() {
  std::array<char, 256> name{};
  if (gethostname(name.data(), name.size() - 1) != 0) return "";
  return name.data();
}

}  // namespace

std::optional<std::string> keep_speed(const KnownSpeed& speed) {
  const std::filesystem::path file = speed_file();
  if (file.empty()) return std::nullopt;
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  // Whole or not at all.
  const std::filesystem::path draft = file.string() + "." + std::to_string(getpid());
  {
    std::ofstream stream(draft);
    stream << fmt::format("machine = {}\nranks = {}\n", in_quotes(machine()), speed.ranks);
    KnownSpeed kept = speed;
    for (const auto& [name, value] : entries(kept))
      stream << fmt::format("{} = {:.6e}\n", name, *value);
    stream.close();
    if (!stream) {
      std::filesystem::remove(draft, error);
      return std::nullopt;
    }
  }
  std::filesystem::rename(draft, file, error);
  if (error) {
    std::filesystem::remove(draft, error);
    return std::nullopt;
  }
  return file.string();
}

std::optional<KnownSpeed> known_speed() {
  const std::filesystem::path file = speed_file();
  std::error_code error;
  if (file.empty() || !std::filesystem::is_regular_file(file, error)) return std::nullopt;
  try {
    const toml::table text = toml::parse_file(file.string());
    if (text["machine"].value_or<std::string>("") != machine()) return std::nullopt;
    KnownSpeed speed;
    speed.ranks = text["ranks"].value_or(0);
    if (speed.ranks < 1) return std::nullopt;
    for (const auto& [name, value] : entries(speed)) {
      *value = text[name].value_or(-1.0);
      if (!(*value >= 0)) return std::nullopt;
    }
    for (const FluidSpeed& fluid : {speed.fluid, speed.alone}) {
      if (!(fluid.double_precision > 0) || !(fluid.single_storage > 0) ||
          !(fluid.single_precision > 0))
        return std::nullopt;
    }
    return speed;
  } catch (const toml::parse_error&) {
    return std::nullopt;
  }
}

double population_bytes(const suspension::Plan& plan) {
  const bool single = plan.fluid.storage == fluid::Precision::single_precision;
  return 19.0 * (single ? 4 : 8) * static_cast<double>(plan.node_count());
}

BoxSize box_around(const suspension::BodyPlan& body) {
  // The kernel's reach, and the margin that fluid::Fluid::box_around() leaves.
  constexpr double across = 6;
  constexpr double along = 8;
  const auto width = [&body](int axis) {
    return std::ceil(2 *
                     body.shape->extent(body.rotation.transpose() * Eigen::Vector3d::Unit(axis)));
  };
  return {(width(0) + across) * (width(1) + across), width(2) + along};
}

int core_count() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof(set), &set) == 0 ? std::max(1, CPU_COUNT(&set)) : 1;
}

KnownSpeed guessed_speed(int cores) {
  KnownSpeed guess;
  guess.ranks = std::max(1, cores);
  guess.alone = {40e6, 50e6, 80e6};
  guess.fluid = {guess.alone.double_precision * guess.ranks,
                 guess.alone.single_storage * guess.ranks,
                 guess.alone.single_precision * guess.ranks};
  guess.bodies = {500e-9, 10e-9, 30e-9, 10e-9, 700e-9, 250e-9, 3e-6, 0.5e-6};
  return guess;
}

namespace {

double updates(const suspension::Plan& plan, int ranks, const KnownSpeed& speed) {
  const auto of = [&plan](FluidSpeed fluid) { return fluid.of(plan.fluid); };
  if (ranks >= speed.ranks) return of(speed.fluid);  // more were not measured
  const double share = (ranks - 1.0) / (speed.ranks - 1.0);
  return of(speed.alone) + share * (of(speed.fluid) - of(speed.alone));
}

// How many rounds of corrections the body asks for.
int rounds(const suspension::BodyPlan& body) {
  if (const auto* rigid = body.rigid()) return rigid->corrections;
  return body.capsule()->integrator.traits.weights.empty() ? 2 : 0;
}

double marker_time(const suspension::BodyPlan& body, const BodyCosts& costs) {
  if (const auto* rigid = body.rigid()) {
    const long long count =
        rigid->interior == suspension::Interior::solid
            ? rigid::lined_marker_count(*body.shape, body.frequency, rigid->retraction)
            : surface::vertex_count(body.frequency);
    return static_cast<double>(count) * costs.marker_pass * (rigid->corrections + 1);
  }
  const auto markers = static_cast<double>(surface::vertex_count(body.frequency));
  const suspension::CapsulePlan& capsule = *body.capsule();
  const membrane::SchemeTraits& traits = capsule.integrator.traits;
  if (!traits.weights.empty()) return markers * costs.marker;
  // Krylov iterations go as the root of the stiffness. Of another scheme that solves, its work over
  // the implicit one's is known.
  const double solve = costs.implicit + costs.stiff * std::sqrt(capsule.moduli.k_s) - costs.marker;
  const double share = traits.cost / membrane::find_scheme("implicit").traits.cost;
  return markers *
         (costs.marker + std::max(0.0, solve) * share * capsule.integrator_options.substeps);
}

}  // namespace

StepTime expected_step(const suspension::Plan& plan, int ranks, const KnownSpeed& speed) {
  StepTime time;
  const auto nodes = static_cast<double>(plan.node_count());
  time.fluid = nodes / updates(plan, ranks, speed);
  double box_rows = 0;
  double box_nodes = 0;
  int most = 0;
  const std::vector<int> owner = suspension::owners(plan, ranks);
  std::vector<double> work(static_cast<std::size_t>(ranks));
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const BoxSize box = box_around(plan.bodies[b]);
    box_rows += box.rows;
    box_nodes += box.rows * box.length;
    most = std::max(most, rounds(plan.bodies[b]));
    work[static_cast<std::size_t>(owner[b])] += marker_time(plan.bodies[b], speed.bodies);
  }
  const BodyCosts& costs = speed.bodies;
  // They are measured in single precision, and what boxes hold takes twice that in double.
  const double bytes = plan.fluid.arithmetic == fluid::Precision::single_precision ? 1 : 2;
  const double node =
      bytes * (costs.node + (most > 0 ? costs.node_read + most * costs.node_update : 0));
  // Boxes that overlap are one: there are no more nodes in them than in all.
  const double share = std::min(1.0, nodes / std::max(1.0, box_nodes));
  time.boxes = share * (box_rows * costs.row + box_nodes * node) / ranks;
  time.bodies = *std::ranges::max_element(work);
  return time;
}

}  // namespace ductile::drivers
