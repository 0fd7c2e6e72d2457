// The directory of a campaign: what is known of its cases without running them.
//
//     campaign.toml    the file that it was made of
//     campaign.json    the swept keys and the cases; those refused, with the reason
//     campaign.csv     what came of the cases, a row each
//     cases/NAME/      an ordinary run directory each; failed.txt says why one could not be run
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ductile::drivers {

/// A case of a campaign that has been laid out.
struct CampaignCase {
  std::string name;
  std::string scenario;             ///< what it is made of, as the campaign file calls it
  std::vector<std::string> values;  ///< of the swept keys, TOML
  std::string refusal;              ///< why it is not run; empty: it is
};

struct Campaign {
  std::string name;
  std::vector<std::string> axes;  ///< the swept keys
  std::vector<CampaignCase> cases;
};

/// What a case has come to.
enum class CaseState {
  waiting,     ///< nothing is there
  unfinished,  ///< it was killed or interrupted
  walltime,    ///< it has used up the time that it was given
  failed,      ///< it could not be run
  refused,     ///< its scenario is not good
  ended        ///< it came to an end of its own, be it that it blew up
};

/// A case as its files tell it.
struct CaseResult {
  CaseState state = CaseState::waiting;
  /// How the run ended ("decided", "blew up", "walltime"), or "waiting", "unfinished", "failed",
  /// "refused".
  std::string status;
  std::string verdict;  ///< of a pair
  std::string reason;   ///< of the verdict, the failure, the refusal
  std::optional<double> time, dz;
};

class CampaignDirectory {
 public:
  /// One that is there or is to be made.
  explicit CampaignDirectory(std::filesystem::path path) : path_(std::move(path)) {}

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path index() const { return path_ / "campaign.json"; }
  [[nodiscard]] std::filesystem::path table() const { return path_ / "campaign.csv"; }
  [[nodiscard]] std::filesystem::path file() const { return path_ / "campaign.toml"; }
  [[nodiscard]] std::filesystem::path run(std::string_view name) const {
    return path_ / "cases" / name;
  }
  [[nodiscard]] std::filesystem::path failure(std::string_view name) const {
    return run(name) / "failed.txt";
  }

  /// What a case's process says on its streams.
  [[nodiscard]] std::filesystem::path said(std::string_view name) const {
    return run(name) / "terminal.txt";
  }

  /// Writes campaign.json. Throws OutputError.
  void write(const Campaign& campaign) const;
  /// Reads it. Throws InputError if there is none, or it is none.
  [[nodiscard]] Campaign read() const;

  [[nodiscard]] CaseResult result(const CampaignCase& given) const;
  /// Writes campaign.csv: of each case its swept values, how it ended, the verdict of a pair, and
  /// of each body the last place, velocity and outlook; what is not known or does not apply is
  /// empty. No times of the clock: equal runs give equal files. Throws OutputError.
  void gather(const Campaign& campaign) const;

 private:
  std::filesystem::path path_;
};

}  // namespace ductile::drivers
