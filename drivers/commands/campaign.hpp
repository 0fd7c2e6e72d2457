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

/// Lays out the cases of a campaign file in a directory, or takes one that has been laid out, and
/// runs those that have not ended: on this machine side by side, or one of them for an engine that
/// calls the program case by case.
class CampaignCommand final : public Command {
 public:
  /// A campaign that is to be laid out, or has been.
  struct Request {
    std::filesystem::path directory;
    std::string text;  ///< of the campaign file; empty if it has been laid out
    std::optional<Sweep> sweep;
    std::vector<ReadCase> cases;
  };
  CLI::App* declare(CLI::App& program) override;
  /// What the options ask for. Throws InputError. Nothing is written.
  [[nodiscard]] Request prepare() const;
  /// Checks and lays out; the cases are run afterwards.
  int execute(MPI_Comm comm, Afterwards& afterwards) override;

 private:
  [[nodiscard]] bool laid_out() const;
  void check_options() const;
  void run(const Request& request, Afterwards& afterwards) const;

  std::string given_;
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
