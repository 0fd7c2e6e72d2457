#include "markers.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace ductile::coupling {

using fluid::mpi_check;

void Markers::lay_routes(std::span<const Entry> entries) {
  routes_.clear();
  guests_.clear();
  std::size_t host = 0;
  for (std::size_t id = 0; id < entries.size(); ++id) {
    const Entry& entry = entries[id];
    if (fluid_.touches(comm_.rank(), entry.box)) {
      guests_.emplace_back(fluid_, static_cast<int>(id), entry);
    }
    if (entry.owner != comm_.rank()) continue;
    for (int r = 0; r < comm_.size(); ++r) {
      if (fluid_.touches(r, entry.box)) routes_.push_back({host, r, {}, {}, {}});
    }
    ++host;
  }
}

// The guest at the end of a route that stays on this rank.
Markers::Guest& Markers::guest_of(const Route& route) {
  return *std::find_if(guests_.begin(), guests_.end(),
                       [&](const Guest& guest) { return guest.id == hosts_[route.host].id; });
}

void Markers::send_positions() {
  for (Route& route : routes_) {
    fluid_.reached(route.rank, hosts_[route.host].position, route.markers, route.split);
  }
  watch_.lap(Part::locating);
  to_guests(Round::everybody(), true);
  for (Guest& guest : guests_) {
    guest.points.locate(std::span(guest.data).first(guest.data.size() / 2));
  }
  watch_.lap(Part::locating);
}

// Three numbers a marker, six with positions.
void Markers::to_guests(Round round, bool with_positions) {
  const std::size_t numbers = with_positions ? 6 : 3;
  std::vector<MPI_Request> requests;
  std::vector<std::pair<std::size_t, std::size_t>> receives;  // request, guest
  for (std::size_t g = 0; g < guests_.size(); ++g) {
    Guest& guest = guests_[g];
    if (!round.includes(guest.corrections) || guest.owner == comm_.rank()) continue;
    guest.data.resize(numbers * static_cast<std::size_t>(guest.markers));
    receives.emplace_back(requests.size(), g);
    mpi_check(MPI_Irecv(guest.data.data(), static_cast<int>(guest.data.size()), MPI_DOUBLE,
                        guest.owner, guest.id, comm_.get(), &requests.emplace_back()),
              "MPI_Irecv");
  }
  for (Route& route : routes_) {
    const Host& host = hosts_[route.host];
    if (!round.includes(host.corrections)) continue;
    std::vector<double>& buffer = stays(route) ? guest_of(route).data : route.buffer;
    buffer.resize(numbers * route.markers.size());
    double* to = buffer.data();
    const auto pack = [&](std::span<const double> values, double factor) {
      for (const int m : route.markers) {
        const double* from = &values[3 * static_cast<std::size_t>(m)];
        for (int axis = 0; axis < 3; ++axis) *to++ = factor * from[axis];
      }
    };
    if (with_positions) pack(host.position, 1);
    pack(host.force, host.share);
    if (stays(route)) continue;
    mpi_check(MPI_Isend(buffer.data(), static_cast<int>(buffer.size()), MPI_DOUBLE, route.rank,
                        host.id, comm_.get(), &requests.emplace_back()),
              "MPI_Isend");
    watch_.profile.bytes_sent += static_cast<std::int64_t>(buffer.size() * sizeof(double));
  }
  std::vector<MPI_Status> statuses(requests.size());
  mpi_check(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), statuses.data()),
            "MPI_Waitall");
  for (const auto& [request, g] : receives) {
    int count = 0;
    mpi_check(MPI_Get_count(&statuses[request], MPI_DOUBLE, &count), "MPI_Get_count");
    guests_[g].data.resize(static_cast<std::size_t>(count));
  }
  watch_.lap(Part::exchange);
}

void Markers::spread(Round round) {
  for (Guest& guest : guests_) {
    if (!round.includes(guest.corrections)) continue;
    guest.points.add_force(std::span(guest.data).last(3 * guest.points.size()));
  }
  watch_.lap(Part::spreading);
}

void Markers::interpolate(Round round) {
  for (Guest& guest : guests_) {
    if (!round.includes(guest.corrections)) continue;
    const std::size_t whole = 3 * guest.points.size();
    const std::size_t parts = 12 * guest.points.split();
    guest.answer.resize(whole + parts);
    guest.points.velocities(std::span(guest.answer).first(whole),
                            std::span(guest.answer).last(parts));
  }
  watch_.lap(Part::interpolation);
  to_hosts(round);
  take_answers(round);
  watch_.lap(Part::exchange);
}

// Guests answer with three numbers for each marker, its velocity where they hold all four planes
// that it reaches and of no meaning elsewhere, and then with the four terms of those others, which
// the owner adds up in the same order.
void Markers::to_hosts(Round round) {
  std::vector<MPI_Request> requests;
  for (Route& route : routes_) {
    const Host& host = hosts_[route.host];
    if (!round.includes(host.corrections) || stays(route)) continue;
    route.buffer.resize(3 * route.markers.size() + 12 * route.split.size());
    mpi_check(MPI_Irecv(route.buffer.data(), static_cast<int>(route.buffer.size()), MPI_DOUBLE,
                        route.rank, host.id, comm_.get(), &requests.emplace_back()),
              "MPI_Irecv");
  }
  for (const Guest& guest : guests_) {
    if (!round.includes(guest.corrections) || guest.owner == comm_.rank()) continue;
    mpi_check(MPI_Isend(guest.answer.data(), static_cast<int>(guest.answer.size()), MPI_DOUBLE,
                        guest.owner, guest.id, comm_.get(), &requests.emplace_back()),
              "MPI_Isend");
    watch_.profile.bytes_sent += static_cast<std::int64_t>(guest.answer.size() * sizeof(double));
  }
  mpi_check(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE),
            "MPI_Waitall");
}

void Markers::take_answers(Round round) {
  // Calls f(host, route, answer) for all answers.
  const auto for_answers = [&](auto&& f) {
    for (const Route& route : routes_) {
      Host& host = hosts_[route.host];
      if (!round.includes(host.corrections)) continue;
      f(host, route, stays(route) ? guest_of(route).answer.data() : route.buffer.data());
    }
  };
  // Calls f(marker, parts) for the answer's markers that are split.
  const auto for_split = [](const Route& route, const double* answer, auto&& f) {
    const double* parts = answer + 3 * route.markers.size();
    for (const std::size_t n : route.split) {
      f(static_cast<std::size_t>(route.markers[n]), parts);
      parts += 12;
    }
  };
  for_answers([&](Host& host, const Route& route, const double* answer) {
    for (const int m : route.markers) {
      std::copy_n(answer, 3, &host.velocity[3 * static_cast<std::size_t>(m)]);
      answer += 3;
    }
  });
  for_answers([&](Host& host, const Route& route, const double* answer) {
    for_split(route, answer, [&](std::size_t m, const double* /*parts*/) {
      std::fill_n(&host.partial[12 * m], 12, 0.0);
    });
  });
  for_answers([&](Host& host, const Route& route, const double* answer) {
    for_split(route, answer, [&](std::size_t m, const double* parts) {
      for (std::size_t n = 0; n < 12; ++n) host.partial[12 * m + n] += parts[n];
    });
  });
  for_answers([&](Host& host, const Route& route, const double* answer) {
    for_split(route, answer, [&](std::size_t m, const double* /*parts*/) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        host.velocity[3 * m + axis] = fluid::sum_of_planes(&host.partial[12 * m + 4 * axis]);
    });
  });
}

}  // namespace ductile::coupling
