#include "campaign/engine.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <numeric>
#include <set>
#include <thread>
#include <utility>

#include "campaign/board.hpp"
#include "campaign/watch.hpp"
#include "output/file.hpp"
#include "output/process.hpp"
#include "output/run_directory.hpp"
#include "output/say.hpp"
#include "run/exit_code.hpp"
#include "run/progress.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {
namespace fs = std::filesystem;

namespace {

constexpr double start_and_picture = 2;  // seconds of a run that are no steps
constexpr auto nap = std::chrono::milliseconds(100);
constexpr double look_interval = 1;  // s
/// A run that was told to end has this long to write its checkpoint and picture.
constexpr double patience = 120;           // s
constexpr double patience_of_a_kill = 10;  // s, from SIGTERM to SIGKILL

std::vector<std::string> command(const CampaignDirectory& directory, const std::string& name,
                                 const EngineOptions& options) {
  std::vector<std::string> words;
  if (options.ranks > 1) {
    words = {"mpirun",
             "--quiet",
             "--bind-to",
             "none",
             "--oversubscribe",
             "-n",
             fmt::format("{}", options.ranks)};
  }
  words.insert(words.end(), {options.program, "resume", directory.run(name).string()});
  if (!options.max_walltime.empty())
    words.insert(words.end(), {"--max-walltime", options.max_walltime});
  return words;
}

/// What a run that has failed has said of it: its last line, unless the program has one of its own.
std::string last_words(const fs::path& said) {
  std::ifstream in(said, std::ios::binary);
  std::string last;
  std::string own;
  constexpr std::string_view mark = "ductile: ";
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(mark)) own = line.substr(mark.size());
    if (line.find_first_not_of(" \t\r-") != std::string::npos) last = line;
  }
  return shortened(own.empty() ? last : own, 1000);
}

/// Starts a case, which has not failed then.
Process started(const CampaignDirectory& directory, const std::string& name,
                const EngineOptions& options) {
  std::error_code error;
  fs::remove(directory.failure(name), error);
  return {command(directory, name, options), options.environment, directory.said(name)};
}

/// A run's exit code; what is none of a run that has ended is kept as a failure, unless a signal
/// that it was sent from here has killed it.
int concluded(const CampaignDirectory& directory, const std::string& name, const Ending& ending,
              bool told_to_end) {
  const bool known =
      ending.signal == 0 &&
      (ending.code == exit_success || ending.code == exit_blow_up || ending.code == exit_contact ||
       ending.code == exit_interrupted || ending.code == exit_walltime);
  if (known) {
    std::error_code error;  // of another run in the same directory, which this one has outlived
    fs::remove(directory.failure(name), error);
    return ending.code;
  }
  if (told_to_end && ending.signal != 0) return exit_interrupted;
  std::string reason = last_words(directory.said(name));
  if (ending.signal != 0) {
    reason = fmt::format("killed by SIG{}{}{}", sigabbrev_np(ending.signal),
                         reason.empty() ? "" : "; it last said: ", reason);
  }
  if (reason.empty()) reason = fmt::format("exit code {}, and no word", ending.code);
  write_atomically(directory.failure(name), reason + '\n');
  return ending.signal != 0 ? static_cast<int>(exit_failure) : ending.code;
}

struct Lane {
  Lane(std::size_t its_job, Process started, const fs::path& trajectory, const Case& given,
       double now)
      : job(its_job),
        process(std::move(started)),
        watch(trajectory, given.scenario.run.stop_distance),
        since(now) {}
  std::size_t job;
  Process process;
  RunWatch watch;
  double since;                // by the clock
  std::optional<double> from;  // simulated time at the first row that was seen
  double from_since = 0;       // when that was
};

class Engine {
 public:
  Engine(const std::vector<LaidOut>& campaigns, const std::vector<Job>& jobs,
         const EngineOptions& options, const KnownSpeed& speed, const std::function<int()>& stop)
      : campaigns_(campaigns),
        jobs_(jobs),
        options_(options),
        stop_(stop),
        begun_(Progress::steady_seconds()),
        board_(stderr, isatty(STDERR_FILENO) != 0, terminal_width()) {
    for (const Job& job : jobs) {
      durations_.push_back(expected_duration(job.given, options.ranks, options.at_once, speed));
    }
    queue_.resize(jobs.size());
    std::iota(queue_.begin(), queue_.end(), std::size_t{0});
    // The last is taken first.
    std::ranges::stable_sort(queue_, [this](std::size_t a, std::size_t b) {
      return durations_[a] < durations_[b] || (durations_[a] == durations_[b] && a > b);
    });
  }

  int run() {
    try {
      work();
    } catch (...) {
      board_.tell("the runs under way write a checkpoint and end");
      end_lanes();
      throw;
    }
    board_.finish();
    return signal_;
  }

 private:
  void work() {
    double looked = 0;
    while (!lanes_.empty() || (!queue_.empty() && signal_ == 0)) {
      hear();
      fill();
      reap();
      const double now = Progress::steady_seconds();
      if (now - looked >= look_interval) {
        looked = now;
        show(now);
      }
      std::this_thread::sleep_for(nap);
    }
  }

  // Without looking at what they leave.
  void end_lanes() {
    for (const Lane& lane : lanes_) lane.process.signal(SIGUSR2);
    stopped_ = Progress::steady_seconds();
    while (!lanes_.empty()) {
      std::erase_if(lanes_, [](Lane& lane) { return lane.process.ended().has_value(); });
      press();
      std::this_thread::sleep_for(nap);
    }
  }

  // Those that do not end when they are told to. mpirun ends its ranks on SIGTERM alone.
  void press() {
    const double since = Progress::steady_seconds() - stopped_;
    if (since < patience) return;
    for (const Lane& lane : lanes_) {
      lane.process.signal(SIGTERM);
      if (since > patience + patience_of_a_kill) lane.process.signal(SIGKILL);
    }
  }

  static std::size_t terminal_width() {
    winsize size{};
    constexpr std::size_t usual = 100;
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : usual;
  }

  void hear() {
    const double now = Progress::steady_seconds();
    if (signal_ == 0 && stop_() != 0) {
      signal_ = stop_();
      stopped_ = now;
      board_.tell(fmt::format("SIG{} came: the runs under way write a checkpoint and end",
                              sigabbrev_np(signal_)));
      for (const Lane& lane : lanes_) lane.process.signal(SIGUSR2);
    }
    if (signal_ != 0) press();
  }

  void fill() {
    // Where a run of a campaign that was killed is still at its last checkpoint, others come first.
    const bool waits = Progress::steady_seconds() - begun_ < patience;
    for (std::size_t n = queue_.size();
         n-- > 0 && signal_ == 0 && lanes_.size() < static_cast<std::size_t>(options_.at_once);) {
      const std::size_t job = queue_[n];
      const std::string& name = jobs_[job].name;
      const CampaignDirectory& directory = campaign_of(job).directory;
      if (waits && is_locked(directory.run(name))) continue;
      queue_.erase(queue_.begin() + static_cast<std::ptrdiff_t>(n));
      lanes_.emplace_back(job, started(directory, name, options_),
                          directory.run(name) / "trajectory.csv", jobs_[job].given,
                          Progress::steady_seconds());
    }
  }

  void reap() {
    std::set<std::size_t> changed;  // campaigns
    for (std::size_t n = 0; n < lanes_.size();) {
      const std::optional<Ending> ending = lanes_[n].process.ended();
      if (!ending) {
        ++n;
        continue;
      }
      const std::size_t job = lanes_[n].job;
      static_cast<void>(
          concluded(campaign_of(job).directory, jobs_[job].name, *ending, signal_ != 0));
      tell(job, Progress::steady_seconds() - lanes_[n].since);
      done_ += durations_[job];
      lanes_.erase(lanes_.begin() + static_cast<std::ptrdiff_t>(n));
      changed.insert(jobs_[job].campaign);
    }
    for (const std::size_t c : changed) campaigns_[c].directory.gather(campaigns_[c].campaign);
  }

  void tell(std::size_t job, double seconds) {
    const auto& [directory, campaign] = campaign_of(job);
    const auto entry = std::ranges::find(campaign.cases, jobs_[job].name, &CampaignCase::name);
    const CaseResult result = directory.result(*entry);
    std::string line = fmt::format("{}: {}", called(job), result.status);
    if (!result.verdict.empty()) line += fmt::format(", {}", result.verdict);
    if (result.dz) line += fmt::format(", dz = {:.3f}", *result.dz);
    if (result.time) line += fmt::format(" at t = {:.2f}", *result.time);
    if (!result.reason.empty()) line += fmt::format(" ({})", result.reason);
    board_.tell(line + "; " + duration_text(seconds));
  }

  [[nodiscard]] const LaidOut& campaign_of(std::size_t job) const {
    return campaigns_[jobs_[job].campaign];
  }

  // A case's name, which two campaigns may share.
  [[nodiscard]] std::string called(std::size_t job) const {
    const std::string& name = jobs_[job].name;
    return campaigns_.size() == 1 ? name : campaign_of(job).campaign.name + '/' + name;
  }

  void show(double now) {
    std::vector<BoardRow> rows;
    double under_way = 0;  // of the work, in predicted seconds
    double left = 0;
    for (const std::size_t job : queue_) left += durations_[job];
    for (Lane& lane : lanes_) {
      lane.watch.look();
      BoardRow& row = rows.emplace_back();
      const Job& job = jobs_[lane.job];
      row.name = called(lane.job);
      row.time = lane.watch.time();
      row.time_limit = job.given.scenario.run.time_limit;
      row.dz = lane.watch.dz();
      if (row.dz) row.verdict = to_string(lane.watch.verdict().pair_class);
      double share = 0;
      if (row.time) {
        if (!lane.from) {
          lane.from = row.time;
          lane.from_since = now;
        }
        const double gone = *row.time - *lane.from;
        if (gone > 0) row.left = (row.time_limit - *row.time) * (now - lane.from_since) / gone;
        share = std::clamp(*row.time / row.time_limit, 0.0, 1.0);
        under_way += gone / row.time_limit * durations_[lane.job];
      }
      left += (1 - share) * durations_[lane.job];
    }
    BoardCounts counts{
        jobs_.size(), jobs_.size() - lanes_.size() - queue_.size(), queue_.size(), {}};
    const double done = done_ + under_way;
    constexpr double enough = 0.02;  // of all, to tell by
    if (done > enough * (done + left)) counts.left = left * (now - begun_) / done;
    board_.show(now, rows, counts);
  }

  const std::vector<LaidOut>& campaigns_;
  const std::vector<Job>& jobs_;
  const EngineOptions& options_;
  const std::function<int()>& stop_;
  double begun_;
  Board board_;
  std::vector<double> durations_;
  std::vector<std::size_t> queue_;
  std::vector<Lane> lanes_;
  double done_ = 0;  // of the work, in predicted seconds
  int signal_ = 0;
  double stopped_ = 0;
};

}  // namespace

// Side by side, the runs share what the machine's memory gives: each has its part of what all ranks
// together do.
double expected_duration(const Case& given, int ranks, int at_once, const KnownSpeed& speed) {
  StepTime step = expected_step(given.plan, ranks, speed);
  step.fluid = at_once * expected_step(given.plan, ranks * at_once, speed).fluid;
  return step.total() * static_cast<double>(given.schedule.end) + start_and_picture;
}

double expected_span(std::vector<double> durations, int at_once) {
  std::ranges::sort(durations, std::greater<>());
  std::vector<double> lanes(static_cast<std::size_t>(at_once));
  for (const double duration : durations) *std::ranges::min_element(lanes) += duration;
  return std::ranges::max(lanes);
}

int run_one(const CampaignDirectory& directory, const std::string& name,
            const EngineOptions& options, const std::function<int()>& stop) {
  const double begun = Progress::steady_seconds();
  while (is_locked(directory.run(name)) && stop() == 0 &&
         Progress::steady_seconds() - begun < patience)
    std::this_thread::sleep_for(nap);
  Process process = started(directory, name, options);
  bool told = false;
  for (;;) {
    if (const std::optional<Ending> ending = process.ended())
      return concluded(directory, name, *ending, told);
    if (!told && stop() != 0) {
      told = true;
      process.signal(SIGUSR2);
    }
    std::this_thread::sleep_for(nap);
  }
}

int run_jobs(const std::vector<LaidOut>& campaigns, const std::vector<Job>& jobs,
             const EngineOptions& options, const KnownSpeed& speed,
             const std::function<int()>& stop) {
  return Engine(campaigns, jobs, options, speed, stop).run();
}

}  // namespace ductile::drivers
