// The files and judgements of a run, on rank 0.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/contacts.hpp"
#include "analysis/verdict.hpp"
#include "ductile/suspension/suspension.hpp"
#include "output/checkpoint.hpp"
#include "output/run_directory.hpp"
#include "output/say.hpp"
#include "output/summary.hpp"
#include "output/surfaces.hpp"
#include "output/trajectory.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Where a run is in its course, besides the state of the suspension; -1: nowhere yet.
struct Course {
  std::int64_t last_row = -1;    ///< step
  std::int64_t last_frame = -1;  ///< step
  std::vector<Leg> legs;
};

class Recorder {
 public:
  /// What a sample means for the run.
  enum class Finding { go_on, decided, too_far };

  /// Opens the files of a new run. `given` must outlive it; `warnings` are those of before the run.
  /// Throws InputError and OutputError as RunDirectory.
  Recorder(const Case& given, const std::filesystem::path& directory, bool force,
           const std::string& scenario_text, std::vector<std::string> warnings);
  /// Goes on with the run in `directory`, after the latest checkpoint that can be relied on, or
  /// from the start if there is none yet; a checkpoint that is refused is warned of. Throws
  /// likewise; InputError if the case is another than the run's but for its limits;
  /// CheckpointError if there are checkpoints, and none is good.
  Recorder(const Case& given, const std::filesystem::path& directory,
           const std::string& scenario_text, const std::vector<std::string>& warnings);

  /// Where a run that goes on takes its state from; null if it starts.
  [[nodiscard]] const Checkpoint* checkpoint() const { return checkpoint_.get(); }
  [[nodiscard]] const Course& course() const { return course_; }
  /// The state has been taken over.
  void close_checkpoint() { checkpoint_.reset(); }
  /// Adds to a checkpoint all that is the recorder's, and brings rows and frames onto the disk.
  /// Throws OutputError.
  void save(NewCheckpoint& checkpoint, const Course& course);
  [[nodiscard]] const RunDirectory& directory() const { return directory_; }
  [[nodiscard]] std::shared_ptr<const Log> log() const { return log_; }

  [[nodiscard]] bool pair() const { return given_.scenario.bodies.size() == 2; }
  [[nodiscard]] std::vector<suspension::Sample>& samples() { return samples_; }

  /// Writes a row, judges it, and says whether the run may end. Throws OutputError.
  Finding take(const suspension::Sample& sample);
  /// Writes a frame. Throws OutputError.
  void write_frame(double time, const std::vector<suspension::SurfaceState>& surfaces,
                   const suspension::FluidState* fluid);
  /// The same of a state that has blown up: written, and never gone on from. Throws OutputError.
  void write_wreck(const suspension::Sample& sample,
                   const std::vector<suspension::SurfaceState>& surfaces,
                   const suspension::FluidState& fluid);
  /// What a sample has said before: of a run that goes on.
  [[nodiscard]] Finding found() const;
  [[nodiscard]] const Contacts& contacts() const { return contacts_; }
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }
  /// Takes the gaps below suspension::kernel_reach. True if surfaces cross that did not before.
  bool take_gaps(double time, const std::vector<suspension::Gap>& gaps);
  /// Something to tell at once, and again in the end.
  void warn(const std::string& warning);

  /// What can be said of the run so far; `solvers` as of suspension::Suspension.
  [[nodiscard]] Summary summarise(RunStatus status,
                                  const std::vector<membrane::SolveStatistics>& solvers) const;
  /// Rows and frames are on the disk before. Throws OutputError.
  void write(const Summary& summary);

 private:
  [[nodiscard]] CapsuleSummary summarise_capsule(std::size_t body,
                                                 const membrane::SolveStatistics& solver,
                                                 std::vector<std::string>& warnings) const;

  void warn_of_speed(const suspension::Sample& sample);
  void judge(const suspension::Sample& sample);
  void go_on(const Checkpoint& checkpoint);
  [[nodiscard]] bool frames_wanted() const;
  void make_surfaces(std::vector<Frame> frames);

  const Case& given_;
  RunDirectory directory_;
  std::shared_ptr<const Log> log_;
  std::string scenario_text_;
  std::unique_ptr<Checkpoint> checkpoint_;
  Course course_;
  std::optional<Trajectory> trajectory_;
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
