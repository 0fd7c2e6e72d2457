// Markers between the ranks that own their bodies and those that hold the fluid around them.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "ductile/coupling/body.hpp"
#include "ductile/fluid/fluid.hpp"
#include "ductile/fluid/mpi.hpp"
#include "ductile/fluid/points.hpp"
#include "response.hpp"
#include "stopwatch.hpp"

namespace ductile::coupling {

/// What every rank knows of every body.
struct Entry {
  int owner = 0;
  int markers = 0;
  int corrections = 0;
  fluid::Box box{};  ///< around it; z of the image where the owner has it
};

/// A body of this rank.
struct Host {
  int id = 0;
  Body* body = nullptr;
  int corrections = 0;
  /// Of its force, what it exerts itself: half where a mirror plane makes the body its own image,
  /// which exerts the other half.
  double share = 1;
  std::vector<double> position;  ///< of its markers, on the lattice
  std::vector<double> force;     ///< what it adds now
  std::vector<double> velocity;  ///< of its markers, with the force so far
  std::vector<double> partial;   ///< four terms of each component, a marker
  MarkerResponse response;
  bool located = false;  ///< where the markers are in this step: the response
};

/// Which bodies exchange forces and velocities: all of them, or those that take part in a
/// correction.
class Round {
 public:
  static constexpr Round everybody() { return Round(std::nullopt); }
  /// The n-th correction, from 0: bodies that ask for more than n.
  static constexpr Round correction(int n) { return Round(n); }
  [[nodiscard]] constexpr bool includes(int corrections) const {
    return !correction_ || *correction_ < corrections;
  }

 private:
  explicit constexpr Round(std::optional<int> correction) : correction_(correction) {}
  std::optional<int> correction_;
};

/// Brings markers' positions and forces to the ranks that hold the fluid around them, and the
/// fluid's velocities back. All members but the constructor are called by all ranks in the same
/// order. Their time and the bytes that they send go to the stopwatch's profile.
class Markers {
 public:
  /// All arguments outlive this.
  Markers(fluid::Fluid& fluid, const fluid::Communicator& comm, std::vector<Host>& hosts,
          Stopwatch& watch)
      : fluid_(fluid), comm_(comm), hosts_(hosts), watch_(watch) {}

  /// When boxes have been placed around the bodies, in the order of their ids: which bodies and
  /// which ranks have to do with each other until they are placed anew.
  void lay_routes(std::span<const Entry> entries);
  /// At the start of a step: positions, and everybody's forces.
  void send_positions();
  /// Forces of a correction.
  void send_forces(Round round) { to_guests(round, false); }
  /// The forces that have arrived act on the fluid, eq. (16).
  void spread(Round round);
  /// Host::velocity <- that of the fluid, eq. (15).
  void interpolate(Round round);

 private:
  // The part of a host's markers that reaches one rank.
  struct Route {
    std::size_t host;
    int rank;
    std::vector<int> markers;
    std::vector<std::size_t> split;  // of them, those of which that rank does not hold all nodes
    std::vector<double> buffer;
  };
  // The same markers on the rank that they reach.
  struct Guest {
    Guest(fluid::Fluid& fluid, int body, const Entry& entry)
        : id(body),
          owner(entry.owner),
          markers(entry.markers),
          corrections(entry.corrections),
          points(fluid, body) {}
    int id;
    int owner;
    int markers;  // of the whole body
    int corrections;
    fluid::Points points;
    std::vector<double> data;    // positions, where they are sent, and forces after them
    std::vector<double> answer;  // velocities, and after them the parts of those that are split
  };

  [[nodiscard]] bool stays(const Route& route) const { return route.rank == comm_.rank(); }
  Guest& guest_of(const Route& route);
  void to_guests(Round round, bool with_positions);
  void to_hosts(Round round);
  void take_answers(Round round);

  fluid::Fluid& fluid_;
  const fluid::Communicator& comm_;
  std::vector<Host>& hosts_;
  Stopwatch& watch_;
  std::vector<Route> routes_;
  std::vector<Guest> guests_;  // in the order of ids
};

}  // namespace ductile::coupling
