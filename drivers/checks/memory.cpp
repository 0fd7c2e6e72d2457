#include "checks/memory.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "checks/advice.hpp"
#include "checks/speed.hpp"
#include "ductile/fluid/mpi.hpp"
#include "ductile/surface/mesh.hpp"

namespace ductile::drivers {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();
constexpr double kilobyte = 1024;

// Measured with heap profiles of runs; upper bounds rather than means.
constexpr double halos = 1.1;         // slabs have planes of their neighbours
constexpr double rigid_vertex = 600;  // bytes
constexpr double explicit_vertex = 2400;
constexpr double implicit_vertex = 12400;  // its tangent has a row of some 40 blocks of 3 x 3
constexpr double kept_node = 32;   // a checkpoint: a population as it comes, put in order, narrow
constexpr double shown_node = 64;  // a frame: density and velocity as they come, and in order

/// The number after `key` in a text of lines; nothing if there is none.
double entry(const std::string& file, const std::string& key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(key)) continue;
    double value = unlimited;
    std::istringstream(line.substr(key.size())) >> value;
    return value;
  }
  return unlimited;
}

double number_in(const std::string& file) {
  double value = unlimited;
  if (!(std::ifstream(file) >> value)) return unlimited;
  return value;
}

/// Of control groups, version 2.
double group_allows() {
  std::ifstream in("/proc/self/cgroup");
  double least = unlimited;
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with("0::")) continue;
    std::string group = "/sys/fs/cgroup" + line.substr(3);
    while (group.size() >= std::string("/sys/fs/cgroup").size()) {
      const double most = number_in(group + "/memory.max");
      if (most < unlimited) {
        least = std::min(least, most - number_in(group + "/memory.current") +
                                    entry(group + "/memory.stat", "inactive_file "));
      }
      group.resize(group.rfind('/'));
    }
  }
  return least;
}

double address_space_allows() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
  return static_cast<double>(limit.rlim_cur) - kilobyte * entry("/proc/self/status", "VmSize:");
}

/// Without what cannot be read there is no limit.
double known(double bytes) {
  return std::isfinite(bytes) ? std::max(0.0, bytes) : unlimited;
}

// Force, velocity, momentum and density, in the precision of arithmetic.
double box_node(const suspension::Plan& plan) {
  const bool single = plan.fluid.arithmetic == fluid::Precision::single_precision;
  return static_cast<double>(10 * (single ? sizeof(float) : sizeof(double)));
}

double of_body(const suspension::BodyPlan& body, double node) {
  const auto vertices = static_cast<double>(surface::vertex_count(body.frequency));
  const BoxSize box = box_around(body);
  double each = rigid_vertex;
  if (const suspension::CapsulePlan* capsule = body.capsule())
    each = capsule->integrator.traits.weights.empty() ? implicit_vertex : explicit_vertex;
  constexpr double padding = 8;  // planes beside a row's own
  return vertices * each + box.rows * (box.length + padding) * node;
}

}  // namespace

MemoryNeed memory_needed(const Case& given) {
  const suspension::Plan& plan = given.plan;
  MemoryNeed need;
  need.shared = halos * population_bytes(plan);
  for (const suspension::BodyPlan& body : plan.bodies) need.shared += of_body(body, box_node(plan));
  need.gathered =
      static_cast<double>(plan.node_count()) * (given.schedule.fields > 0 ? shown_node : kept_node);
  return need;
}

Ranks ranks_of(MPI_Comm comm) {
  using fluid::mpi_check;
  Ranks ranks;
  MPI_Comm here = MPI_COMM_NULL;
  mpi_check(MPI_Comm_size(comm, &ranks.all), "MPI_Comm_size");
  mpi_check(MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here),
            "MPI_Comm_split_type");
  mpi_check(MPI_Comm_size(here, &ranks.here), "MPI_Comm_size");
  mpi_check(MPI_Comm_free(&here), "MPI_Comm_free");
  return ranks;
}

double free_memory() {
  return std::min(known(kilobyte * entry("/proc/meminfo", "MemAvailable:")), known(group_allows()));
}

std::string memory_lacks(const Case& given, const Ranks& ranks) {
  const MemoryNeed need = memory_needed(given);
  const double here = need.shared * ranks.here / ranks.all + need.gathered;
  const double of_one = need.shared / ranks.all + need.gathered;
  const double free_here = free_memory();
  const double free_to_one = known(address_space_allows());
  if (here <= free_here && of_one <= free_to_one) return "";
  const bool machine = here > free_here;
  return fmt::format(
      "the run needs {} of memory {}, which may take {}: take fewer nodes, fluid.storage = "
      "\"single\", or more machines",
      size_text(machine ? here : of_one), machine ? "on this machine" : "in the first rank",
      size_text(machine ? free_here : free_to_one));
}

}  // namespace ductile::drivers
