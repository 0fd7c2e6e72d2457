// From a campaign file to a directory whose cases can be run.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "campaign/directory.hpp"
#include "campaign/sweep.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

/// A case of a campaign, and what it is.
struct ReadCase {
  CampaignCase entry;
  std::optional<Case> given;  ///< nothing if it is refused, or not asked for
  std::string trouble;        ///< why the scenario in its directory cannot be read; or empty
};

/// Reads all cases of a campaign; one whose scenario is not good is refused with its own message.
/// Throws InputError if that is all of them: the first one's.
std::vector<ReadCase> read_cases(const Sweep& sweep);

/// Makes the directory of the cases: a scenario.toml each, campaign.json, and a copy of the file.
/// Of a case that has been begun the scenario may differ in [run] alone; with `force` the results
/// of one that differs are removed. Where a limit is another one, the case goes on. Throws
/// InputError, with nothing written, if a case has the results of another scenario and `force` is
/// not given, or one that is to change is run by another process; OutputError.
Campaign lay_out(const CampaignDirectory& directory, const Sweep& sweep,
                 const std::vector<ReadCase>& cases, const std::string& text, bool force);

}  // namespace ductile::drivers
