#include "commands/campaign.hpp"

#include <fmt/format.h>
#include <fnmatch.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "campaign/engine.hpp"
#include "checks/advice.hpp"
#include "checks/disk.hpp"
#include "checks/memory.hpp"
#include "checks/read_case.hpp"
#include "checks/speed.hpp"
#include "commands/input.hpp"
#include "commands/run.hpp"
#include "output/process.hpp"
#include "output/run_directory.hpp"
#include "output/say.hpp"
#include "run/exit_code.hpp"
#include "run/signals.hpp"
#include "scenario/errors.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {

/// A word given for a number, from 1 to `most`.
int number_of(const std::string& option, const std::string& text, int most) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 1 || number > most) {
    throw InputError(fmt::format("{} {}: must be a whole number from 1 to {}", option, text, most));
  }
  return number;
}

/// How many runs of how many ranks: as many runs as there are cores, if there are cases enough and
/// memory. On small lattices runs of one rank each, side by side, are the fastest.
void choose_width(EngineOptions& options, const std::vector<Job>& jobs, int ranks, int at_once) {
  const int cores = core_count();
  int planes = std::numeric_limits<int>::max();  // of the shortest channel
  for (const Job& job : jobs) planes = std::min(planes, job.given.plan.fluid.nodes[2]);
  options.ranks = ranks;
  options.at_once = at_once;
  if (at_once == 0) options.at_once = std::max(1, cores / std::max(1, ranks));
  options.at_once = std::min(options.at_once, static_cast<int>(jobs.size()));
  std::vector<double> memory;
  memory.reserve(jobs.size());
  for (const Job& job : jobs) memory.push_back(memory_needed(job.given).total());
  std::ranges::sort(memory, std::greater<>());
  const double free = free_memory();
  const auto needed = [&memory](int runs) {
    return std::accumulate(memory.begin(), memory.begin() + runs, 0.0);
  };
  int fitting = options.at_once;
  while (fitting > 1 && needed(fitting) > free) --fitting;
  if (fitting < options.at_once) {
    say(stderr, "{} runs side by side would need {} of memory, of which {} are free: {} at once\n",
        options.at_once, size_text(needed(options.at_once)), size_text(free), fitting);
    options.at_once = fitting;
  }
  if (ranks == 0) options.ranks = std::clamp(cores / options.at_once, 1, planes);
}

void predict(const fs::path& place, const std::vector<Job>& jobs, const EngineOptions& options,
             const std::optional<KnownSpeed>& known, const KnownSpeed& speed) {
  std::vector<double> durations;
  double disk = 0;
  for (const Job& job : jobs) {
    durations.push_back(expected_duration(job.given, options.ranks, options.at_once, speed));
    disk += disk_needed(job.given);
  }
  say(stderr,
      "{} case{} to run, {} at once on {} rank{} each: about {} until the time limits, {}; {} of "
      "disk\n",
      jobs.size(), jobs.size() == 1 ? "" : "s", options.at_once, options.ranks,
      options.ranks == 1 ? "" : "s",
      duration_text(expected_span(std::move(durations), options.at_once)),
      known ? "as `ductile bench` has found here"
            : "a guess: run `ductile bench` once for a better one",
      size_text(disk));
  struct statvfs volume {};
  if (statvfs(place.c_str(), &volume) != 0) return;
  const double free = static_cast<double>(volume.f_bavail) * static_cast<double>(volume.f_frsize);
  if (disk > free) {
    say(stderr, "warning: {} of disk are free in {}\n", size_text(free), place.string());
  }
}

/// A campaign that is run, and which of its cases were asked for.
struct Chosen {
  LaidOut laid_out;
  std::vector<CampaignCase> cases;
};

/// A case's name, which two campaigns may share.
std::string called(const std::vector<Chosen>& campaigns, std::size_t campaign,
                   const std::string& name) {
  return campaigns.size() == 1 ? name : campaigns[campaign].laid_out.campaign.name + '/' + name;
}

/// The cases, one a line.
void print_table(const std::vector<Chosen>& campaigns) {
  std::vector<std::pair<std::string, CaseResult>> rows;
  std::size_t width = 4;
  for (std::size_t c = 0; c < campaigns.size(); ++c) {
    const auto& [laid_out, cases] = campaigns[c];
    for (const CampaignCase& given : cases) {
      rows.emplace_back(called(campaigns, c, given.name), laid_out.directory.result(given));
      width = std::max(width, rows.back().first.size());
    }
  }
  width = std::min<std::size_t>(width, 80);
  std::string text = fmt::format("{:<{}}  {:<13}  {:<9}  {:>8}  {:>8}\n", "case", width, "state",
                                 "verdict", "dz", "t");
  const auto cell = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.3f}", *value) : std::string();
  };
  for (const auto& [name, result] : rows) {
    text += fmt::format("{:<{}}  {:<13}  {:<9}  {:>8}  {:>8}", shortened(name, width), width,
                        result.status, result.verdict, cell(result.dz), cell(result.time));
    const bool told = result.state == CaseState::failed || result.state == CaseState::refused ||
                      result.status == "blew up" || result.status == "contact";
    text += told ? "  " + shortened(result.reason, 200) + '\n' : std::string("\n");
  }
  say(stdout, text);
}

/// Whether any of the cases that were asked for is in one of these states.
bool any_in(const std::vector<Chosen>& campaigns, std::initializer_list<CaseState> states) {
  return std::ranges::any_of(campaigns, [&](const Chosen& chosen) {
    return std::ranges::any_of(chosen.cases, [&](const CampaignCase& given) {
      const CaseState state = chosen.laid_out.directory.result(given).state;
      return std::ranges::find(states, state) != states.end();
    });
  });
}

/// What the program returns when all has been done that could be.
int exit_code_of(const std::vector<Chosen>& campaigns) {
  if (any_in(campaigns, {CaseState::failed, CaseState::refused, CaseState::waiting}))
    return exit_failure;
  return any_in(campaigns, {CaseState::walltime, CaseState::unfinished}) ? exit_walltime
                                                                         : exit_success;
}

int run_all(const std::vector<Chosen>& campaigns, const std::vector<Job>& jobs,
            const EngineOptions& options, const KnownSpeed& speed) {
  const Signals signals;
  int signal = 0;
  std::vector<LaidOut> laid_out;
  laid_out.reserve(campaigns.size());
  for (const Chosen& chosen : campaigns) laid_out.push_back(chosen.laid_out);
  if (!jobs.empty())
    signal = run_jobs(laid_out, jobs, options, speed, [&] { return signals.stop(); });
  for (const auto& [directory, campaign] : laid_out) directory.gather(campaign);
  print_table(campaigns);
  std::string directories;
  for (const auto& [directory, campaign] : laid_out) {
    say(stdout, "results in {}\n", directory.table().string());
    directories += ' ' + directory.path().string();
  }
  const int code = signal != 0 ? static_cast<int>(exit_interrupted) : exit_code_of(campaigns);
  if (any_in(campaigns,
             {CaseState::waiting, CaseState::unfinished, CaseState::walltime, CaseState::failed})) {
    say(stdout, "`ductile campaign{}` goes on with the cases that have not ended\n", directories);
  }
  return code;
}

}  // namespace

CLI::App* CampaignCommand::declare(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "campaign",
      "Run the cases of a study, side by side; those that have ended are not run again");
  command
      ->add_option("FILE", given_,
                   "The campaign, TOML (doc/studies.md), or several, whose cases are run in one "
                   "queue; or the directories of some, to go on with them")
      ->required()
      ->type_name("");
  command
      ->add_option("-o,--output", output_,
                   "Directory of the results, runs/NAME by default; of several campaigns, DIR/NAME "
                   "each")
      ->type_name("DIR");
  command
      ->add_option("--only", only_,
                   "Run these cases alone, the others wait: names of cases, or of campaign/case, "
                   "in which * stands for anything; may be repeated")
      ->type_name("PATTERN")
      ->allow_extra_args(false);
  command->add_option("--ranks", ranks_, "Ranks of each run; 1, while there are cases enough")
      ->type_name("N");
  command->add_option("--at-once", at_once_, "Runs side by side; as many as cores and memory allow")
      ->type_name("N");
  command
      ->add_option("--max-walltime", max_walltime_,
                   "Time on the clock that each run is given: 90s, 30m, 11.5h, 2d, or HH:MM:SS")
      ->type_name("TIME");
  command->add_flag("--force", force_, "Replace the results of cases that are now other ones");
  command->add_flag("--prepare", prepare_,
                    "Check the cases and lay out their directories, and run none");
  command
      ->add_option("--case", case_,
                   "Of a campaign's directory, run this case alone: what an engine calls")
      ->type_name("NAME");
  command->add_flag("--gather", gather_, "Of a campaign's directory, write campaign.csv anew");
  command->footer(
      "Exit codes: 0 all cases have ended, however; 1 one could not be run, or was refused;\n"
      "2 wrong input (nothing is written); 5 a signal ended it, 6 --max-walltime one of its runs:\n"
      "the same command goes on. campaign.csv says how each case ended.");
  return command;
}

namespace {

bool is_directory(const std::string& given) {
  std::error_code error;
  return fs::is_directory(given, error);
}

bool matches(const std::string& pattern, const std::string& campaign, const std::string& name) {
  return fnmatch(pattern.c_str(), name.c_str(), 0) == 0 ||
         fnmatch(pattern.c_str(), (campaign + '/' + name).c_str(), 0) == 0;
}

}  // namespace

void CampaignCommand::check_options() const {
  if ((prepare_ ? 1 : 0) + (gather_ ? 1 : 0) + (case_.empty() ? 0 : 1) > 1)
    throw InputError("ductile campaign: --prepare, --case and --gather exclude each other");
  if (!only_.empty() && (gather_ || !case_.empty()))
    throw InputError("ductile campaign: --only does not go with --case or --gather");
  const bool laid_out = is_directory(given_.front());
  if (std::ranges::any_of(
          given_, [&](const std::string& given) { return is_directory(given) != laid_out; })) {
    throw InputError("ductile campaign: takes either campaign files or directories of campaigns");
  }
  if (laid_out && (prepare_ || force_ || !output_.empty())) {
    throw InputError(
        "ductile campaign: -o, --force and --prepare go with a campaign file, not with a "
        "directory");
  }
  if (!laid_out && (gather_ || !case_.empty()))
    throw InputError("ductile campaign: --case and --gather go with a campaign's directory");
  if (!case_.empty() && given_.size() > 1)
    throw InputError("ductile campaign: --case goes with one directory");
  static_cast<void>(walltime_of(max_walltime_));
}

CampaignCommand::Request CampaignCommand::prepare(const std::string& given) const {
  Request request;
  request.directory = given;
  if (is_directory(given)) {
    const CampaignDirectory directory(request.directory);
    Campaign campaign = directory.read();
    request.name = campaign.name;
    for (CampaignCase& entry : campaign.cases) {
      ReadCase& read = request.cases.emplace_back();
      read.entry = std::move(entry);
      if (!read.entry.refusal.empty() || gather_ || !case_.empty()) continue;
      try {
        read.given = load_case(directory.run(read.entry.name) / "scenario.toml");
      } catch (const InputError& error) {
        read.trouble = error.what();
      }
    }
    return request;
  }
  request.text = read_text(given);
  request.sweep = parse_sweep(request.text, given);
  request.name = request.sweep->name;
  request.cases = read_cases(*request.sweep);
  request.directory = output_.empty()      ? fs::path("runs") / request.name
                      : given_.size() == 1 ? fs::path(output_)
                                           : fs::path(output_) / request.name;
  return request;
}

std::vector<CampaignCommand::Request> CampaignCommand::prepare() const {
  check_options();
  std::vector<Request> requests;
  for (const std::string& given : given_) {
    requests.push_back(prepare(given));
    for (std::size_t n = 0; n + 1 < requests.size(); ++n) {
      if (requests[n].directory.lexically_normal() ==
          requests.back().directory.lexically_normal()) {
        throw InputError(fmt::format("{} and {}: both would have the directory {}", given_[n],
                                     given, requests[n].directory.string()));
      }
    }
  }
  check_patterns(requests);
  return requests;
}

void CampaignCommand::check_patterns(const std::vector<Request>& requests) const {
  for (const std::string& pattern : only_) {
    const bool known = std::ranges::any_of(requests, [&](const Request& request) {
      return std::ranges::any_of(request.cases, [&](const ReadCase& read) {
        return matches(pattern, request.name, read.entry.name);
      });
    });
    if (known) continue;
    throw InputError(fmt::format("--only {}: no case is called so: the first one is {}",
                                 in_quotes(shortened(pattern, 200)),
                                 requests.front().cases.front().entry.name));
  }
}

bool CampaignCommand::chosen(const std::string& campaign, const std::string& name) const {
  return only_.empty() || std::ranges::any_of(only_, [&](const std::string& pattern) {
           return matches(pattern, campaign, name);
         });
}

namespace {

EngineOptions engine_options(const std::string& max_walltime) {
  EngineOptions options;
  options.program = fs::read_symlink("/proc/self/exe").string();
  options.environment = environment_without_job();
  options.max_walltime = max_walltime;
  return options;
}

constexpr int most_ranks = 100000;

}  // namespace

void CampaignCommand::run_case(const Request& request, Afterwards& afterwards) const {
  const CampaignDirectory directory(request.directory);
  const auto entry =
      std::ranges::find(request.cases, case_, [](const ReadCase& read) { return read.entry.name; });
  if (entry == request.cases.end()) {
    throw InputError(fmt::format("{}: has no case {}", request.directory.string(),
                                 in_quotes(shortened(case_, 200))));
  }
  if (!entry->entry.refusal.empty()) throw InputError(entry->entry.refusal);
  if (directory.result(entry->entry).state == CaseState::ended) return;
  EngineOptions options = engine_options(max_walltime_);
  options.ranks = ranks_.empty() ? 1 : number_of("--ranks", ranks_, most_ranks);
  afterwards.work = [directory, entry = entry->entry, options] {
    const Signals signals;
    const int code = run_one(directory, entry.name, options, [&] { return signals.stop(); });
    const CaseResult result = directory.result(entry);
    if (result.state == CaseState::failed) say(stderr, "{}: {}\n", entry.name, result.reason);
    return code == exit_blow_up || code == exit_contact ? static_cast<int>(exit_success) : code;
  };
}

namespace {

// A campaign may grow, have other axes, or its file be called otherwise; one of another name that
// has no case in common with that of the directory is another, which would take its place.
void require_kin(const CampaignDirectory& directory, const CampaignCommand::Request& request) {
  std::error_code error;
  if (!fs::exists(directory.index(), error)) return;
  Campaign before;
  try {
    before = directory.read();
  } catch (const InputError&) {
    return;  // it is laid out again from its file
  }
  const bool kin = before.name == request.name ||
                   std::ranges::any_of(before.cases, [&](const CampaignCase& old) {
                     return std::ranges::any_of(request.cases, [&](const ReadCase& read) {
                       return read.entry.name == old.name;
                     });
                   });
  if (kin) return;
  throw InputError(
      fmt::format("{}: has a campaign {}, of which {} has no case: add --force to put it in its "
                  "place, or choose another directory with -o",
                  directory.path().string(), before.name, request.name));
}

}  // namespace

void CampaignCommand::check_ranks(const std::vector<Request>& requests, int ranks) const {
  int planes = std::numeric_limits<int>::max();  // of the shortest channel
  for (const Request& request : requests) {
    const CampaignDirectory directory(request.directory);
    for (const ReadCase& read : request.cases) {
      if (read.given && chosen(request.name, read.entry.name) &&
          directory.result(read.entry).state != CaseState::ended)
        planes = std::min(planes, read.given->plan.fluid.nodes[2]);
    }
  }
  if (ranks > planes) {
    throw InputError(fmt::format("--ranks {}: cannot share the {} planes of the shortest channel",
                                 ranks, planes));
  }
}

void CampaignCommand::run(const std::vector<Request>& requests, Afterwards& afterwards) const {
  EngineOptions options = engine_options(max_walltime_);
  const int ranks = ranks_.empty() ? 0 : number_of("--ranks", ranks_, most_ranks);
  const int at_once = at_once_.empty() ? 0 : number_of("--at-once", at_once_, most_ranks);

  std::error_code error;
  std::vector<std::shared_ptr<DirectoryLock>> locks;
  for (const Request& request : requests) {
    const CampaignDirectory directory(request.directory);
    if (!force_ && !fs::exists(directory.index(), error)) require_free(directory.path(), false);
    if (!force_ && request.sweep) require_kin(directory, request);
  }
  check_ranks(requests, ranks);
  for (const Request& request : requests) {
    fs::create_directories(request.directory, error);
    if (error) fail_to_write(request.directory, error.value());
    locks.push_back(std::make_shared<DirectoryLock>(request.directory, "campaign"));
  }
  std::vector<Chosen> campaigns;
  std::vector<Job> jobs;
  for (const Request& request : requests) {
    const CampaignDirectory directory(request.directory);
    Chosen& own = campaigns.emplace_back(Chosen{
        {directory, request.sweep
                        ? lay_out(directory, *request.sweep, request.cases, request.text, force_)
                        : directory.read()},
        {}});
    for (const ReadCase& read : request.cases) {
      const std::string& name = read.entry.name;
      if (!chosen(request.name, name)) continue;
      own.cases.push_back(read.entry);
      if (!read.entry.refusal.empty()) say(stderr, "{} is refused: {}\n", name, read.entry.refusal);
      if (read.given && directory.result(read.entry).state != CaseState::ended)
        jobs.push_back({campaigns.size() - 1, name, *read.given});
      if (read.trouble.empty()) continue;
      say(stderr, "{} cannot be run: {}\n", name, read.trouble);
      // One whose directory was removed, or never laid out, waits for the campaign file to be given
      // again.
      if (fs::exists(directory.run(name) / "scenario.toml", error))
        write_atomically(directory.failure(name), read.trouble + '\n');
    }
    if (prepare_ || gather_) {
      directory.gather(own.laid_out.campaign);
      say(stdout, "{} cases in {}\n", request.cases.size(), directory.path().string());
    }
  }
  if (prepare_ || gather_) return;
  const std::optional<KnownSpeed> known = known_speed();
  const KnownSpeed speed = known ? *known : guessed_speed(core_count());
  if (!jobs.empty()) {
    std::vector<std::pair<std::string, Case>> cases;
    cases.reserve(jobs.size());
    for (const Job& job : jobs)
      cases.emplace_back(called(campaigns, job.campaign, job.name), job.given);
    constexpr double seconds = 5;  // for all predictions of stability; a run makes its own
    static_cast<void>(advise(cases, seconds / static_cast<double>(cases.size())));
    choose_width(options, jobs, ranks, at_once);
    predict(requests.front().directory, jobs, options, known, speed);
  }
  afterwards.work = [campaigns = std::move(campaigns), jobs = std::move(jobs), options, speed,
                     locks = std::move(locks)] { return run_all(campaigns, jobs, options, speed); };
}

int CampaignCommand::execute(MPI_Comm comm, Afterwards& afterwards) {
  return with_input(comm, [&] {
    if (ranks_of(comm).all > 1)
      throw InputError("ductile campaign: starts its runs itself: call it without mpirun");
    const std::vector<Request> requests = prepare();
    if (!case_.empty()) {
      run_case(requests.front(), afterwards);
    } else {
      run(requests, afterwards);
    }
  });
}

}  // namespace ductile::drivers
