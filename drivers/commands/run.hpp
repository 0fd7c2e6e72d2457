// `ductile run`: one scenario file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "commands/arguments.hpp"
#include "commands/command.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Seconds of a --max-walltime, if it is given. Throws InputError.
std::optional<double> walltime_of(const std::string& text);

/// A command that runs one case. What differs is where the case comes from.
class SingleRun : public Command {
 public:
  struct Request {
    Case given;
    std::filesystem::path directory;
  };
  /// What the options ask for. Throws InputError, also where the results may not go. Rank 0.
  [[nodiscard]] virtual Request prepare() const = 0;
  [[nodiscard]] bool force() const { return output_.force(); }
  [[nodiscard]] bool profile() const { return profile_; }
  /// In seconds. Throws InputError.
  [[nodiscard]] std::optional<double> max_walltime() const { return walltime_of(max_walltime_); }
  /// Whether the run in the directory goes on.
  [[nodiscard]] virtual bool resumes() const { return false; }

  int execute(MPI_Comm comm, Afterwards& afterwards) override;

 protected:
  /// The options of every such command, ...
  void declare_run(CLI::App& command);
  /// ... and those too of one that starts a run.
  void declare_shared(CLI::App& command, const std::string& usual_directory);
  [[nodiscard]] const ScenarioArguments& scenario() const { return scenario_; }
  [[nodiscard]] const OutputArguments& output() const { return output_; }

 private:
  ScenarioArguments scenario_;
  OutputArguments output_;
  bool profile_ = false;
  std::string max_walltime_;
  FormatArgument format_;
};

class RunCommand final : public SingleRun {
 public:
  CLI::App* declare(CLI::App& program) override;
  [[nodiscard]] Request prepare() const override;

 private:
  std::string file_;
};

}  // namespace ductile::drivers
