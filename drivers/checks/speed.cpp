#include "checks/speed.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "scenario/text.hpp"

namespace ductile::drivers {
namespace {

constexpr double assumed_updates = 30e6;  // node updates a second and core, fluid and bodies

bool single(const suspension::Plan& plan) {
  return plan.fluid.storage == fluid::Storage::single_precision;
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
    stream << fmt::format("machine = {}\nranks = {}\ndouble = {:.6e}\nsingle = {:.6e}\n",
                          in_quotes(machine()), speed.ranks, speed.double_precision,
                          speed.single_precision);
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
    const KnownSpeed speed{text["ranks"].value_or(0), text["double"].value_or(0.0),
                           text["single"].value_or(0.0)};
    if (speed.ranks < 1 || !(speed.double_precision > 0) || !(speed.single_precision > 0)) {
      return std::nullopt;
    }
    return speed;
  } catch (const toml::parse_error&) {
    return std::nullopt;
  }
}

double population_bytes(const suspension::Plan& plan) {
  return 19.0 * (single(plan) ? 4 : 8) * static_cast<double>(plan.node_count());
}

double expected_speed(const suspension::Plan& plan, int cores,
                      const std::optional<KnownSpeed>& known) {
  if (!known) return assumed_updates * std::max(1, cores);
  const double all = single(plan) ? known->single_precision : known->double_precision;
  return all * std::clamp(cores, 1, known->ranks) / known->ranks;
}

double estimated_seconds(const Case& given, double speed) {
  return static_cast<double>(given.plan.node_count()) * static_cast<double>(given.schedule.end) /
         speed;
}

}  // namespace ductile::drivers
