#include "output/trajectory.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <span>
#include <stdexcept>
#include <utility>

#include "output/run_directory.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {

namespace {

using suspension::quantities;
using suspension::Quantity;

// Calls f(quantity, index) for the quantities of a row's group that apply to the body: the first of
// all bodies come before what belongs to none, the rest after it.
template <class F>
void for_group(bool motion, bool capsule, const F& f) {
  const std::span<const Quantity> all = quantities();
  const std::size_t begin = motion ? 0 : suspension::motion_quantities;
  const std::size_t end = motion ? suspension::motion_quantities : all.size();
  for (std::size_t q = begin; q < end; ++q) {
    if (all[q].applies(capsule)) f(all[q], q);
  }
}

std::string header(const std::vector<std::string>& names, const std::vector<bool>& capsules) {
  std::string line = "t[W^2/nu]";
  const auto columns = [&](bool motion) {
    for (std::size_t b = 0; b < names.size(); ++b) {
      for_group(motion, capsules[b], [&](const Quantity& quantity, std::size_t) {
        line += fmt::format(",{}_{}[{}]", names[b], quantity.name, quantity.unit);
      });
    }
  };
  columns(true);
  if (names.size() == 2) line += ",dz[W]";
  columns(false);
  return line;
}

}  // namespace

Trajectory::Trajectory(std::filesystem::path file, std::vector<std::string> names)
    : file_(std::move(file)), names_(std::move(names)) {
  for (const auto& name : names_) {
    if (!is_name(name))
      throw std::invalid_argument(fmt::format("body name '{}': must be {}", name, name_rule));
  }
  out_.reset(std::fopen(file_.c_str(), "wb"));
  if (!out_) {
    throw OutputError(fmt::format("cannot write {}: {}", file_.string(), std::strerror(errno)));
  }
}

void Trajectory::write(const suspension::Sample& sample) {
  std::vector<bool> capsules;
  for (const auto& body : sample.bodies) capsules.push_back(body.capsule);
  if (capsules.size() != names_.size() || (capsules_ && capsules != *capsules_)) {
    throw std::invalid_argument(fmt::format(
        "trajectory of {} bodies: a sample has other bodies than the lines before", names_.size()));
  }
  if (!capsules_) write_line(header(names_, capsules));
  capsules_ = capsules;

  std::string line = fmt::format("{}", sample.time);
  const auto add = [&](double value) { fmt::format_to(std::back_inserter(line), ",{}", value); };
  const auto columns = [&](bool motion) {
    for (const auto& body : sample.bodies) {
      for_group(motion, body.capsule, [&](const Quantity&, std::size_t q) { add(body.values[q]); });
    }
  };
  columns(true);
  if (sample.bodies.size() == 2) add(suspension::axial_distance(sample));
  columns(false);
  write_line(std::move(line));
}

void Trajectory::write_line(std::string line) {
  line += '\n';
  if (std::fwrite(line.data(), 1, line.size(), out_.get()) != line.size() ||
      std::fflush(out_.get()) != 0) {
    throw OutputError(fmt::format("cannot write {}: {}", file_.string(), std::strerror(errno)));
  }
}

}  // namespace ductile::drivers
