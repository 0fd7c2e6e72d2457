// `ductile campaign`: many cases of one study.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "campaign/layout.hpp"
#include "campaign/sweep.hpp"
#include "commands/command.hpp"

namespace ductile::drivers {

/// Lays out the cases of campaign files in a directory each, or takes those that have been laid
/// out, and runs those that have not ended: on this machine side by side, all campaigns in one
/// queue, or one case for an engine that calls the program case by case.
class CampaignCommand final : public Command {
 public:
  /// A campaign that is to be laid out, or has been.
  struct Request {
    std::string name;
    std::filesystem::path directory;
    std::string text;  ///< of the campaign file; empty if it has been laid out
    std::optional<Sweep> sweep;
    std::vector<ReadCase> cases;
  };
  CLI::App* declare(CLI::App& program) override;
  /// What the options ask for, one for each file or directory. Throws InputError. Nothing is
  /// written.
  [[nodiscard]] std::vector<Request> prepare() const;
  /// Checks and lays out; the cases are run afterwards.
  int execute(MPI_Comm comm, Afterwards& afterwards) override;

 private:
  void check_options() const;
  [[nodiscard]] Request prepare(const std::string& given) const;
  void check_patterns(const std::vector<Request>& requests) const;
  void check_ranks(const std::vector<Request>& requests, int ranks) const;
  [[nodiscard]] bool chosen(const std::string& campaign, const std::string& name) const;
  void run_case(const Request& request, Afterwards& afterwards) const;
  void run(const std::vector<Request>& requests, Afterwards& afterwards) const;

  std::vector<std::string> given_;
  std::vector<std::string> only_;
  std::string output_;
  std::string case_;
  std::string max_walltime_;
  std::string ranks_;
  std::string at_once_;
  bool prepare_ = false;
  bool gather_ = false;
  bool force_ = false;
};

}  // namespace ductile::drivers
