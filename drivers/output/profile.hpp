// Where a run's time went: rank by rank, part by part.
#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ductile/coupling/profile.hpp"
#include "output/json.hpp"

namespace ductile::drivers {

/// Seconds of every rank in the loop of a run, by part.
struct RunProfile {
  static constexpr std::size_t parts = coupling::part_names.size() + 1;
  using Rank = std::array<double, parts>;

  /// The coupler's parts in their order, then "output": rows, frames, checks of the fluid, and
  /// whatever else the loop does outside of the time step.
  static std::array<std::string_view, parts> names();

  std::int64_t steps = 0;
  std::vector<Rank> ranks;
  std::vector<double> bytes_sent;  ///< to other ranks in a step, by every rank

  /// The largest of all ranks: in `part`, and in the time step as a whole (all parts but the
  /// output).
  [[nodiscard]] double largest(coupling::Part part) const;
  [[nodiscard]] double longest_step() const;
};

/// A stretch of a run that one process, or one job of them, has computed.
struct Leg {
  std::int64_t from = 0, to = 0;  ///< steps
  int ranks = 1;
  double wall_time = 0;          ///< [s]
  RunProfile::Rank core_time{};  ///< by part, of all ranks together [s]
};

/// The profile of all ranks, on rank 0; nothing on the others. `whole` is this rank's time in the
/// loop, of which the coupler does not know the output's. Collective. Throws fluid::MpiFailure.
std::optional<RunProfile> gathered(const coupling::Profile& own, double whole, MPI_Comm comm);

/// One row a part: seconds and share of each rank where there are at most four, and where there are
/// several their least, mean and largest.
std::string table(const RunProfile& profile);

/// A leg as an object.
void add_leg(Json& json, const Leg& leg);

/// An object: the steps, and by part the seconds of all ranks in their order.
void add_profile(Json& json, const RunProfile& profile);

}  // namespace ductile::drivers
