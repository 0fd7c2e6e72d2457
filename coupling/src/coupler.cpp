#include "ductile/coupling/coupler.hpp"

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <utility>

#include "ductile/fluid/delta.hpp"
#include "ductile/fluid/mpi.hpp"
#include "failures.hpp"
#include "markers.hpp"
#include "response.hpp"
#include "stopwatch.hpp"

namespace ductile::coupling {

using fluid::mpi_check;

class Coupler::Impl {
 public:
  Impl(fluid::Fluid& fluid, std::vector<Member> members, int total);

  void step();
  Stopwatch watch_;
  bool moved_out_ = true;  // a body may not be in its box

 private:
  void lay_out();
  void predict_forces();
  void correct_forces(Round round);
  void advance();
  void place(Host& host) const;
  void at_rest(std::span<double> velocity) const;
  void agree();

  std::optional<fluid::Box> reach_of(const Host& host);
  bool fits(const Host& host, const fluid::Box& reach);
  // Whether a box has all planes of a periodic axis, to whose ends nothing moves out.
  [[nodiscard]] bool is_whole_ring(const fluid::Box& box, std::size_t axis) const {
    return axis == 2 && fluid_.options().boundary[2] == fluid::Boundary::periodic &&
           box[2].size() == fluid_.options().nodes[2];
  }
  template <class F>
  void guarded(Host& host, const F& f);
  void sent(std::size_t bytes) {
    if (comm_.size() > 1) watch_.profile.bytes_sent += static_cast<std::int64_t>(bytes);
  }

  fluid::Fluid& fluid_;
  fluid::Communicator comm_;
  std::vector<Host> hosts_;
  std::vector<Entry> entries_;
  Markers markers_;
  Failures failures_;
  int rounds_ = 0;               // of corrections
  std::int64_t time_ = 0;        // at the start of the step
  double lattice_velocity_ = 0;  // then
  double way_ = 0;               // of the lattice, where markers were last placed on it
};

Coupler::Impl::Impl(fluid::Fluid& fluid, std::vector<Member> members, int total)
    : fluid_(fluid), comm_(fluid.comm()), markers_(fluid, comm_, hosts_, watch_) {
  std::sort(members.begin(), members.end(),
            [](const Member& a, const Member& b) { return a.id < b.id; });
  // Of each id, and after them of ids out of range and of bodies that are none.
  std::vector<int> owners(static_cast<std::size_t>(std::max(total, 0)) + 2, 0);
  for (const Member& member : members) {
    ++owners[static_cast<std::size_t>(member.id >= 0 && member.id < total ? member.id
                                                                          : std::max(total, 0))];
    if (member.body == nullptr || member.body->marker_count() == 0) {
      ++owners.back();
      continue;
    }
    Host host;
    host.id = member.id;
    host.body = member.body;
    host.corrections = member.body->corrections();
    host.response = MarkerResponse(fluid.options().mirror, *fluid.options().instruction_set);
    const std::size_t size = 3 * member.body->marker_count();
    host.position.resize(size);
    host.force.resize(size);
    host.velocity.resize(size);
    host.partial.resize(4 * size);
    hosts_.push_back(std::move(host));
  }
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, owners.data(), static_cast<int>(owners.size()), MPI_INT,
                          MPI_SUM, comm_.get()),
            "MPI_Allreduce");
  const int empty = owners.back();
  owners.pop_back();
  const int strangers = owners.back();
  owners.pop_back();
  if (strangers != 0 || !std::all_of(owners.begin(), owners.end(), [](int n) { return n == 1; })) {
    throw std::invalid_argument("coupler: the ranks' bodies must have the ids 0 to " +
                                std::to_string(total - 1) + ", each once");
  }
  if (empty != 0) throw std::invalid_argument("coupler: every body must have markers");
  entries_.resize(owners.size());
}

// The time step. Bodies and fluid exchange marker velocities and forces; eq. numbers as the paper.
void Coupler::Impl::step() {
  watch_.start();
  time_ = fluid_.time();
  lattice_velocity_ = fluid_.motion().velocity;
  // The fluid has been set to another state, with its lattice elsewhere.
  if (fluid_.motion().position != way_) moved_out_ = true;
  if (moved_out_) lay_out();
  predict_forces();
  markers_.send_positions();
  markers_.spread(Round::everybody());      // eq. (16)
  if (rounds_ > 0) fluid_.read_velocity();  // u0: eqs. (5) and (6) with the uniform force
  watch_.lap(Part::boxes);
  for (int n = 0; n < rounds_; ++n) {
    const Round round = Round::correction(n);
    fluid_.update_velocity();
    watch_.lap(Part::boxes);
    markers_.interpolate(round);
    correct_forces(round);
    markers_.send_forces(round);
    markers_.spread(round);
  }
  const std::int64_t sent_before = fluid_.bytes_sent();
  fluid_.step();  // eqs. (2)-(4); the velocity at the step's start, half of the force in, is left
  watch_.profile.bytes_sent += fluid_.bytes_sent() - sent_before;
  watch_.lap(Part::fluid);
  markers_.interpolate(Round::everybody());  // eq. (15)
  advance();
  agree();
  ++watch_.profile.steps;
}

// Runs f, which calls the host's body; a failure ends the step when all ranks agree on it.
template <class F>
void Coupler::Impl::guarded(Host& host, const F& f) {
  if (failures_.precede(host.id)) return;
  try {
    f(*host.body);
  } catch (const MarkerError& error) {
    failures_.add(host.id, BodyFailure::Cause::body, error.marker(), error.what());
  } catch (const std::exception& error) {
    failures_.add(host.id, BodyFailure::Cause::body, std::nullopt, error.what());
  } catch (...) {
    failures_.add(host.id, BodyFailure::Cause::body, std::nullopt, "it throws no std::exception");
  }
}

void Coupler::Impl::predict_forces() {
  for (Host& host : hosts_) {
    host.located = false;
    std::fill(host.force.begin(), host.force.end(), 0.0);
    guarded(host, [&](Body& body) { body.predict_force(host.force); });
  }
  watch_.lap(Part::bodies);
}

void Coupler::Impl::correct_forces(Round round) {
  for (Host& host : hosts_) {
    if (!round.includes(host.corrections)) continue;
    std::fill(host.force.begin(), host.force.end(), 0.0);
    guarded(host, [&](Body& body) {
      // Located on the first call: only a body that solves asks for it.
      class Lazy final : public Response {
       public:
        explicit Lazy(Host& host) : host_(host) {}
        void apply(std::span<const double> force, std::span<double> velocity) const override {
          if (!host_.located) host_.response.locate(host_.position, host_.share);
          host_.located = true;
          host_.response.apply(force, velocity);
        }

       private:
        Host& host_;
      };
      at_rest(host.velocity);
      body.correct_force(host.velocity, Lazy(host), host.force);
    });
  }
  watch_.lap(Part::bodies);
}

void Coupler::Impl::advance() {
  way_ = fluid_.motion().position;
  for (Host& host : hosts_) {
    guarded(host, [&](Body& body) {
      at_rest(host.velocity);
      body.advance(host.velocity);
      place(host);
      const auto reach = reach_of(host);
      const fluid::Box& laid = entries_[static_cast<std::size_t>(host.id)].box;
      for (std::size_t axis = 0; axis < 3 && reach; ++axis) {
        if (is_whole_ring(laid, axis) && reach->at(axis).size() <= laid[axis].size()) continue;
        moved_out_ = moved_out_ || (*reach)[axis].begin < laid[axis].begin ||
                     (*reach)[axis].end > laid[axis].end;
      }
    });
  }
  watch_.lap(Part::bodies);
}

namespace {

// y of a mirror plane.
double plane_of(fluid::Mirror mirror) {
  return mirror == fluid::Mirror::on_node ? 0 : -0.5;
}

// Whether the plane has markers of the body on both sides or all in it.
bool is_own_image(fluid::Mirror mirror, std::span<const double> positions) {
  const double plane = plane_of(mirror);
  bool above = false;
  bool below = false;
  for (std::size_t n = 1; n < positions.size(); n += 3) {
    above = above || positions[n] > plane;
    below = below || positions[n] < plane;
  }
  return above == below;
}

}  // namespace

// Where the host's markers are on the lattice now, and what follows from it.
void Coupler::Impl::place(Host& host) const {
  const std::span<const double> x = host.body->positions();
  if (x.size() != host.position.size()) {
    throw std::logic_error("it has " + std::to_string(x.size() / 3) + " markers now, and had " +
                           std::to_string(host.position.size() / 3));
  }
  std::copy(x.begin(), x.end(), host.position.begin());
  for (std::size_t n = 2; n < x.size(); n += 3) host.position[n] -= way_;
  const fluid::Mirror mirror = fluid_.options().mirror;
  host.share = mirror != fluid::Mirror::none && is_own_image(mirror, host.position) ? 0.5 : 1;
}

// Velocities on the lattice -> those in the frame at rest.
void Coupler::Impl::at_rest(std::span<double> velocity) const {
  for (std::size_t n = 2; n < velocity.size(); n += 3) velocity[n] += lattice_velocity_;
}

// The nodes that the host's markers reach; nothing and a failure if one is not finite.
std::optional<fluid::Box> Coupler::Impl::reach_of(const Host& host) {
  const std::span<const double> x = host.position;
  std::array<double, 3> low{INFINITY, INFINITY, INFINITY};
  std::array<double, 3> high{-INFINITY, -INFINITY, -INFINITY};
  for (std::size_t n = 0; n < x.size(); n += 3) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!(std::abs(x[n + axis]) < 1e9)) {
        failures_.add(host.id, BodyFailure::Cause::body, n / 3,
                      "the position of marker " + std::to_string(n / 3) + " is not finite");
        return std::nullopt;
      }
      low[axis] = std::min(low[axis], x[n + axis]);
      high[axis] = std::max(high[axis], x[n + axis]);
    }
  }
  fluid::Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box[axis] = {fluid::first_node(low[axis]), fluid::first_node(high[axis]) + 4};
  }
  return box;
}

namespace {

// The host's marker of lowest or highest coordinate.
std::size_t extreme_marker(const Host& host, std::size_t axis, bool lowest) {
  const std::span<const double> x = host.position;
  std::size_t found = 0;
  for (std::size_t m = 1; m < x.size() / 3; ++m) {
    const double here = x[3 * m + axis];
    const double best = x[3 * found + axis];
    if (lowest ? here < best : here > best) found = m;
  }
  return found;
}

// A marker at `x` whose kernel leaves the fluid at one end of an axis.
std::string too_close(const fluid::Options& options, std::size_t axis, bool low, std::size_t marker,
                      double x) {
  // Half-way walls lie half a spacing outside of the outermost nodes, which the kernel may use;
  // regularized ones on them, and there it may not.
  const bool periodic = options.boundary[axis] == fluid::Boundary::periodic;
  const bool on_nodes = options.boundary[axis] == fluid::Boundary::regularized;
  const double outside = on_nodes ? 0 : 0.5;
  const double high_end = options.nodes[axis] - 1 + outside;
  // Beyond a mirror plane the low wall is the image of the high one.
  const bool mirrored = axis == 1 && options.mirror != fluid::Mirror::none;
  const double low_end = mirrored ? 2 * plane_of(options.mirror) - high_end : -outside;
  const double end = low ? low_end : high_end;
  std::ostringstream text;
  text << std::setprecision(3) << "marker " << marker << " is " << std::abs(x - end)
       << " lattice spacings from the " << (periodic ? "periodic side" : "wall") << " at the "
       << (low ? "low" : "high") << " end of "
       << "xyz"[axis] << ", under the " << (on_nodes ? 2 : 1.5) << " that the 4-point kernel needs";
  return text.str();
}

}  // namespace

// Whether the fluid has all nodes that the host's markers reach, each once; a failure if not.
bool Coupler::Impl::fits(const Host& host, const fluid::Box& reach) {
  const fluid::Options& options = fluid_.options();
  const fluid::Box domain = fluid_.domain();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (axis == 2 && options.boundary[axis] == fluid::Boundary::periodic) {
      if (reach[axis].size() <= options.nodes[axis]) continue;
      failures_.add(host.id, BodyFailure::Cause::boundary, std::nullopt,
                    "the body is longer than the periodic channel; use a longer channel");
      return false;
    }
    const bool too_low = reach[axis].begin < domain[axis].begin;
    if (!too_low && reach[axis].end <= domain[axis].end) continue;
    const std::size_t marker = extreme_marker(host, axis, too_low);
    failures_.add(host.id, BodyFailure::Cause::boundary, marker,
                  too_close(options, axis, too_low, marker, host.position[3 * marker + axis]));
    return false;
  }
  return true;
}

// Lays the boxes around the bodies, and finds out which ranks they touch.
void Coupler::Impl::lay_out() {
  constexpr std::size_t numbers = 9;
  std::vector<int> table(entries_.size() * numbers, INT_MIN);
  way_ = fluid_.motion().position;
  for (Host& host : hosts_) {
    fluid::Box box{};
    guarded(host, [&](Body& /*body*/) {
      place(host);
      const auto reach = reach_of(host);
      if (reach && fits(host, *reach)) box = fluid_.box_around(*reach);
    });
    int* row = &table[static_cast<std::size_t>(host.id) * numbers];
    row[0] = comm_.rank();
    row[1] = static_cast<int>(host.position.size() / 3);
    row[2] = host.corrections;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      row[3 + 2 * axis] = box[axis].begin;
      row[4 + 2 * axis] = box[axis].end;
    }
  }
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, table.data(), static_cast<int>(table.size()), MPI_INT,
                          MPI_MAX, comm_.get()),
            "MPI_Allreduce");
  sent(table.size() * sizeof(int));
  rounds_ = 0;
  for (std::size_t id = 0; id < entries_.size(); ++id) {
    const int* row = &table[id * numbers];
    Entry& entry = entries_[id];
    entry.owner = row[0];
    entry.markers = row[1];
    entry.corrections = row[2];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      entry.box[axis] = {row[3 + 2 * axis], row[4 + 2 * axis]};
    }
    rounds_ = std::max(rounds_, entry.corrections);
  }
  moved_out_ = false;
  watch_.lap(Part::boxes);
  agree();

  std::vector<fluid::Box> boxes;
  for (const Entry& entry : entries_) boxes.push_back(entry.box);
  fluid_.place_boxes(boxes);
  markers_.lay_routes(entries_);
  watch_.lap(Part::boxes);
}

// All ranks learn whether a body has left its box or failed. Throws BodyFailure on all of them.
void Coupler::Impl::agree() {
  constexpr int fine = 0;
  constexpr int moved_out = 1;
  constexpr int failed = 2;
  int state = failures_.any() ? failed : (moved_out_ ? moved_out : fine);
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, &state, 1, MPI_INT, MPI_MAX, comm_.get()), "MPI_Allreduce");
  sent(sizeof state);
  watch_.lap(Part::waiting);
  moved_out_ = state != fine;
  if (state == failed) failures_.raise(comm_, time_);
}

Coupler::Coupler(fluid::Fluid& fluid, std::vector<Member> bodies, int total)
    : impl_(std::make_unique<Impl>(fluid, std::move(bodies), total)) {}
Coupler::~Coupler() = default;
void Coupler::step() {
  impl_->step();
}
void Coupler::bodies_replaced() {
  impl_->moved_out_ = true;
}
const Profile& Coupler::profile() const {
  return impl_->watch_.profile;
}
void Coupler::reset_profile() {
  impl_->watch_.profile = {};
}

}  // namespace ductile::coupling
