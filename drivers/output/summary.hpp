// summary.json: what came of a run.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/verdict.hpp"
#include "ductile/membrane/integrator.hpp"
#include "output/profile.hpp"

namespace ductile::drivers {

/// Why a run ended.
enum class RunStatus {
  finished,       ///< "finished": it reached its end time, and nothing was left to decide
  decided,        ///< "decided": the verdict of the pair was clear before
  stop_distance,  ///< "stopped at dz": the particles of the pair are too far apart
  contact,        ///< "contact": surfaces have crossed, or a body has come to a wall
  time_limit,     ///< "time limit": it reached its end time with the pair undecided
  interrupted,    ///< "interrupted": by a signal
  walltime,       ///< "walltime": it has used up the time that it was given
  blew_up         ///< "blew up"
};
std::string_view to_string(RunStatus status);

/// Where a run blew up.
struct BlowUp {
  std::int64_t step = 0;
  std::string body;                   ///< empty: the fluid
  std::optional<std::size_t> vertex;  ///< of the body, where one is known
  std::string reason;
  std::optional<Eigen::Vector3d> place{};  ///< [W]; z in the channel
  std::string cause{};                     ///< the likely one

  /// "the fluid" or "body NAME".
  [[nodiscard]] std::string who() const { return body.empty() ? "the fluid" : "body " + body; }
};

struct CapsuleSummary {
  double k_v = 0;                      ///< used [rho nu^2/W^2]
  double volume_error_max = 0;         ///< largest |V - V0|/V0 of the run
  double deformation = 0;              ///< Taylor's D at the end
  double strain_energy = 0;            ///< E_s/(k_s a^2) at the end
  std::optional<Outlook> strain;       ///< nothing: the run is too short to tell
  membrane::SolveStatistics solver{};  ///< of the whole run; zeros where nothing is solved
};

struct BodySummary {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< at the end [W]; z not wrapped
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< at the end [nu/W]
  std::optional<Outlook> lateral;                      ///< of x; nothing: too short to tell
  std::optional<CapsuleSummary> capsule;
};

/// A gap that the lattice does not resolve.
struct ContactSummary {
  std::string body, other;  ///< as messages call them
  double gap = 0;           ///< the smallest [W]; less than 0 where the surfaces overlap
  double gap_nodes = 0;     ///< the same in lattice spacings
  double time = 0;          ///< of it [W^2/nu]
  double since = 0;         ///< when it was first under the kernel's reach [W^2/nu]
  bool crossed = false;
};

struct Summary {
  std::string scenario;  ///< name or file
  /// Keys of the scenario and their values, as JSON.
  std::vector<std::pair<std::string, std::string>> parameters;
  RunStatus status = RunStatus::finished;
  std::optional<BlowUp> blow_up;
  int signal = 0;              ///< that has ended the run, if one has
  std::string contact_reason;  ///< why the contact has ended the run, if one has
  double time = 0;             ///< simulated [W^2/nu]
  std::int64_t steps = 0;
  std::optional<Verdict> verdict;  ///< of a pair
  std::optional<double> dz;        ///< of a pair, at the end [W]
  std::vector<BodySummary> bodies;
  std::vector<ContactSummary> contacts;
  std::vector<std::string> warnings;
  double wall_time = 0;               ///< of all legs [s]
  double updates_per_second = 0;      ///< lattice nodes x steps / wall time
  int ranks = 1;                      ///< of the last leg
  std::vector<Leg> legs;              ///< one, unless the run was resumed
  std::optional<RunProfile> profile;  ///< where it was asked for
  std::vector<std::pair<std::string, std::string>> versions;
};

/// The summary as JSON.
std::string to_json(const Summary& summary);

/// Parts of it that compare.json has too: "blow_up", and "solver", which is left out of a scheme
/// that solves nothing.
void add_blow_up(Json& json, const BlowUp& blow_up);
void add_solver(Json& json, const membrane::SolveStatistics& solver, std::int64_t steps);

/// Writes it to `file`, whole or not at all. Throws OutputError.
void write_summary(const std::filesystem::path& file, const Summary& summary);

}  // namespace ductile::drivers
