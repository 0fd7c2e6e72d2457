// Where a rank's time goes within the time steps.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string_view>

namespace ductile::coupling {

/// The parts of a time step. Each moment of Coupler::step() belongs to one of them.
enum class Part : std::size_t {
  fluid,          ///< collision, streaming, and the exchange of halos
  boxes,          ///< velocities for bodies that ask for them; laying boxes anew
  locating,       ///< which markers reach which ranks
  interpolation,  ///< eq. (15), and the kernel's weights
  bodies,         ///< the bodies' own work: predict_force, correct_force, advance
  spreading,      ///< eq. (16), and the kernel's weights
  exchange,       ///< markers' positions, forces and velocities sent, awaited and put in order
  waiting         ///< for the slowest rank, at the end of the step
};
constexpr std::array<std::string_view, 8> part_names = {
    "fluid", "boxes", "locating", "interpolation", "bodies", "spreading", "exchange", "waiting"};

/// Time by part, on one rank, and what it has sent.
struct Profile {
  std::int64_t steps = 0;                           ///< completed
  std::array<double, part_names.size()> seconds{};  ///< by std::chrono::steady_clock
  /// To other ranks: the fluid's populations, markers, boxes, and what ranks agree upon.
  std::int64_t bytes_sent = 0;

  [[nodiscard]] double operator[](Part part) const {
    return seconds[static_cast<std::size_t>(part)];
  }
  /// All parts together: the time in Coupler::step().
  [[nodiscard]] double total() const {
    return std::accumulate(seconds.begin(), seconds.end(), 0.0);
  }
};

}  // namespace ductile::coupling
