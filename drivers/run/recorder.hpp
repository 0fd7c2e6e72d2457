// The files and judgements of a run, on rank 0.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/contacts.hpp"
#include "analysis/verdict.hpp"
#include "ductile/suspension/suspension.hpp"
#include "output/run_directory.hpp"
#include "output/summary.hpp"
#include "output/surfaces.hpp"
#include "output/trajectory.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

class Recorder {
 public:
  /// What a sample means for the run.
  enum class Finding { go_on, decided, too_far };

  /// Opens the files. `given` must outlive it; `warnings` are those of before the run. Throws
  /// InputError and OutputError as RunDirectory.
  Recorder(const Case& given, const std::filesystem::path& directory, bool force,
           const std::string& scenario_text, std::vector<std::string> warnings);

  [[nodiscard]] bool pair() const { return given_.scenario.bodies.size() == 2; }
  [[nodiscard]] std::vector<suspension::Sample>& samples() { return samples_; }

  /// Writes a row, judges it, and says whether the run may end. Throws OutputError.
  Finding take(const suspension::Sample& sample);
  /// Writes a frame. Throws OutputError.
  void write_frame(double time, const std::vector<suspension::SurfaceState>& surfaces,
                   const suspension::FluidState* fluid);
  /// Takes the gaps below suspension::kernel_reach. True if surfaces cross that did not before.
  bool take_gaps(double time, const std::vector<suspension::Gap>& gaps);
  /// Something to tell at once, and again in the end.
  void warn(const std::string& warning);

  /// What can be said of the run so far; `solvers` as of suspension::Suspension.
  [[nodiscard]] Summary summarise(RunStatus status,
                                  const std::vector<membrane::SolveStatistics>& solvers) const;
  void write(const Summary& summary) const { write_summary(directory_.summary(), summary); }

 private:
  [[nodiscard]] CapsuleSummary summarise_capsule(std::size_t body,
                                                 const membrane::SolveStatistics& solver,
                                                 std::vector<std::string>& warnings) const;

  const Case& given_;
  RunDirectory directory_;
  Trajectory trajectory_;
  PairJudge judge_;
  Contacts contacts_;
  std::vector<SettlingWatch> lateral_;
  std::vector<SettlingWatch> strain_;
  std::vector<double> volume_error_;
  std::optional<Surfaces> surfaces_;
  std::vector<std::string> warnings_;
  std::vector<suspension::Sample> samples_;
};

}  // namespace ductile::drivers
