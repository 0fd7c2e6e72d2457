// The populations and their evolution.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "ductile/fluid/d3q19.hpp"
#include "fluid_impl.hpp"
#include "halo.hpp"
#include "kernel.hpp"
#include "slab.hpp"

namespace ductile::fluid {
namespace {

using d3q19::opposite;
using d3q19::Q;

// An odd step fetches five populations a row across the end of a slab: from the column at -shift,
// the one along (shift, +1) from below or (shift, -1) from above. The f* that the odd step
// writes in their places go back the same way.
constexpr std::array<std::array<int, 2>, 5> shifts = {{{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

constexpr int index_of(const std::array<int, 3>& velocity) {
  int i = 0;
  while (d3q19::c(i) != velocity) ++i;
  return i;
}
// Index of the velocity (shift, +1) for side 0, (shift, -1) for side 1.
constexpr std::array<std::array<int, 5>, 2> entering = [] {
  std::array<std::array<int, 5>, 2> index{};
  for (std::size_t side = 0; side < 2; ++side) {
    for (std::size_t s = 0; s < 5; ++s) {
      index[side][s] = index_of({shifts[s][0], shifts[s][1], side == 0 ? 1 : -1});
    }
  }
  return index;
}();

// The place of f_i, i > 0.
template <class Real>
Real* place_of(const Row<Real>& row, int i) {
  return i % 2 == 1 ? row.plus[(i - 1) / 2] : row.minus[(i - 1) / 2];
}

// "f00" to "f18".
std::string name_of(int i) {
  return (i < 10 ? "f0" : "f") + std::to_string(i);
}

template <class Real, class T>
class Populations final : public FluidImpl {
 public:
  Populations(Communicator comm, const Options& options)
      : FluidImpl(std::move(comm), options),
        nx_(options.nodes[0]),
        ny_(options.nodes[1]),
        slab_of_(options, slab_.size()),
        kernel_(kernel<Real, T>(*options.instruction_set, compressible())),
        halo_(comm_, peers(), number_slots()) {}

  void initialise(const std::function<NodeState(int, int, int)>& state) override;
  void read_velocity() override;
  void step() override;
  void stream() override;
  void fields(std::span<double> density, std::span<double> velocity) override;
  void save(const StateWriter& write) override;
  void load(const StateReader& read) override;
  std::vector<double> plane_sums() override;
  std::vector<double> plane_flows() override;
  bool finite() override;
  [[nodiscard]] std::size_t memory() const override;
  [[nodiscard]] std::int64_t bytes_sent() const override { return halo_.bytes_sent(); }

 private:
  void walls_moved() override { slab_of_.set_walls(options_, wall_velocity_); }
  [[nodiscard]] std::array<int, 2> peers() const;
  std::vector<std::size_t> number_slots();
  // The end of the slab on that side.
  [[nodiscard]] int end_plane(int side) const { return side == 0 ? 0 : slab_of_.planes() - 1; }
  // Calls visit(place, slot) for each population that the row exchanges with that side.
  template <class Visit>
  void for_crossing(const Row<Real>& row, int x, int y, int side, Visit&& visit);
  void arrive(const Row<Real>& row, int x, int y);
  void depart(const Row<Real>& row, int x, int y);
  void fetch_ends(int x, int y);
  [[nodiscard]] RowForce<T> uniform_force() const;
  void collide_row(const Row<Real>& row, int x, int y);
  // The row's populations complete, as of now.
  Row<Real> complete_row(int x, int y);
  void read_row(int x, int y, double* density, const std::array<double*, 3>& velocity);
  void drive_moving_walls();
  void drive_wall(int x, int y, int begin, int end, std::size_t axis, int side);

  int nx_;
  int ny_;
  Slab<Real> slab_of_;
  const Kernel<Real, T>& kernel_;
  // The slots of a column's five shifts in an even and in an odd step, -1 for none. In an odd step
  // they are its own; the row at +shift fetches what the even step leaves.
  std::array<std::vector<std::array<int, 5>>, 2> slots_;
  std::vector<int> part_ends_;  // in x, of the parts that the halo is cut into
  Halo<Real> halo_;
};

template <class Real, class T>
std::array<int, 2> Populations<Real, T>::peers() const {
  std::array<int, 2> peers = {comm_.rank() - 1, comm_.rank() + 1};
  for (int& peer : peers) {
    if (options_.boundary[2] == Boundary::periodic) peer = (peer + comm_.size()) % comm_.size();
    if (peer < 0 || peer >= comm_.size()) peer = MPI_PROC_NULL;
  }
  return peers;
}

template <class Real, class T>
std::vector<std::size_t> Populations<Real, T>::number_slots() {
  constexpr int most_parts = 8;
  const int parts = std::min(most_parts, nx_);
  for (auto& slots : slots_) {
    slots.assign(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_),
                 {-1, -1, -1, -1, -1});
  }
  std::vector<std::size_t> ends;
  int count = 0;
  for (int part = 0, x = 0; part < parts; ++part) {
    part_ends_.push_back(nx_ * (part + 1) / parts);
    for (; x < part_ends_.back(); ++x) {
      for (int y = 0; y < ny_; ++y) {
        for (std::size_t s = 0; s < shifts.size(); ++s) {
          int i = entering[0][s];
          int from_x = x;
          int from_y = y;
          if (!slab_of_.trace(i, from_x, from_y)) continue;
          const auto there = std::find(entering[0].begin(), entering[0].end(), i);
          slots_[1][column(x, y)][s] = count;
          slots_[0][column(from_x, from_y)][static_cast<std::size_t>(there - entering[0].begin())] =
              count;
          ++count;
        }
      }
    }
    ends.push_back(static_cast<std::size_t>(count));
  }
  return ends;
}

template <class Real, class T>
template <class Visit>
void Populations<Real, T>::for_crossing(const Row<Real>& row, int x, int y, int side,
                                        Visit&& visit) {
  const auto& slots = slots_[odd() ? 1 : 0][column(x, y)];
  const int end = end_plane(side);
  for (std::size_t s = 0; s < shifts.size(); ++s) {
    if (slots[s] < 0) continue;
    // An odd step reads the entering population here. In an even step the place is that which the
    // neighbour's odd step reads, array opposite(i) for its entering population i.
    const int i = odd() ? entering[static_cast<std::size_t>(side)][s]
                        : opposite(entering[static_cast<std::size_t>(1 - side)][s]);
    visit(place_of(row, i) + end, slots[s], i);
  }
}

// Puts what came from the slabs below and above in its place. A half-way wall across z reflects
// the node's own populations instead.
template <class Real, class T>
void Populations<Real, T>::arrive(const Row<Real>& row, int x, int y) {
  for (int side = 0; side < 2; ++side) {
    if (const Real* arrivals = halo_.arrivals(side)) {
      for_crossing(row, x, y, side, [&](Real* place, int slot, int) { *place = arrivals[slot]; });
    } else if (!halo_.exists(side) && odd()) {
      for_crossing(row, x, y, side, [&](Real* place, int, int i) {
        *place = slab_of_.at(i, x, y)[end_plane(side)];
      });
    }
  }
}

// Between two steps the sweep has driven all that is exchanged out of the cache, and nothing but
// this tells the processor where a row will look for it next.
template <class Real, class T>
void Populations<Real, T>::fetch_ends(int x, int y) {
  const Row<Real> row = slab_of_.row(x, y, odd());
  const auto& slots = slots_[odd() ? 1 : 0];
  const std::size_t later = std::min(column(x, y) + 8, slots.size() - 1);
  __builtin_prefetch(&slots[later]);
  for (int side = 0; side < 2; ++side) {
    const Real* arrivals = halo_.arrivals(side);
    Real* departures = halo_.exists(side) ? halo_.departures(side) : nullptr;
    for_crossing(row, x, y, side, [&](Real* place, int slot, int) {
      __builtin_prefetch(place, 1);
      if (arrivals != nullptr) __builtin_prefetch(arrivals + slot);
      if (departures != nullptr) __builtin_prefetch(departures + slot, 1);
    });
  }
}

template <class Real, class T>
void Populations<Real, T>::depart(const Row<Real>& row, int x, int y) {
  for (int side = 0; side < 2; ++side) {
    if (halo_.exists(side)) {
      Real* departures = halo_.departures(side);
      for_crossing(row, x, y, side, [&](Real* place, int slot, int) { departures[slot] = *place; });
    } else if (odd()) {
      for_crossing(row, x, y, side, [&](Real* place, int, int i) {
        slab_of_.at(i, x, y)[end_plane(side)] = *place;
      });
    }
  }
}

template <class Real, class T>
RowForce<T> Populations<Real, T>::uniform_force() const {
  return {
      {force_[0], force_[1], force_[2]}, {nullptr, nullptr, nullptr}, {nullptr, nullptr, nullptr}};
}

// The forces of patches that meet the row act and are used up, and the velocity is left there.
template <class Real, class T>
void Populations<Real, T>::collide_row(const Row<Real>& row, int x, int y) {
  const RowForce<T> uniform = uniform_force();
  if (const RowWall* wall = slab_of_.wall(x, y)) {
    kernel_.collide_wall(row, 0, slab_of_.planes(), relaxation_, uniform, *wall);
    return;
  }
  int done = 0;
  if (!first_met_.empty()) {
    for (std::size_t m = first_met_[column(x, y)]; m < first_met_[column(x, y) + 1]; ++m) {
      Patch& patch = patches_[met_[m]];
      const int begin = patch.begin[2] - slab_.begin;
      const std::ptrdiff_t first = patch.at(x - patch.begin[0], y - patch.begin[1], 0);
      kernel_.collide(row, done, begin, relaxation_, uniform);
      done = begin + patch.size[2];
      auto& local = std::get<LocalFields<T>>(patch.local);
      RowForce<T> force = uniform;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        force.local[axis] = local.force[axis].data() + first - begin;
        force.velocity[axis] = local.velocity[axis].data() + first - begin;
      }
      kernel_.collide(row, begin, done, relaxation_, force);
      for (auto& of_axis : local.force) {
        std::fill_n(of_axis.data() + first - Patch::pad, patch.pitch, T{0});
      }
    }
  }
  kernel_.collide(row, done, slab_of_.planes(), relaxation_, uniform);
}

// What arrives for a row is needed from the rows next to it in x, and what departs is complete with
// them. The row's own ends are laid one row ahead, and fetched into the cache two rows ahead.
template <class Real, class T>
void Populations<Real, T>::step() {
  fold_force();
  double_force_on_plane();
  halo_.begin_step();
  const bool around = options_.boundary[0] == Boundary::periodic;
  const int parts = halo_.parts();
  if (around) halo_.await_all();
  int awaited = 0;
  int sent = around ? 1 : 0;
  for (int x = 0; x < nx_; ++x) {
    for (; awaited < parts &&
           (awaited == 0 || part_ends_[static_cast<std::size_t>(awaited - 1)] <= x + 2);
         ++awaited) {
      halo_.await(awaited);
    }
    if (x == 0) arrive(slab_of_.row(0, 0, odd()), 0, 0);
    for (int y = 0; y < ny_; ++y) {
      const int n = x * ny_ + y;
      if (n + 2 < nx_ * ny_) fetch_ends((n + 2) / ny_, (n + 2) % ny_);
      if (n + 1 < nx_ * ny_) complete_row((n + 1) / ny_, (n + 1) % ny_);
      const Row<Real> row = slab_of_.row(x, y, odd());
      collide_row(row, x, y);
      depart(row, x, y);
    }
    for (; sent < parts && part_ends_[static_cast<std::size_t>(sent)] <= x; ++sent)
      halo_.send(sent);
    halo_.progress();
  }
  for (; sent < parts; ++sent) halo_.send(sent);
  if (around) halo_.send(0);
  drive_moving_walls();
  for (Patch& patch : patches_) fill_image_of_velocity(patch);
  halo_.end_step();
  move_lattice();
  ++time_;
  odd_ = !odd_;
}

template <class Real, class T>
void Populations<Real, T>::stream() {
  for (int x = 0; x < nx_; ++x) {
    for (int y = 0; y < ny_; ++y) {
      kernel_.stream(slab_of_.row(x, y, odd()), 0, slab_of_.planes());
    }
  }
  ++time_;
  odd_ = !odd_;
}

// Half-way bounce-back off a wall that moves with u_w: f_(-i) = f_i* - 6 w_i rho0 c_i.u_w, added
// where the reflected population waits, which is its own array in both states. None of these
// crosses the ends of the slab.
template <class Real, class T>
void Populations<Real, T>::drive_wall(int x, int y, int begin, int end, std::size_t axis,
                                      int side) {
  const Eigen::Vector3d& u = wall_velocity_[axis][static_cast<std::size_t>(side)];
  const int inward = side == 0 ? 1 : -1;
  for (int i = 1; i < Q; ++i) {
    const auto v = d3q19::c(i);
    if (v[axis] != inward) continue;
    // A link that crosses walls of two axes belongs to the first axis.
    const std::array<int, 3> origin = {x - v[0], y - v[1], 0};
    bool mine = true;
    for (std::size_t first = 0; first < axis; ++first) {
      const bool through_mirror =
          first == 1 && options_.mirror != Mirror::none && origin[first] < 0;
      const bool outside =
          !through_mirror && (origin[first] < 0 || origin[first] >= options_.nodes[first]);
      if (outside && options_.boundary[first] == Boundary::halfway) mine = false;
    }
    if (!mine) continue;
    const double add = 6 * d3q19::w(i) * (v[0] * u[0] + v[1] * u[1] + v[2] * u[2]);
    Real* f = slab_of_.at(i, x, y);
    for (int k = begin; k < end; ++k) f[k] = static_cast<Real>(static_cast<double>(f[k]) + add);
  }
}

template <class Real, class T>
void Populations<Real, T>::drive_moving_walls() {
  const int planes = slab_of_.planes();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (options_.boundary[axis] != Boundary::halfway) continue;
    for (int side = 0; side < 2; ++side) {
      if (wall_velocity_[axis][static_cast<std::size_t>(side)].isZero(0)) continue;
      const int at_wall = side == 0 ? 0 : options_.nodes[axis] - 1;
      if (axis == 0) {
        for (int y = 0; y < ny_; ++y) drive_wall(at_wall, y, 0, planes, axis, side);
      } else if (axis == 1) {
        for (int x = 0; x < nx_; ++x) drive_wall(x, at_wall, 0, planes, axis, side);
      } else if (at_wall >= slab_.begin && at_wall < slab_.end) {
        const int k = at_wall - slab_.begin;
        for (int x = 0; x < nx_; ++x) {
          for (int y = 0; y < ny_; ++y) drive_wall(x, y, k, k + 1, axis, side);
        }
      }
    }
  }
}

template <class Real, class T>
void Populations<Real, T>::initialise(const std::function<NodeState(int, int, int)>& state) {
  halo_.reset();
  drop_force();
  time_ = 0;
  odd_ = false;
  reset_motion();
  const Eigen::Vector3d& force = force_;
  for (int x = 0; x < nx_; ++x) {
    for (int y = 0; y < ny_; ++y) {
      for (int k = 0; k < slab_of_.planes(); ++k) {
        const NodeState s = state(x, y, slab_.begin + k);
        const Eigen::Vector3d& u = s.velocity;
        const double uu = u.squaredNorm();
        const double rho = weighing(s.density);
        for (int i = 0; i < Q; ++i) {
          const auto v = d3q19::c(i);
          const Eigen::Vector3d e(v[0], v[1], v[2]);
          const double cu = e.dot(u);
          const double equilibrium = (s.density - 1) + rho * (3 * cu + 4.5 * cu * cu - 1.5 * uu);
          const double stress =
              -3 * rho / relaxation_.omega_plus * (e.dot(s.gradient * e) - s.gradient.trace() / 3);
          const double forcing = -0.5 * (3 * (e - u).dot(force) + 9 * cu * e.dot(force));
          slab_of_.at(i, x, y)[k] =
              static_cast<Real>(d3q19::w(i) * (equilibrium + stress + forcing));
        }
      }
    }
  }
}

template <class Real, class T>
Row<Real> Populations<Real, T>::complete_row(int x, int y) {
  const Row<Real> row = slab_of_.row(x, y, odd());
  arrive(row, x, y);
  return row;
}

template <class Real, class T>
void Populations<Real, T>::read_velocity() {
  halo_.await_all();
  const RowForce<T> uniform = uniform_force();
  for (Patch& patch : patches_) {
    auto& local = std::get<LocalFields<T>>(patch.local);
    make_moments(local);
    const int begin = patch.begin[2] - slab_.begin;
    for (int i = 0; i < patch.size[0]; ++i) {
      for (int j = std::max(0, -patch.begin[1]); j < patch.size[1]; ++j) {
        const std::ptrdiff_t first = patch.at(i, j, 0) - begin;
        T* density = local.density.empty() ? nullptr : local.density.data() + first;
        kernel_.momentum(complete_row(patch.begin[0] + i, patch.begin[1] + j), begin,
                         begin + patch.size[2], uniform, density, local.momentum[0].data() + first,
                         local.momentum[1].data() + first, local.momentum[2].data() + first);
      }
    }
  }
}

// Density and velocity of one row, to four arrays over its planes.
template <class Real, class T>
void Populations<Real, T>::read_row(int x, int y, double* density,
                                    const std::array<double*, 3>& velocity) {
  const int planes = slab_of_.planes();
  const Row<Real> row = complete_row(x, y);
  if (const RowWall* wall = slab_of_.wall(x, y)) {
    kernel_.wall_density(row, 0, planes, force_.data(), *wall, density);
    for (int k = 0; k < planes; ++k) density[k] += 1;
    for (std::size_t a = 0; a < 3; ++a) std::fill_n(velocity[a], planes, wall->velocity[a]);
    return;
  }
  kernel_.moments(row, 0, planes, density, velocity[0], velocity[1], velocity[2]);
  for (int k = 0; k < planes; ++k) {
    density[k] += 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double half_force = 0.5 * force_[static_cast<Eigen::Index>(axis)];
      velocity[axis][k] = (velocity[axis][k] + half_force) / weighing(density[k]);
    }
  }
}

template <class Real, class T>
void Populations<Real, T>::fields(std::span<double> density, std::span<double> velocity) {
  halo_.await_all();
  const auto planes = static_cast<std::size_t>(slab_of_.planes());
  const std::size_t count = static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) * planes;
  if (density.size() != count || velocity.size() != 3 * count) {
    reject("fields need " + std::to_string(count) +
           " densities and three times as many velocities");
  }
  std::size_t first = 0;
  for (int x = 0; x < nx_; ++x) {
    for (int y = 0; y < ny_; ++y, first += planes) {
      read_row(x, y, &density[first],
               {&velocity[first], &velocity[count + first], &velocity[2 * count + first]});
    }
  }
}

template <class Real, class T>
std::vector<double> Populations<Real, T>::plane_sums() {
  halo_.await_all();
  const auto planes = static_cast<std::size_t>(slab_of_.planes());
  std::vector<double> row(4 * planes);
  std::vector<double> sums(4 * planes, 0.0);
  for (int x = 0; x < nx_; ++x) {
    for (int y = 0; y < ny_; ++y) {
      read_row(x, y, row.data(), {&row[planes], &row[2 * planes], &row[3 * planes]});
      const double share = slab_of_.share(x, y);
      for (std::size_t k = 0; k < planes; ++k) {
        sums[4 * k] += share * (row[k] - 1);
        for (std::size_t axis = 1; axis < 4; ++axis) {
          sums[4 * k + axis] += share * (weighing(row[k]) * row[axis * planes + k]);
        }
      }
    }
  }
  return sums;
}

template <class Real, class T>
std::vector<double> Populations<Real, T>::plane_flows() {
  halo_.await_all();
  const int planes = slab_of_.planes();
  std::vector<double> sums(static_cast<std::size_t>(planes), 0.0);
  for (int x = 0; x < nx_; ++x) {
    for (int y = 0; y < ny_; ++y) {
      const double share = slab_of_.share(x, y);
      if (const RowWall* wall = slab_of_.wall(x, y)) {
        for (double& sum : sums) sum += share * wall->velocity[2];
        continue;
      }
      kernel_.add_flow(complete_row(x, y), 0, planes, 0.5 * force_.z(), share, sums.data());
    }
  }
  return sums;
}

// Along z every node is looked at, across it one column in 64.
template <class Real, class T>
bool Populations<Real, T>::finite() {
  halo_.await_all();
  constexpr int stride = 8;
  const auto planes = static_cast<std::size_t>(slab_of_.planes());
  std::vector<double> row(4 * planes);
  double sum = 0;
  for (int x = stride / 2 % nx_; x < nx_; x += stride) {
    for (int y = stride / 2 % ny_; y < ny_; y += stride) {
      read_row(x, y, row.data(), {&row[planes], &row[2 * planes], &row[3 * planes]});
      sum = std::accumulate(row.begin(), row.end(), sum);
    }
  }
  return std::isfinite(sum);
}

template <class Real, class T>
void Populations<Real, T>::save(const StateWriter& write) {
  halo_.await_all();
  const auto time = static_cast<double>(time_);
  write("time", std::span(&time, 1));
  const std::array motion = {motion_.position, motion_.velocity, motion_.acceleration};
  write("lattice", motion);
  for (int x = 0; x < nx_; ++x) {
    for (int y = 0; y < ny_; ++y) complete_row(x, y);
  }
  const auto planes = static_cast<std::size_t>(slab_of_.planes());
  std::vector<double> staged(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) *
                             planes);
  for (int i = 0; i < Q; ++i) {
    double* to = staged.data();
    for (int x = 0; x < nx_; ++x) {
      for (int y = 0; y < ny_; ++y) {
        const Row<Real> row = slab_of_.row(x, y, odd());
        to = std::copy_n(i == 0 ? row.rest : place_of(row, i), planes, to);
      }
    }
    write(name_of(i), staged);
  }
}

// Every node gets its own populations, so nothing is to arrive before the next step.
template <class Real, class T>
void Populations<Real, T>::load(const StateReader& read) {
  halo_.reset();
  drop_force();
  double time = 0;
  read("time", std::span(&time, 1));
  time_ = static_cast<std::int64_t>(time);
  odd_ = false;
  std::array<double, 3> motion{};
  read("lattice", motion);
  set_motion({motion[0], motion[1], motion[2]});
  const auto planes = static_cast<std::size_t>(slab_of_.planes());
  std::vector<double> staged(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) *
                             planes);
  for (int i = 0; i < Q; ++i) {
    read(name_of(i), staged);
    const double* from = staged.data();
    for (int x = 0; x < nx_; ++x) {
      for (int y = 0; y < ny_; ++y, from += planes) {
        std::transform(from, from + planes, slab_of_.at(i, x, y),
                       [](double f) { return static_cast<Real>(f); });
      }
    }
  }
}

template <class Real, class T>
std::size_t Populations<Real, T>::memory() const {
  std::size_t bytes = slab_of_.bytes() + halo_.memory();
  for (const auto& slots : slots_) bytes += slots.size() * sizeof slots[0];
  bytes += (first_met_.size() + met_.size()) * sizeof(std::size_t);
  for (const Patch& patch : patches_) {
    const auto& local = std::get<LocalFields<T>>(patch.local);
    bytes += sizeof(T) *
             (6 * local.force[0].size() + 3 * local.momentum[0].size() + local.density.size());
  }
  return bytes;
}

}  // namespace

std::unique_ptr<FluidImpl> make_populations(Communicator comm, const Options& options) {
  if (options.storage == Precision::double_precision)
    return std::make_unique<Populations<double, double>>(std::move(comm), options);
  if (options.arithmetic == Precision::double_precision)
    return std::make_unique<Populations<float, double>>(std::move(comm), options);
  return std::make_unique<Populations<float, float>>(std::move(comm), options);
}

}  // namespace ductile::fluid
