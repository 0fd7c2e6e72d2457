#include "campaign/directory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "output/file.hpp"
#include "output/json.hpp"
#include "scenario/document.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {

using nlohmann::json;

/// Nothing where there is no such file, or it is no JSON.
json read_json(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return nullptr;
  std::ifstream in(file, std::ios::binary);
  if (!in) return nullptr;
  return json::parse(in, nullptr, false);
}

std::string text(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::optional<double> number(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? std::optional(found->get<double>())
                                                     : std::nullopt;
}

std::string first_line(const fs::path& file) {
  std::string line;
  std::ifstream in(file, std::ios::binary);
  std::getline(in, line);
  return line;
}

/// A value of TOML as a cell: words without their quotes.
std::string cell_of(std::string value) {
  if (value.size() >= 2 && (value.front() == '"' || value.front() == '\''))
    return value.substr(1, value.size() - 2);
  return value;
}

/// RFC 4180.
std::string quoted_cell(const std::string& cell) {
  if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
  std::string text = "\"";
  for (const char c : cell) text += c == '"' ? "\"\"" : std::string(1, c);
  return text + '"';
}

/// A column for each body: key of its object in summary.json, index within it if that is an array,
/// and name and unit here.
struct BodyColumn {
  const char* key;
  int index;
  const char* name;
  const char* unit;
};
constexpr BodyColumn body_columns[] = {
    {"position_W", 0, "x", "W"},
    {"position_W", 1, "y", "W"},
    {"position_W", 2, "z", "W"},
    {"velocity_nu_over_W", 2, "vz", "nu/W"},
    {"x_settled", -1, "x_settled", "1"},
    {"x_limit_W", -1, "x_limit", "W"},
    {"x_limit_error_W", -1, "x_limit_error", "W"},
    {"volume_error_max", -1, "volume_error_max", "1"},
    {"deformation", -1, "deformation", "1"},
    {"strain_energy_over_ks_a2", -1, "strain_energy", "k_s*a^2"},
};

std::string cell_of(const json& body, const BodyColumn& column) {
  auto found = body.find(column.key);
  if (found == body.end()) return "";
  const json* value = &*found;
  if (column.index >= 0) {
    if (!value->is_array() || value->size() != 3) return "";
    value = &(*value)[static_cast<std::size_t>(column.index)];
  }
  if (value->is_boolean()) return value->get<bool>() ? "true" : "false";
  return value->is_number() ? fmt::format("{}", value->get<double>()) : "";
}

std::string cell_of(const std::optional<double>& value) {
  return value ? fmt::format("{}", *value) : "";
}

CaseResult result_of(const CampaignCase& given, const json& summary, const fs::path& run,
                     const fs::path& failure) {
  CaseResult result;
  if (!given.refusal.empty()) {
    result.state = CaseState::refused;
    result.status = "refused";
    result.reason = given.refusal;
    return result;
  }
  std::error_code error;
  if (fs::exists(failure, error)) {
    result.state = CaseState::failed;
    result.status = "failed";
    result.reason = first_line(failure);
  } else if (summary.is_object()) {
    result.status = text(summary, "status");
    result.verdict = text(summary, "verdict");
    result.reason = text(summary, "verdict_reason");
    if (result.reason.empty()) result.reason = text(summary, "contact_reason");
    if (const auto blow_up = summary.find("blow_up"); blow_up != summary.end())
      result.reason = text(*blow_up, "reason");
    result.time = number(summary, "time_W2_over_nu");
    result.dz = number(summary, "dz_W");
    result.state = result.status == "walltime"      ? CaseState::walltime
                   : result.status == "interrupted" ? CaseState::unfinished
                                                    : CaseState::ended;
    if (result.state == CaseState::unfinished) result.status = "unfinished";
  } else if (fs::exists(run / "trajectory.csv", error)) {
    result.state = CaseState::unfinished;
    result.status = "unfinished";
  } else {
    result.status = "waiting";
  }
  return result;
}

}  // namespace

void CampaignDirectory::write(const Campaign& campaign) const {
  Json text;
  text.open('{');
  text.add("campaign", campaign.name);
  text.open('[', "axes");
  for (const std::string& key : campaign.axes) text.add({}, key);
  text.close(']');
  text.open('[', "cases");
  for (const CampaignCase& given : campaign.cases) {
    text.open('{');
    text.add("case", given.name);
    text.add("scenario", given.scenario);
    text.open('[', "values");
    for (const std::string& value : given.values) text.add({}, value);
    text.close(']');
    if (!given.refusal.empty()) text.add("refused", given.refusal);
    text.close('}');
  }
  text.close(']');
  text.close('}');
  write_atomically(index(), text.text(), Durability::system);
}

Campaign CampaignDirectory::read() const {
  std::error_code error;
  if (!fs::is_regular_file(index(), error)) {
    throw InputError(fmt::format(
        "{}: has no campaign.json: give a campaign file, or the directory that one has made",
        path_.string()));
  }
  const json root = read_json(index());
  try {
    Campaign campaign;
    campaign.name = root.at("campaign").get<std::string>();
    campaign.axes = root.at("axes").get<std::vector<std::string>>();
    for (const json& entry : root.at("cases")) {
      CampaignCase& given = campaign.cases.emplace_back();
      given.name = entry.at("case").get<std::string>();
      given.scenario = entry.at("scenario").get<std::string>();
      given.values = entry.at("values").get<std::vector<std::string>>();
      given.refusal = text(entry, "refused");
      if (given.values.size() != campaign.axes.size() ||
          fs::path(given.name).filename() != given.name) {
        throw InputError(fmt::format("{}: case {} is none of a campaign", index().string(),
                                     in_quotes(given.name)));
      }
    }
    return campaign;
  } catch (const json::exception&) {
    throw InputError(
        fmt::format("{}: is not what a campaign has written: lay it out again from "
                    "its file",
                    index().string()));
  }
}

CaseResult CampaignDirectory::result(const CampaignCase& given) const {
  const fs::path directory = run(given.name);
  return result_of(given, read_json(directory / "summary.json"), directory, failure(given.name));
}

void CampaignDirectory::gather(const Campaign& campaign) const {
  std::vector<json> summaries;
  std::vector<std::string> bodies;  // of all cases, as they come
  for (const CampaignCase& given : campaign.cases) {
    const json& summary = summaries.emplace_back(read_json(run(given.name) / "summary.json"));
    if (!summary.is_object() || !summary.contains("bodies")) continue;
    for (const json& body : summary["bodies"]) {
      const std::string name = text(body, "name");
      if (std::ranges::find(bodies, name) == bodies.end()) bodies.push_back(name);
    }
  }
  std::string lines = "case,scenario";
  for (const std::string& key : campaign.axes) lines += ',' + key;
  lines +=
      ",state,verdict,verdict_time[W^2/nu],t[W^2/nu],dz[W],dz_limit[W],"
      "dz_limit_error[W],steps,warnings";
  for (const std::string& body : bodies) {
    for (const BodyColumn& column : body_columns)
      lines += fmt::format(",{}_{}[{}]", body, column.name, column.unit);
  }
  lines += ",reason\n";
  for (std::size_t c = 0; c < campaign.cases.size(); ++c) {
    const CampaignCase& given = campaign.cases[c];
    const json& summary = summaries[c];
    const CaseResult result = result_of(given, summary, run(given.name), failure(given.name));
    std::vector<std::string> cells = {given.name, given.scenario};
    for (const std::string& value : given.values) cells.push_back(cell_of(value));
    cells.push_back(result.status);
    cells.push_back(result.verdict);
    // What a case that failed or is refused has come to before is not what it is now.
    const bool counts = result.state != CaseState::failed && result.state != CaseState::refused;
    const json known = counts && summary.is_object() ? summary : json::object();
    cells.push_back(cell_of(number(known, "verdict_time")));
    cells.push_back(cell_of(result.time));
    cells.push_back(cell_of(result.dz));
    cells.push_back(cell_of(number(known, "dz_limit_W")));
    cells.push_back(cell_of(number(known, "dz_limit_error_W")));
    const auto steps = number(known, "steps");
    cells.push_back(steps ? fmt::format("{:.0f}", *steps) : "");
    const auto warnings = known.find("warnings");
    cells.push_back(warnings != known.end() ? fmt::format("{}", warnings->size()) : "");
    for (const std::string& name : bodies) {
      json own = json::object();
      if (known.contains("bodies")) {
        for (const json& body : known["bodies"])
          if (text(body, "name") == name) own = body;
      }
      for (const BodyColumn& column : body_columns) cells.push_back(cell_of(own, column));
    }
    cells.push_back(result.reason);
    for (std::size_t n = 0; n < cells.size(); ++n)
      lines += (n > 0 ? "," : "") + quoted_cell(cells[n]);
    lines += '\n';
  }
  write_atomically(table(), lines, Durability::system);
}

}  // namespace ductile::drivers
