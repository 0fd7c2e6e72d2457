#include "ductile/coupling/coupler.hpp"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <cmath>
#include <optional>
#include <utility>

#include "ductile/coupling/kernel.hpp"
#include "ductile/coupling/stencils.hpp"
#include "ductile/fluid/mpi.hpp"
#include "layout.hpp"

namespace ductile::coupling {
namespace {

using fluid::mpi_check;

// How far a body may move before its box is laid anew: a node across the channel, two along it.
constexpr std::array<int, 3> margin = {1, 1, 2};

// What every rank knows of every body.
struct Entry {
  int owner = 0;
  int markers = 0;
  int corrections = 0;
  fluid::Box box{};  // z of the image where the owner has it
  int merged = 0;    // the fluid's box that it lies in
};
constexpr int entry_size = 9;

constexpr int no_marker = -1;

// A body of this rank.
struct Host {
  int id = 0;
  Body* body = nullptr;
  std::vector<double> force;     // what a round adds, sent to the guests
  std::vector<double> velocity;  // what they answer
  std::vector<double> partial;
  std::vector<int> planes;  // first plane of each marker's stencil
  MarkerResponse response;
  bool located = false;  // where the markers are in this step
};

// The part of a host's markers that reaches the slab of one rank.
struct Route {
  std::size_t host = 0;
  int rank = 0;
  std::vector<int> markers;
  std::vector<char> whole;  // whether that rank has all planes of the marker's stencil
  std::vector<double> buffer;
};

// The same markers on the rank that they reach.
struct Guest {
  int id = 0;
  int owner = 0;
  std::vector<double> data;  // positions, where they are sent, and forces after them
  Stencils stencils;
  std::vector<double> partial;
  std::vector<double> buffer;
};

// Divides the time of a step into laps: each ends where the next begins, so none is lost.
class Stopwatch {
 public:
  void start() { last_ = Clock::now(); }
  /// The time since the lap before goes to `part`.
  void lap(Part part) {
    const Clock::time_point now = Clock::now();
    profile.seconds[static_cast<std::size_t>(part)] +=
        std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

  Profile profile;

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_;
};

}  // namespace

BodyFailure::BodyFailure(int body, std::optional<std::size_t> marker, std::int64_t step,
                         const std::string& reason)
    : std::runtime_error("body " + std::to_string(body) + ", step " + std::to_string(step) + ": " +
                         reason),
      body_(body),
      marker_(marker),
      step_(step),
      reason_(reason) {}

class Coupler::Impl {
 public:
  Impl(fluid::Fluid& fluid, std::vector<Member> members, int total);

  void step();
  Stopwatch watch_;

 private:
  void lay_out();
  void locate();
  void predict_forces();
  void correct_forces(int round);
  void advance();
  void spread(int round);
  void interpolate(int round);
  void agree();

  std::optional<fluid::Box> stencil_box(const Host& host);
  void fail(const Host& host, int marker, const std::string& reason);
  void sent(std::size_t bytes) {
    if (comm_.size() > 1) watch_.profile.bytes_sent += static_cast<std::int64_t>(bytes);
  }
  [[nodiscard]] bool takes_part(int id, int round) const {
    return round < 0 || round < entries_[static_cast<std::size_t>(id)].corrections;
  }
  template <class F>
  void guarded(Host& host, const F& f);
  void to_guests(int round, bool with_positions);
  void to_hosts(int round);

  fluid::Fluid& fluid_;
  fluid::Communicator comm_;
  fluid::InstructionSet instruction_set_;
  int period_;
  std::vector<Host> hosts_;
  std::vector<Entry> entries_;
  std::vector<Route> routes_;
  std::vector<Guest> guests_;
  int rounds_ = 0;
  bool moved_out_ = true;
  std::int64_t time_ = 0;  // at the start of the step
  int failed_ = INT_MAX;   // lowest id of a body that failed in this step
  int failed_marker_ = no_marker;
  std::string reason_;
};

Coupler::Impl::Impl(fluid::Fluid& fluid, std::vector<Member> members, int total)
    : fluid_(fluid),
      comm_(fluid.comm()),
      instruction_set_(*fluid.options().instruction_set),
      period_(fluid.options().boundary[2] == fluid::Boundary::periodic ? fluid.options().nodes[2]
                                                                       : 0) {
  std::sort(members.begin(), members.end(),
            [](const Member& a, const Member& b) { return a.id < b.id; });
  std::vector<int> owners(static_cast<std::size_t>(std::max(total, 0)) + 1, 0);
  for (const Member& member : members) {
    // The last entry counts ids out of range.
    ++owners[static_cast<std::size_t>(member.id >= 0 && member.id < total ? member.id
                                                                          : std::max(total, 0))];
    Host host;
    host.id = member.id;
    host.body = member.body;
    host.response = MarkerResponse(instruction_set_);
    const std::size_t size = 3 * member.body->marker_count();
    host.force.resize(size);
    host.velocity.resize(size);
    host.partial.resize(4 * size);
    hosts_.push_back(std::move(host));
  }
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, owners.data(), static_cast<int>(owners.size()), MPI_INT,
                          MPI_SUM, comm_.get()),
            "MPI_Allreduce");
  const int strangers = owners.back();
  owners.pop_back();
  if (strangers != 0 || !std::all_of(owners.begin(), owners.end(), [](int n) { return n == 1; })) {
    throw std::invalid_argument("coupler: the ranks' bodies must have the ids 0 to " +
                                std::to_string(total - 1) + ", each once");
  }
  entries_.resize(owners.size());
}

// The time step. Bodies and fluid exchange marker velocities and forces; eq. numbers as the paper.
void Coupler::Impl::step() {
  watch_.start();
  time_ = fluid_.time();
  if (moved_out_) lay_out();
  predict_forces();
  locate();
  spread(-1);                               // eq. (16)
  if (rounds_ > 0) fluid_.read_velocity();  // u0: eqs. (5) and (6) with the uniform force
  watch_.lap(Part::boxes);
  for (int round = 0; round < rounds_; ++round) {
    fluid_.update_velocity();
    watch_.lap(Part::boxes);
    interpolate(round);
    correct_forces(round);
    spread(round);
  }
  const std::int64_t sent_before = fluid_.bytes_sent();
  fluid_.step();  // eqs. (2)-(4); the velocity at the step's start, half of the force in, is left
  watch_.profile.bytes_sent += fluid_.bytes_sent() - sent_before;
  watch_.lap(Part::fluid);
  interpolate(-1);  // eq. (15)
  advance();
  agree();
  ++watch_.profile.steps;
}

// Runs f, which calls the host's body; a failure ends the step when all ranks agree on it.
template <class F>
void Coupler::Impl::guarded(Host& host, const F& f) {
  if (failed_ <= host.id) return;
  try {
    f(*host.body);
  } catch (const MarkerError& error) {
    fail(host, static_cast<int>(error.marker()), error.what());
  } catch (const std::exception& error) {
    fail(host, no_marker, error.what());
  }
}

// Of several failures in a step, that of the first body is reported.
void Coupler::Impl::fail(const Host& host, int marker, const std::string& reason) {
  if (failed_ <= host.id) return;
  failed_ = host.id;
  failed_marker_ = marker;
  reason_ = reason;
}

void Coupler::Impl::predict_forces() {
  for (Host& host : hosts_) {
    std::fill(host.force.begin(), host.force.end(), 0.0);
    guarded(host, [&](Body& body) { body.predict_force(host.force); });
  }
  watch_.lap(Part::bodies);
}

void Coupler::Impl::correct_forces(int round) {
  for (Host& host : hosts_) {
    if (!takes_part(host.id, round)) continue;
    std::fill(host.force.begin(), host.force.end(), 0.0);
    guarded(host, [&](Body& body) {
      // Located on the first call: only a body that solves asks for it.
      class Lazy final : public Response {
       public:
        explicit Lazy(Host& host) : host_(host) {}
        void apply(std::span<const double> force, std::span<double> velocity) const override {
          if (!host_.located) host_.response.locate(host_.body->positions());
          host_.located = true;
          host_.response.apply(force, velocity);
        }

       private:
        Host& host_;
      };
      body.correct_force(host.velocity, Lazy(host), host.force);
    });
  }
  watch_.lap(Part::bodies);
}

void Coupler::Impl::advance() {
  for (Host& host : hosts_) {
    guarded(host, [&](Body& body) {
      body.advance(host.velocity);
      const auto box = stencil_box(host);
      const fluid::Box& laid = entries_[static_cast<std::size_t>(host.id)].box;
      for (std::size_t axis = 0; axis < 3 && box; ++axis) {
        moved_out_ = moved_out_ || (*box)[axis].begin < laid[axis].begin ||
                     (*box)[axis].end > laid[axis].end;
      }
    });
  }
  watch_.lap(Part::bodies);
}

// The nodes that the host's markers reach; nothing and a failure if one is not finite.
std::optional<fluid::Box> Coupler::Impl::stencil_box(const Host& host) {
  const std::span<const double> x = host.body->positions();
  std::array<double, 3> low{INFINITY, INFINITY, INFINITY};
  std::array<double, 3> high{-INFINITY, -INFINITY, -INFINITY};
  for (std::size_t n = 0; n < x.size(); n += 3) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!(std::abs(x[n + axis]) < 1e9)) {
        fail(host, static_cast<int>(n / 3),
             "the position of vertex " + std::to_string(n / 3) + " is not finite");
        return std::nullopt;
      }
      low[axis] = std::min(low[axis], x[n + axis]);
      high[axis] = std::max(high[axis], x[n + axis]);
    }
  }
  fluid::Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box[axis] = {static_cast<int>(std::floor(low[axis])) - 1,
                 static_cast<int>(std::floor(high[axis])) + 3};
  }
  return box;
}

// The host's marker of lowest or highest coordinate.
std::size_t extreme_marker(const Host& host, std::size_t axis, bool lowest) {
  const std::span<const double> x = host.body->positions();
  std::size_t found = 0;
  for (std::size_t m = 1; m < x.size() / 3; ++m) {
    const double here = x[3 * m + axis];
    const double best = x[3 * found + axis];
    if (lowest ? here < best : here > best) found = m;
  }
  return found;
}

// Lays the boxes around the bodies, and finds out which ranks they touch.
void Coupler::Impl::lay_out() {
  const fluid::Box domain = fluid_.domain();
  std::vector<int> table(entries_.size() * entry_size, INT_MIN);
  for (Host& host : hosts_) {
    fluid::Box box{};
    if (const auto reach = stencil_box(host)) {
      box = *reach;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool runs_on = axis == 2 && period_ > 0;
        if (!runs_on &&
            (box[axis].begin < domain[axis].begin || box[axis].end > domain[axis].end)) {
          const std::size_t vertex =
              extreme_marker(host, axis, box[axis].begin < domain[axis].begin);
          fail(host, static_cast<int>(vertex),
               "vertex " + std::to_string(vertex) + " is too close to the boundary along " +
                   "xyz"[axis] +
                   " for the 4-point kernel, which reaches two nodes; use more nodes");
          break;
        }
        if (runs_on && box[axis].size() > period_) {
          fail(host, no_marker,
               "the body is longer than the periodic channel; use a longer channel");
          break;
        }
        box[axis].begin -= margin[axis];
        box[axis].end += margin[axis];
        if (runs_on) {
          const int whole_vectors = (box[axis].size() + 7) / 8 * 8;
          box[axis].end = box[axis].begin + std::min(whole_vectors, period_);
        } else {
          box[axis].begin = std::max(box[axis].begin, domain[axis].begin);
          box[axis].end = std::min(box[axis].end, domain[axis].end);
        }
      }
      box = fluid_.with_image(box);
    }
    int* row = &table[static_cast<std::size_t>(host.id) * entry_size];
    row[0] = comm_.rank();
    row[1] = static_cast<int>(host.body->marker_count());
    row[2] = host.body->corrections();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      row[3 + 2 * axis] = box[axis].begin;
      row[4 + 2 * axis] = box[axis].end;
    }
  }
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, table.data(), static_cast<int>(table.size()), MPI_INT,
                          MPI_MAX, comm_.get()),
            "MPI_Allreduce");
  sent(table.size() * sizeof(int));
  for (std::size_t id = 0; id < entries_.size(); ++id) {
    const int* row = &table[id * entry_size];
    Entry& entry = entries_[id];
    entry.owner = row[0];
    entry.markers = row[1];
    entry.corrections = row[2];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      entry.box[axis] = {row[3 + 2 * axis], row[4 + 2 * axis]};
    }
  }
  moved_out_ = false;
  watch_.lap(Part::boxes);
  agree();

  std::vector<fluid::Box> boxes;
  for (const Entry& entry : entries_) boxes.push_back(entry.box);
  const std::vector<fluid::Box> disjoint = merged(boxes, period_);
  fluid_.place_boxes(disjoint);
  for (Entry& entry : entries_) {
    const auto holder = std::find_if(disjoint.begin(), disjoint.end(), [&](const fluid::Box& box) {
      return contains(box, entry.box, period_);
    });
    entry.merged = static_cast<int>(holder - disjoint.begin());
  }
  rounds_ = 0;
  routes_.clear();
  guests_.clear();
  std::size_t host = 0;
  for (std::size_t id = 0; id < entries_.size(); ++id) {
    const Entry& entry = entries_[id];
    rounds_ = std::max(rounds_, entry.corrections);
    const fluid::Range z = entry.box[2];
    if (touches(z.begin, z.size(), fluid_.slab(), period_)) {
      Guest guest;
      guest.id = static_cast<int>(id);
      guest.owner = entry.owner;
      guest.stencils = Stencils(instruction_set_);
      guests_.push_back(std::move(guest));
    }
    if (entry.owner != comm_.rank()) continue;
    for (int r = 0; r < comm_.size(); ++r) {
      if (!touches(z.begin, z.size(), fluid_.slab(r), period_)) continue;
      Route route;
      route.host = host;
      route.rank = r;
      routes_.push_back(std::move(route));
    }
    ++host;
  }
}

// Owners send the forces of a round, and before them positions if they are new, to the ranks that
// the markers reach: three numbers a marker each.
void Coupler::Impl::to_guests(int round, bool with_positions) {
  const std::size_t numbers = with_positions ? 6 : 3;
  std::vector<MPI_Request> requests;
  std::vector<std::pair<std::size_t, std::size_t>> receives;  // request, guest
  for (std::size_t g = 0; g < guests_.size(); ++g) {
    Guest& guest = guests_[g];
    if (!takes_part(guest.id, round) || guest.owner == comm_.rank()) continue;
    guest.data.resize(
        numbers * static_cast<std::size_t>(entries_[static_cast<std::size_t>(guest.id)].markers));
    receives.emplace_back(requests.size(), g);
    mpi_check(MPI_Irecv(guest.data.data(), static_cast<int>(guest.data.size()), MPI_DOUBLE,
                        guest.owner, guest.id, comm_.get(), &requests.emplace_back()),
              "MPI_Irecv");
  }
  for (Route& route : routes_) {
    const Host& host = hosts_[route.host];
    if (!takes_part(host.id, round)) continue;
    std::vector<double>* buffer = &route.buffer;
    if (route.rank == comm_.rank()) {
      buffer = &std::find_if(guests_.begin(), guests_.end(), [&](const Guest& guest) {
                  return guest.id == host.id;
                })->data;
    }
    buffer->resize(numbers * route.markers.size());
    double* to = buffer->data();
    const auto pack = [&](std::span<const double> values) {
      for (const int m : route.markers) {
        to = std::copy_n(&values[3 * static_cast<std::size_t>(m)], 3, to);
      }
    };
    if (with_positions) pack(host.body->positions());
    pack(host.force);
    if (route.rank == comm_.rank()) continue;
    mpi_check(MPI_Isend(route.buffer.data(), static_cast<int>(route.buffer.size()), MPI_DOUBLE,
                        route.rank, host.id, comm_.get(), &requests.emplace_back()),
              "MPI_Isend");
    sent(route.buffer.size() * sizeof(double));
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

void Coupler::Impl::locate() {
  for (Host& host : hosts_) {
    host.located = false;
    const std::span<const double> x = host.body->positions();
    host.planes.resize(x.size() / 3);
    for (std::size_t m = 0; m < host.planes.size(); ++m) {
      host.planes[m] = floor_of(x[3 * m + 2]) - 1;
    }
  }
  for (Route& route : routes_) {
    const Host& host = hosts_[route.host];
    const fluid::Range slab = fluid_.slab(route.rank);
    route.markers.clear();
    route.whole.clear();
    for (std::size_t m = 0; m < host.planes.size(); ++m) {
      if (!touches(host.planes[m], 4, slab, period_)) continue;
      route.markers.push_back(static_cast<int>(m));
      route.whole.push_back(within(host.planes[m], 4, slab, period_) ? 1 : 0);
    }
  }
  watch_.lap(Part::locating);
  to_guests(-1, true);
  for (Guest& guest : guests_) {
    guest.stencils.locate(std::span(guest.data).first(guest.data.size() / 2));
  }
  watch_.lap(Part::locating);
}

// With the positions the first round's forces have come too.
void Coupler::Impl::spread(int round) {
  if (round >= 0) to_guests(round, false);
  for (const Guest& guest : guests_) {
    if (!takes_part(guest.id, round)) continue;
    const int box = entries_[static_cast<std::size_t>(guest.id)].merged;
    for (fluid::Patch& patch : fluid_.patches()) {
      if (patch.box == box) {
        guest.stencils.spread(std::span(guest.data).last(3 * guest.stencils.size()), patch,
                              period_);
      }
    }
  }
  watch_.lap(Part::spreading);
}

void Coupler::Impl::interpolate(int round) {
  for (Guest& guest : guests_) {
    if (!takes_part(guest.id, round)) continue;
    const std::size_t count = guest.stencils.size();
    guest.partial.assign(12 * count, 0.0);
    const int box = entries_[static_cast<std::size_t>(guest.id)].merged;
    for (const fluid::Patch& patch : fluid_.patches()) {
      if (patch.box == box) guest.stencils.interpolate(patch, period_, guest.partial);
    }
  }
  watch_.lap(Part::interpolation);
  to_hosts(round);
}

// Guests answer with the velocity of each marker: its sum over the four planes where they hold them
// all, else the four terms, which the owner sums in the same order.
void Coupler::Impl::to_hosts(int round) {
  std::vector<MPI_Request> requests;
  for (Route& route : routes_) {
    const Host& host = hosts_[route.host];
    if (!takes_part(host.id, round) || route.rank == comm_.rank()) continue;
    route.buffer.resize(12 * route.markers.size());
    mpi_check(MPI_Irecv(route.buffer.data(), static_cast<int>(route.buffer.size()), MPI_DOUBLE,
                        route.rank, host.id, comm_.get(), &requests.emplace_back()),
              "MPI_Irecv");
  }
  const auto sum = [](const double* p) { return ((p[0] + p[1]) + p[2]) + p[3]; };
  for (Guest& guest : guests_) {
    if (!takes_part(guest.id, round)) continue;
    if (guest.buffer.size() < guest.partial.size()) guest.buffer.resize(guest.partial.size());
    double* end = guest.buffer.data();
    for (std::size_t m = 0; m < guest.stencils.size(); ++m) {
      const double* partial = &guest.partial[12 * m];
      if (within(guest.stencils[m].base[2], 4, fluid_.slab(), period_)) {
        for (std::size_t axis = 0; axis < 3; ++axis) *end++ = sum(partial + 4 * axis);
      } else {
        end = std::copy_n(partial, 12, end);
      }
    }
    if (guest.owner == comm_.rank()) continue;
    const auto count = static_cast<std::size_t>(end - guest.buffer.data());
    mpi_check(MPI_Isend(guest.buffer.data(), static_cast<int>(count), MPI_DOUBLE, guest.owner,
                        guest.id, comm_.get(), &requests.emplace_back()),
              "MPI_Isend");
    sent(count * sizeof(double));
  }
  mpi_check(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE),
            "MPI_Waitall");

  // Calls f(host, marker, whole, answer) for all answers.
  const auto for_answers = [&](auto&& f) {
    for (const Route& route : routes_) {
      Host& host = hosts_[route.host];
      if (!takes_part(host.id, round)) continue;
      const double* answer = route.buffer.data();
      if (route.rank == comm_.rank()) {
        answer = std::find_if(guests_.begin(), guests_.end(), [&](const Guest& guest) {
                   return guest.id == host.id;
                 })->buffer.data();
      }
      for (std::size_t n = 0; n < route.markers.size(); ++n) {
        const bool whole = route.whole[n] != 0;
        f(host, static_cast<std::size_t>(route.markers[n]), whole, answer);
        answer += whole ? 3 : 12;
      }
    }
  };
  for_answers([](Host& host, std::size_t m, bool whole, const double* answer) {
    if (whole) {
      std::copy_n(answer, 3, &host.velocity[3 * m]);
    } else {
      std::fill_n(&host.partial[12 * m], 12, 0.0);
    }
  });
  for_answers([](Host& host, std::size_t m, bool whole, const double* answer) {
    for (std::size_t n = 0; !whole && n < 12; ++n) host.partial[12 * m + n] += answer[n];
  });
  for_answers([&sum](Host& host, std::size_t m, bool whole, const double* /*answer*/) {
    for (std::size_t axis = 0; !whole && axis < 3; ++axis)
      host.velocity[3 * m + axis] = sum(&host.partial[12 * m + 4 * axis]);
  });
  watch_.lap(Part::exchange);
}

// All ranks learn whether a body has left its box or failed. Throws BodyFailure on all of them.
void Coupler::Impl::agree() {
  constexpr int fine = 0;
  constexpr int moved_out = 1;
  constexpr int failed = 2;
  int state = failed_ != INT_MAX ? failed : (moved_out_ ? moved_out : fine);
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, &state, 1, MPI_INT, MPI_MAX, comm_.get()), "MPI_Allreduce");
  sent(sizeof state);
  watch_.lap(Part::waiting);
  moved_out_ = state == moved_out;
  if (state != failed) return;
  const int own = failed_;
  int body = own;
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, &body, 1, MPI_INT, MPI_MIN, comm_.get()), "MPI_Allreduce");
  const int root = entries_[static_cast<std::size_t>(body)].owner;
  std::array<int, 2> header = {static_cast<int>(reason_.size()), failed_marker_};
  mpi_check(MPI_Bcast(header.data(), 2, MPI_INT, root, comm_.get()), "MPI_Bcast");
  const auto [length, marker] = header;
  reason_.resize(static_cast<std::size_t>(length));
  mpi_check(MPI_Bcast(reason_.data(), length, MPI_CHAR, root, comm_.get()), "MPI_Bcast");
  failed_ = INT_MAX;
  moved_out_ = true;
  const std::optional<std::size_t> at_fault =
      marker == no_marker ? std::nullopt
                          : std::optional<std::size_t>(static_cast<std::size_t>(marker));
  throw BodyFailure(body, at_fault, time_, reason_);
}

Coupler::Coupler(fluid::Fluid& fluid, std::vector<Member> bodies, int total)
    : impl_(std::make_unique<Impl>(fluid, std::move(bodies), total)) {}
Coupler::~Coupler() = default;
void Coupler::step() {
  impl_->step();
}
const Profile& Coupler::profile() const {
  return impl_->watch_.profile;
}
void Coupler::reset_profile() {
  impl_->watch_.profile = {};
}

}  // namespace ductile::coupling
