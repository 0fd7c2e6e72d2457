#include "output/profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "ductile/fluid/mpi.hpp"

namespace ductile::drivers {
namespace {

using fluid::mpi_check;

constexpr std::size_t most_shown_ranks = 4;

double sum(const RunProfile::Rank& rank, std::size_t count) {
  return std::accumulate(rank.begin(), rank.begin() + static_cast<std::ptrdiff_t>(count), 0.0);
}

/// The seconds of all ranks in one part, and the whole runs of which they are shares.
std::string row(std::string_view name, const std::vector<double>& seconds,
                const std::vector<double>& whole, double steps) {
  std::string text = fmt::format("{:<14}", name);
  const std::size_t count = seconds.size();
  const auto share = [](double part, double all) { return all > 0 ? 100 * part / all : 0.0; };
  if (count <= most_shown_ranks) {
    for (std::size_t r = 0; r < count; ++r)
      text += fmt::format(" {:>9.2f} {:>5.1f}%", seconds[r], share(seconds[r], whole[r]));
  }
  const auto [least, largest] = std::minmax_element(seconds.begin(), seconds.end());
  const double all = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  if (count > 1) {
    text += fmt::format(" {:>9.2f} {:>9.2f} {:>9.2f}", *least, all / static_cast<double>(count),
                        *largest);
  }
  if (count > most_shown_ranks)
    text += fmt::format(" {:>5.1f}%", share(all, std::accumulate(whole.begin(), whole.end(), 0.0)));
  return text + fmt::format(" {:>11.4f}\n", steps > 0 ? 1e3 * *largest / steps : 0.0);
}

}  // namespace

std::array<std::string_view, RunProfile::parts> RunProfile::names() {
  std::array<std::string_view, parts> names;
  std::copy(coupling::part_names.begin(), coupling::part_names.end(), names.begin());
  names.back() = "output";
  return names;
}

std::optional<RunProfile> gathered(const coupling::Profile& own, double whole, MPI_Comm comm) {
  int rank = 0;
  int ranks = 1;
  mpi_check(MPI_Comm_rank(comm, &rank), "MPI_Comm_rank");
  mpi_check(MPI_Comm_size(comm, &ranks), "MPI_Comm_size");
  RunProfile::Rank mine{};
  std::copy(own.seconds.begin(), own.seconds.end(), mine.begin());
  mine.back() = whole - own.total();
  RunProfile profile;
  profile.steps = own.steps;
  const double bytes =
      own.steps > 0 ? static_cast<double>(own.bytes_sent) / static_cast<double>(own.steps) : 0;
  if (rank == 0) {
    profile.ranks.resize(static_cast<std::size_t>(ranks));
    profile.bytes_sent.resize(static_cast<std::size_t>(ranks));
  }
  constexpr int count = static_cast<int>(RunProfile::parts);
  mpi_check(
      MPI_Gather(mine.data(), count, MPI_DOUBLE, profile.ranks.data(), count, MPI_DOUBLE, 0, comm),
      "MPI_Gather");
  mpi_check(MPI_Gather(&bytes, 1, MPI_DOUBLE, profile.bytes_sent.data(), 1, MPI_DOUBLE, 0, comm),
            "MPI_Gather");
  return rank == 0 ? std::optional(std::move(profile)) : std::nullopt;
}

double RunProfile::largest(coupling::Part part) const {
  double most = 0;
  for (const Rank& rank : ranks) most = std::max(most, rank[static_cast<std::size_t>(part)]);
  return most;
}

double RunProfile::longest_step() const {
  double most = 0;
  for (const Rank& rank : ranks) most = std::max(most, sum(rank, parts - 1));
  return most;
}

std::string table(const RunProfile& profile) {
  const std::size_t count = profile.ranks.size();
  std::string text = fmt::format("{:<14}", "time by part");
  if (count <= most_shown_ranks) {
    for (std::size_t r = 0; r < count; ++r)
      text += fmt::format(" {:>16}", fmt::format("rank {} [s]", r));
  }
  if (count > 1) text += fmt::format(" {:>9} {:>9} {:>9}", "least [s]", "mean [s]", "most [s]");
  if (count > most_shown_ranks) text += fmt::format(" {:>6}", "share");
  text += fmt::format(" {:>11}\n", count > 1 ? "most ms/step" : "ms/step");

  std::vector<double> whole;
  for (const RunProfile::Rank& rank : profile.ranks) whole.push_back(sum(rank, RunProfile::parts));
  const auto steps = static_cast<double>(profile.steps);
  const auto names = RunProfile::names();
  for (std::size_t part = 0; part < names.size(); ++part) {
    std::vector<double> seconds;
    for (const RunProfile::Rank& rank : profile.ranks) seconds.push_back(rank[part]);
    text += row(names[part], seconds, whole, steps);
  }
  text += row("whole run", whole, whole, steps);
  if (count > 1) {
    const auto [least, most] =
        std::minmax_element(profile.bytes_sent.begin(), profile.bytes_sent.end());
    text += fmt::format("each rank sends {:.1f} to {:.1f} kB a step\n", *least / 1e3, *most / 1e3);
  }
  return text;
}

void add_leg(Json& json, const Leg& leg) {
  json.open('{');
  json.add("from_step", leg.from);
  json.add("to_step", leg.to);
  json.add("ranks", leg.ranks);
  json.add("wall_time_s", leg.wall_time);
  json.open('{', "core_time_s");
  for (std::size_t p = 0; p < RunProfile::parts; ++p)
    json.add(RunProfile::names()[p], leg.core_time[p]);
  json.close('}');
  json.close('}');
}

void add_profile(Json& json, const RunProfile& profile) {
  json.add("steps", profile.steps);
  json.open('{', "seconds_by_rank");
  const auto names = RunProfile::names();
  for (std::size_t part = 0; part < names.size(); ++part) {
    std::vector<double> seconds;
    for (const RunProfile::Rank& rank : profile.ranks) seconds.push_back(rank[part]);
    json.add(names[part], std::span<const double>(seconds));
  }
  json.close('}');
  json.add("bytes_sent_a_step_by_rank", std::span<const double>(profile.bytes_sent));
}

}  // namespace ductile::drivers
