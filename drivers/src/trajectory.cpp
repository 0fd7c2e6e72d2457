#include "trajectory.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "run_directory.hpp"

namespace ductile::drivers {

namespace {

std::string header(const std::vector<std::string>& names, const std::vector<bool>& capsules) {
  std::string line = "t[W^2/nu]";
  const auto columns = [&](const std::string& name,
                           std::initializer_list<std::string_view> quantities) {
    for (const auto quantity : quantities) line += fmt::format(",{}_{}", name, quantity);
  };
  for (const auto& name : names) {
    columns(name, {"x[W]", "y[W]", "z[W]", "vx[nu/W]", "vy[nu/W]", "vz[nu/W]"});
  }
  if (names.size() == 2) line += ",dz[W]";
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (capsules[i]) {
      columns(names[i], {"deformation[1]", "volume_error[1]", "strain_energy[k_s*a^2]"});
    }
    columns(names[i], {"slip[nu/W]"});
  }
  return line;
}

}  // namespace

Trajectory::Trajectory(std::filesystem::path file, std::vector<std::string> names)
    : file_(std::move(file)), names_(std::move(names)) {
  for (const auto& name : names_) check_body_name(name);
  out_.reset(std::fopen(file_.c_str(), "wb"));
  if (!out_) {
    throw OutputError(fmt::format("cannot write {}: {}", file_.string(), std::strerror(errno)));
  }
}

void Trajectory::write(const Sample& sample) {
  std::vector<bool> capsules;
  for (const auto& body : sample.bodies) capsules.push_back(body.capsule);
  if (capsules.size() != names_.size() || (!capsules_.empty() && capsules != capsules_)) {
    throw std::invalid_argument(fmt::format(
        "trajectory of {} bodies: a sample has other bodies than the lines before", names_.size()));
  }
  if (capsules_.empty()) write_line(header(names_, capsules));
  capsules_ = capsules;

  std::string line = fmt::format("{}", sample.time);
  const auto add = [&](double value) { fmt::format_to(std::back_inserter(line), ",{}", value); };
  for (const auto& body : sample.bodies) {
    for (const double value : body.position) add(value);
    for (const double value : body.velocity) add(value);
  }
  if (sample.bodies.size() == 2) add(axial_distance(sample));
  for (const auto& body : sample.bodies) {
    if (body.capsule) {
      add(body.deformation);
      add(body.volume_error);
      add(body.strain_energy);
    }
    add(body.slip);
  }
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
