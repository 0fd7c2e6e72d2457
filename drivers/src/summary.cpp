#include "summary.hpp"

#include <fmt/format.h>

#include <cmath>
#include <concepts>

#include "run_directory.hpp"

namespace ductile::drivers {

namespace {

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

/// Text of JSON, made piece by piece; commas, line breaks and indents are its own affair.
class Json {
 public:
  void open(char bracket, std::string_view key = {}) {
    begin(key);
    text_ += bracket;
    ++depth_;
    empty_ = true;
  }
  void close(char bracket) {
    --depth_;
    if (!empty_) new_line();
    text_ += bracket;
    empty_ = false;
  }
  void add(std::string_view key, std::string_view value) { put(key, quoted(value)); }
  void add(std::string_view key, std::integral auto value) { put(key, fmt::format("{}", value)); }
  void add(std::string_view key, double value) { put(key, number(value)); }
  void add(std::string_view key, const Eigen::Vector3d& v) {
    put(key, fmt::format("[{}, {}, {}]", number(v.x()), number(v.y()), number(v.z())));
  }
  template <typename T>
  void add(std::string_view key, const std::optional<T>& value) {
    value ? add(key, *value) : put(key, "null");
  }
  [[nodiscard]] std::string text() const { return text_ + '\n'; }

 private:
  static std::string number(double value) {
    return std::isfinite(value) ? fmt::format("{}", value) : "null";
  }
  void new_line() { text_ += '\n' + std::string(2 * depth_, ' '); }
  void begin(std::string_view key) {
    if (!empty_) text_ += ',';
    if (depth_ > 0) new_line();
    if (!key.empty()) text_ += quoted(key) + ": ";
    empty_ = false;
  }
  void put(std::string_view key, std::string_view value) {
    begin(key);
    text_ += value;
  }

  std::string text_;
  std::size_t depth_ = 0;
  bool empty_ = true;
};

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

void add_body(Json& json, const BodySummary& body) {
  json.open('{');
  json.add("name", body.name);
  json.add("position_W", body.position);
  json.add("velocity_nu_over_W", body.velocity);
  json.add("x_settled", settled(body.lateral));
  json.add("x_limit_W", limit(body.lateral));
  json.add("x_rate_nu_over_W", rate(body.lateral));
  if (body.capsule) {
    const CapsuleSummary& capsule = *body.capsule;
    json.add("k_v_rho_nu2_over_W2", capsule.k_v);
    json.add("volume_error_max", capsule.volume_error_max);
    json.add("deformation", capsule.deformation);
    json.add("strain_energy_over_ks_a2", capsule.strain_energy);
    json.add("strain_energy_settled", settled(capsule.strain));
    json.add("strain_energy_rate", rate(capsule.strain));
  }
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
    case RunStatus::time_limit:
      return "time limit";
    case RunStatus::interrupted:
      return "interrupted";
    case RunStatus::blew_up:
      break;
  }
  return "blew up";
}

std::string to_json(const Summary& summary) {
  Json json;
  json.open('{');
  json.add("scenario", summary.scenario);
  json.add("status", to_string(summary.status));
  if (summary.blow_up) {
    json.open('{', "blow_up");
    json.add("step", summary.blow_up->step);
    json.add("body", summary.blow_up->body.empty() ? "fluid" : summary.blow_up->body);
    json.add("vertex", summary.blow_up->vertex);
    json.add("reason", summary.blow_up->reason);
    json.close('}');
  }
  if (summary.verdict) {
    json.add("verdict", to_string(summary.verdict->pair_class));
    json.add("verdict_reason", summary.verdict->reason);
    json.add("verdict_time", summary.verdict->time);
  }
  if (summary.dz) json.add("dz_W", *summary.dz);
  json.add("time_W2_over_nu", summary.time);
  json.add("steps", summary.steps);
  json.open('[', "bodies");
  for (const auto& body : summary.bodies) add_body(json, body);
  json.close(']');
  json.open('[', "warnings");
  for (const auto& warning : summary.warnings) json.add({}, warning);
  json.close(']');
  json.add("wall_time_s", summary.wall_time);
  json.add("updates_per_second", summary.updates_per_second);
  json.add("ranks", summary.ranks);
  json.open('{', "versions");
  for (const auto& [name, version] : summary.versions) json.add(name, version);
  json.close('}');
  json.close('}');
  return json.text();
}

void write_summary(const std::filesystem::path& file, const Summary& summary) {
  write_atomically(file, to_json(summary));
}

}  // namespace ductile::drivers
