#include "output/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <functional>
#include <iterator>
#include <span>
#include <stdexcept>
#include <utility>

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

// How many bodies have a distance to the next one ahead.
std::size_t ahead(std::size_t bodies) {
  return bodies > 2 ? bodies : 0;
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
  for (std::size_t b = 0; b < ahead(names.size()); ++b)
    line += fmt::format(",{}_ahead[W]", names[b]);
  line += ",flow_rate[nu*W]";
  columns(false);
  return line;
}

}  // namespace

Trajectory::Trajectory(std::filesystem::path file, std::vector<std::string> names,
                       std::vector<bool> capsules)
    : file_(std::move(file)), names_(std::move(names)), capsules_(std::move(capsules)) {
  check_names();
  out_.emplace(file_);
  write_line(header(names_, capsules_));
}

Trajectory::Trajectory(std::filesystem::path file, std::vector<std::string> names,
                       std::vector<bool> capsules, const Extent& kept,
                       std::vector<suspension::Sample>& samples)
    : file_(std::move(file)), names_(std::move(names)), capsules_(std::move(capsules)) {
  check_names();
  const auto refuse = [this](std::string_view reason) {
    throw std::runtime_error(fmt::format("{} {}", file_.string(), reason));
  };
  std::string text(kept.bytes, '\0');
  std::ifstream in(file_, std::ios::binary);
  if (!in && std::filesystem::exists(file_))
    throw OutputError(fmt::format("cannot read {}", file_.string()));
  if (!in.read(text.data(), static_cast<std::streamsize>(text.size())))
    refuse(fmt::format("has not the {} bytes that the checkpoint has seen in it", kept.bytes));
  checksum_.add(text.data(), text.size());
  if (checksum_.text() != kept.checksum) refuse("has changed since the checkpoint");

  std::string_view rest = text;
  const auto next = [&rest] {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    return line;
  };
  if (next() != header(names_, capsules_)) refuse("has other columns than this run");
  samples.clear();
  while (!rest.empty()) samples.push_back(parsed(next()));
  out_.emplace(file_, kept.bytes);
}

bool Trajectory::is_of(const std::filesystem::path& file, const std::vector<std::string>& names,
                       const std::vector<bool>& capsules) {
  std::ifstream in(file, std::ios::binary);
  std::string line;
  if (!std::getline(in, line)) return true;  // none, or an empty one
  // It may have died in the middle of the header.
  const std::string expected = header(names, capsules);
  return line == expected || (in.eof() && expected.starts_with(line));
}

void Trajectory::check_names() const {
  for (const auto& name : names_) {
    if (!is_name(name))
      throw std::invalid_argument(fmt::format("body name '{}': must be {}", name, name_rule));
  }
}

void Trajectory::write(const suspension::Sample& sample) {
  const auto differs = [](const suspension::BodySample& body, bool capsule) {
    return body.capsule != capsule;
  };
  if (!std::ranges::equal(sample.bodies, capsules_, std::not_fn(differs)) ||
      sample.ahead.size() != ahead(names_.size())) {
    throw std::invalid_argument(fmt::format(
        "trajectory of {} bodies: a sample has other bodies than its header", names_.size()));
  }
  std::string line = fmt::format("{}", sample.time);
  const auto add = [&](double value) { fmt::format_to(std::back_inserter(line), ",{}", value); };
  const auto columns = [&](bool motion) {
    for (const auto& body : sample.bodies) {
      for_group(motion, body.capsule, [&](const Quantity&, std::size_t q) { add(body.values[q]); });
    }
  };
  columns(true);
  if (sample.bodies.size() == 2) add(suspension::axial_distance(sample));
  for (const double distance : sample.ahead) add(distance);
  add(sample.flow_rate);
  columns(false);
  write_line(std::move(line));
}

// The other way round.
suspension::Sample Trajectory::parsed(std::string_view line) const {
  const auto next = [&] {
    double value = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
    if (error != std::errc())
      throw std::runtime_error(fmt::format("{}: '{}' is no number", file_.string(), line));
    const auto used = static_cast<std::size_t>(end - line.data());
    line.remove_prefix(std::min(used + 1, line.size()));
    return value;
  };
  suspension::Sample sample;
  sample.time = next();
  for (const bool capsule : capsules_) {
    sample.bodies.emplace_back();
    sample.bodies.back().capsule = capsule;
  }
  const auto columns = [&](bool motion) {
    for (auto& body : sample.bodies) {
      for_group(motion, body.capsule,
                [&](const Quantity&, std::size_t q) { body.values[q] = next(); });
    }
  };
  columns(true);
  if (capsules_.size() == 2) static_cast<void>(next());  // of the positions
  for (std::size_t b = 0; b < ahead(capsules_.size()); ++b) sample.ahead.push_back(next());
  sample.flow_rate = next();
  columns(false);
  return sample;
}

Trajectory::Extent Trajectory::extent() const {
  return {out_->size(), checksum_.text()};
}

void Trajectory::write_line(std::string line) {
  line += '\n';
  out_->append(line);
  checksum_.add(line.data(), line.size());
}

}  // namespace ductile::drivers
