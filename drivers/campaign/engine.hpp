// Runs the cases of a campaign on this machine.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "campaign/directory.hpp"
#include "checks/speed.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

struct EngineOptions {
  std::string program;                   ///< this one's file
  std::vector<std::string> environment;  ///< of its runs
  int ranks = 1;                         ///< of a run
  int at_once = 1;                       ///< runs side by side
  std::string max_walltime;              ///< of a run, as the user has put it; or empty
};

/// A campaign that has been laid out.
struct LaidOut {
  CampaignDirectory directory;
  Campaign campaign;
};

/// A case to be run.
struct Job {
  std::size_t campaign = 0;  ///< which one it is of
  std::string name;
  Case given;
};

/// Seconds that a case takes to its time limit on so many ranks, beside others of its kind.
double expected_duration(const Case& given, int ranks, int at_once, const KnownSpeed& speed);

/// Seconds until the last of these has ended, `at_once` side by side, the longest first.
double expected_span(std::vector<double> durations, int at_once);

/// Runs or goes on with one case, and says how it ended as a run's exit code; failed.txt tells why
/// a run could not be done. `stop` is asked for a signal; one ends the run.
int run_one(const CampaignDirectory& directory, const std::string& name,
            const EngineOptions& options, const std::function<int()>& stop);

/// Runs or goes on with the jobs of these campaigns, the longest first, shows them on stderr, and
/// brings the campaign.csv of one up to date whenever one of its has ended. `stop` is asked for a
/// signal: the first ends the runs, with a checkpoint each. Gives the signal, or 0. Throws
/// OutputError.
int run_jobs(const std::vector<LaidOut>& campaigns, const std::vector<Job>& jobs,
             const EngineOptions& options, const KnownSpeed& speed,
             const std::function<int()>& stop);

}  // namespace ductile::drivers
