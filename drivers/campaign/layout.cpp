#include "campaign/layout.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string_view>

#include "checks/read_case.hpp"
#include "output/file.hpp"
#include "output/run_directory.hpp"
#include "scenario/difference.hpp"
#include "scenario/writer.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {

/// What a case's directory is to become.
enum class Change {
  none,
  limits,  // another [run], by which no end is another
  end,     // another [run], with which what there is may go on
  anew
};

/// Whether an end that the limits have made may be another now.
bool ends_otherwise(const RunLimits& before, const RunLimits& now) {
  return before.time_limit != now.time_limit || before.stop_distance != now.stop_distance ||
         before.until_decided != now.until_decided || before.stop_at_contact != now.stop_at_contact;
}

Change change_of(const CampaignDirectory& directory, const ReadCase& read, bool force) {
  const fs::path run = directory.run(read.entry.name);
  const fs::path file = run / "scenario.toml";
  std::error_code error;
  if (!fs::exists(file, error)) {
    require_free(run, force);
    return Change::anew;
  }
  const Scenario& now = read.given->scenario;
  std::optional<std::string> other;
  try {
    const Scenario before = parse_case(read_text(file), file.string()).scenario;
    if (before == now) return Change::none;
    other = difference(before, now);
    if (!other) {
      // A run that blew up does so again.
      const bool reopens =
          ends_otherwise(before.run, now.run) && directory.result(read.entry).status != "blew up";
      return reopens ? Change::end : Change::limits;
    }
  } catch (const InputError& unreadable) {
    other = unreadable.what();
  }
  const bool begun = directory.result(read.entry).state != CaseState::waiting;
  if (force || !begun) return Change::anew;
  throw InputError(
      fmt::format("{}: {}: add --force to replace it, or choose another directory with -o",
                  run.string(), *other));
}

void make_directory(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) fail_to_write(path, error.value());
}

}  // namespace

std::vector<ReadCase> read_cases(const Sweep& sweep) {
  std::vector<ReadCase> cases;
  std::string first;
  bool any = false;
  for (const SweptCase& swept : sweep.cases) {
    ReadCase& read = cases.emplace_back();
    read.entry = {swept.name, swept.scenario, swept.values, ""};
    try {
      read.given = parse_case(swept.text, swept.file, swept.overrides);
      any = true;
    } catch (const InputError& error) {
      read.given.reset();
      read.entry.refusal = error.what();
      if (first.empty()) first = error.what();
    }
  }
  if (!any) throw InputError(first);
  return cases;
}

Campaign lay_out(const CampaignDirectory& directory, const Sweep& sweep,
                 const std::vector<ReadCase>& cases, const std::string& text, bool force) {
  Campaign campaign{sweep.name, sweep.axes, {}};
  std::error_code error;
  std::vector<Change> changes;
  for (const ReadCase& read : cases) {
    changes.push_back(read.given ? change_of(directory, read, force) : Change::none);
    // A process that has it runs what was there before, and its end would count as that of what is
    // there then.
    const fs::path run = directory.run(read.entry.name);
    if (changes.back() != Change::none && fs::is_directory(run, error)) DirectoryLock(run, "run");
    campaign.cases.push_back(read.entry);
  }
  // First, so that the directory of a campaign that is killed while it is laid out is one already.
  make_directory(directory.path());
  if (!fs::exists(directory.index(), error)) directory.write(campaign);
  make_directory(directory.path() / "cases");
  for (std::size_t c = 0; c < cases.size(); ++c) {
    if (changes[c] == Change::none) continue;
    const fs::path run = directory.run(cases[c].entry.name);
    const std::string scenario = resolved_toml(cases[c].given->scenario);
    fs::remove(directory.failure(cases[c].entry.name), error);
    if (changes[c] == Change::anew) {
      // What is there has been looked at: it is no run, or it is to go.
      RunDirectory(run, force || fs::exists(run / "scenario.toml", error)).write_scenario(scenario);
      continue;
    }
    const DirectoryLock lock(run, "run");
    // Without its summary the case counts as one that has not ended.
    if (changes[c] == Change::end) fs::remove(run / "summary.json", error);
    write_atomically(run / "scenario.toml", scenario, Durability::system);
  }
  write_atomically(directory.file(), text, Durability::system);
  directory.write(campaign);
  return campaign;
}

}  // namespace ductile::drivers
