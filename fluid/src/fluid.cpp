#include "ductile/fluid/fluid.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "ductile/fluid/d3q19.hpp"
#include "kernel.hpp"

namespace ductile::fluid {
namespace {

using d3q19::c;
using d3q19::opposite;
using d3q19::Q;

void check(int code, const char* call) {
  if (code != MPI_SUCCESS) throw std::runtime_error(std::string("MPI: ") + call + " failed");
}

[[noreturn]] void reject(const std::string& what) {
  throw std::invalid_argument("fluid: " + what);
}

void validate(const Options& options, int ranks) {
  if (!(options.tau > 0.5) || !std::isfinite(options.tau)) {
    reject("tau = " + std::to_string(options.tau) + " must exceed 1/2");
  }
  if (options.collision == Collision::trt && !(options.magic > 0)) {
    reject("magic = " + std::to_string(options.magic) + " must be positive");
  }
  if (options.boundary[2] == Boundary::regularized) {
    reject("walls on nodes are for x and y alone; bound z by half-way walls or make it periodic");
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool on_nodes = options.boundary[axis] == Boundary::regularized;
    const int least = on_nodes ? 4 : 2;
    const std::string name(1, "xyz"[axis]);
    if (options.nodes[axis] < least) {
      reject(std::to_string(options.nodes[axis]) + " nodes along " + name + ", at least " +
             std::to_string(least) + " are needed");
    }
    for (const Eigen::Vector3d& u : options.wall_velocity[axis]) {
      if (!u.allFinite() || u[static_cast<Eigen::Index>(axis)] != 0) {
        reject("the velocity of a wall across " + name + " must have no component along " + name);
      }
    }
  }
  if (options.nodes[2] < ranks) {
    reject(std::to_string(options.nodes[2]) + " planes cannot be shared by " +
           std::to_string(ranks) + " ranks; use fewer ranks");
  }
}

// Zero-initialised memory on huge pages where the system grants them, so that the twenty streams of
// a row do not exhaust the TLB.
template <class Real>
class HugePages {
 public:
  explicit HugePages(std::size_t count) : bytes_(count * sizeof(Real)) {
    constexpr std::size_t huge = std::size_t{2} << 20U;
    const std::size_t rounded = (bytes_ + huge - 1) / huge * huge;
    data_.reset(static_cast<Real*>(std::aligned_alloc(huge, rounded)));
    if (!data_) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
    madvise(data_.get(), rounded, MADV_HUGEPAGE);
#endif
    std::fill_n(data_.get(), count, Real{0});
  }
  [[nodiscard]] Real* data() {
    return data_.get();
  }
  [[nodiscard]] std::size_t bytes() const {
    return bytes_;
  }

 private:
  struct Free {
    void operator()(Real* p) const { std::free(p); }  // NOLINT: pairs with aligned_alloc
  };
  std::size_t bytes_;
  std::unique_ptr<Real, Free> data_;
};

Range share(int planes, int ranks, int rank) {
  const auto start = [&](int r) {
    return static_cast<int>(static_cast<std::int64_t>(planes) * r / ranks);
  };
  return {start(rank), start(rank + 1)};
}

}  // namespace

bool Totals::finite() const {
  return std::isfinite(mass) && momentum.allFinite();
}

// What does not depend on how populations are stored.
class FluidImpl {
 public:
  FluidImpl(MPI_Comm comm, const Options& options) : options_(options) {
    check(MPI_Comm_dup(comm, &comm_), "MPI_Comm_dup");
    MPI_Comm_rank(comm_, &rank_);
    MPI_Comm_size(comm_, &ranks_);
    slab_ = share(options.nodes[2], ranks_, rank_);
    relaxation_.omega_plus = 1 / options.tau;
    relaxation_.omega_minus = options.collision == Collision::bgk
                                  ? relaxation_.omega_plus
                                  : 1 / (0.5 + options.magic / (options.tau - 0.5));
  }
  virtual ~FluidImpl() { MPI_Comm_free(&comm_); }
  FluidImpl(const FluidImpl&) = delete;
  FluidImpl& operator=(const FluidImpl&) = delete;

  virtual void initialise(const std::function<NodeState(int, int, int)>& state) = 0;
  virtual void read_velocity() = 0;
  virtual void step() = 0;
  virtual void fields(std::span<double> density, std::span<double> velocity) = 0;
  // Of each own plane: the sums of rho - 1 and of rho u.
  virtual std::vector<double> plane_sums() = 0;
  [[nodiscard]] virtual std::size_t memory() const = 0;

  void place_boxes(std::span<const Box> boxes);
  Totals totals();

  [[nodiscard]] Box domain() const {
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int wall = options_.boundary[axis] == Boundary::regularized ? 1 : 0;
      box[axis] = {wall, options_.nodes[axis] - wall};
    }
    return box;
  }

  Options options_;
  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0;
  int ranks_ = 1;
  Range slab_;
  Relaxation relaxation_{};
  std::int64_t time_ = 0;
  std::vector<Patch> patches_;
};

void FluidImpl::place_boxes(std::span<const Box> boxes) {
  const Box allowed = domain();
  patches_.clear();
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    const Box& box = boxes[b];
    const int nz = options_.nodes[2];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool wraps = axis == 2 && options_.boundary[2] == Boundary::periodic;
      if (box[axis].size() < 1 || (wraps && box[axis].size() > nz) ||
          (!wraps &&
           (box[axis].begin < allowed[axis].begin || box[axis].end > allowed[axis].end))) {
        reject("box of nodes " + std::to_string(box[axis].begin) + " to " +
               std::to_string(box[axis].end) + " along " + std::string(1, "xyz"[axis]) +
               " is not inside the fluid");
      }
    }
    // Periodic images of the slab that the box may meet.
    const int first = static_cast<int>(std::floor(static_cast<double>(box[2].begin) / nz));
    for (int image = first; image * nz < box[2].end; ++image) {
      const int begin = std::max(box[2].begin, slab_.begin + image * nz);
      const int end = std::min(box[2].end, slab_.end + image * nz);
      if (begin >= end) continue;
      Patch patch;
      patch.box = static_cast<int>(b);
      patch.begin = {box[0].begin, box[1].begin, begin - image * nz};
      patch.size = {box[0].size(), box[1].size(), end - begin};
      patch.pitch = patch.size[2] + 2 * Patch::pad;
      const auto count = static_cast<std::size_t>(patch.size[0] * patch.size[1] * patch.pitch);
      patch.density.assign(count, 1.0);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        patch.momentum[axis].assign(count, 0.0);
        patch.force[axis].assign(count, 0.0);
        patch.velocity[axis].assign(count, 0.0);
      }
      patches_.push_back(std::move(patch));
    }
  }
}

Totals FluidImpl::totals() {
  const std::vector<double> own = plane_sums();
  // Planes are summed one by one in their order, whoever holds them.
  std::vector<int> counts;
  std::vector<int> offsets;
  for (int r = 0; r < ranks_; ++r) {
    const Range s = share(options_.nodes[2], ranks_, r);
    counts.push_back(4 * s.size());
    offsets.push_back(4 * s.begin);
  }
  std::vector<double> all(4 * static_cast<std::size_t>(options_.nodes[2]));
  check(MPI_Allgatherv(own.data(), static_cast<int>(own.size()), MPI_DOUBLE, all.data(),
                       counts.data(), offsets.data(), MPI_DOUBLE, comm_),
        "MPI_Allgatherv");
  Totals totals;
  for (std::size_t p = 0; p < all.size(); p += 4) {
    totals.mass += all[p];
    totals.momentum += Eigen::Vector3d(all[p + 1], all[p + 2], all[p + 3]);
  }
  return totals;
}

namespace {

// The populations, in one of the two states of the AA pattern. Before an even step f_i of node x is
// in array i at x. The even step leaves the collided f_i* in array opposite(i) at x; the odd step
// fetches f_i(x) from there, at x - c_i, and puts f_i* in array i at x + c_i, which is the first
// state again. A half-way wall between x and x + c_i sends f_i* back to x as f_(-i), and that is
// where the even step has left it: the odd step then reads and writes array opposite(i) at x.
template <class Real>
class Populations final : public FluidImpl {
 public:
  Populations(MPI_Comm comm, const Options& options)
      : FluidImpl(comm, options),
        nx_(options.nodes[0]),
        ny_(options.nodes[1]),
        planes_(slab_.size()),
        pitch_(round_up(planes_ + pad_ + 1)),
        // An odd number of cache lines apart, the arrays do not compete for the same cache sets.
        stride_(round_up(static_cast<std::ptrdiff_t>(nx_) * ny_ * pitch_) / line_ | 1),
        storage_(static_cast<std::size_t>(Q * stride_ * line_)) {
    stride_ *= line_;
    list_ghosts();
    for (auto& column : column_force_) column.resize(static_cast<std::size_t>(planes_));
  }

  void initialise(const std::function<NodeState(int, int, int)>& state) override;
  void read_velocity() override;
  void step() override;
  void fields(std::span<double> density, std::span<double> velocity) override;
  std::vector<double> plane_sums() override;
  [[nodiscard]] std::size_t memory() const override {
    std::size_t bytes = storage_.bytes();
    for (const Patch& patch : patches_) bytes += 10 * sizeof(double) * patch.density.size();
    return bytes;
  }

 private:
  static constexpr std::ptrdiff_t line_ = 64 / sizeof(Real);
  static constexpr std::ptrdiff_t pad_ = line_;
  static std::ptrdiff_t round_up(std::ptrdiff_t n) { return (n + line_ - 1) / line_ * line_; }

  // Array i at column (x, y), plane 0 of the slab; ghosts are at -1 and planes_.
  Real* at(int i, int x, int y) {
    return storage_.data() + i * stride_ + (static_cast<std::ptrdiff_t>(x) * ny_ + y) * pitch_ +
           pad_;
  }
  // Column (x, y) + d, wrapped where periodic; false outside.
  bool neighbour(int& x, int& y, int dx, int dy) const {
    return shift(x, dx, nx_, options_.boundary[0]) && shift(y, dy, ny_, options_.boundary[1]);
  }
  static bool shift(int& x, int dx, int n, Boundary boundary) {
    x += dx;
    if (x >= 0 && x < n) return true;
    if (boundary != Boundary::periodic) return false;
    x = (x + n) % n;
    return true;
  }

  [[nodiscard]] bool odd() const { return time_ % 2 != 0; }
  Row<Real> row(int x, int y);
  [[nodiscard]] bool wall_of(int x, int y, RowWall& wall) const;
  void collide_column(int x, int y);
  void read_column(int x, int y, double* density, const std::array<double*, 3>& velocity);
  void drive_moving_walls();
  void drive_wall(int x, int y, int begin, int end, std::size_t axis, int side);

  // Ghost planes of the odd state.
  void fetch_ghosts();
  void return_ghosts();
  void exchange(bool back);
  void reflect(int side, bool back);
  void list_ghosts();

  int nx_;
  int ny_;
  int planes_;
  std::ptrdiff_t pitch_;
  std::ptrdiff_t stride_;
  HugePages<Real> storage_;
  bool ghosts_ready_ = false;
  // Offsets in storage_, at plane 0: of the population, and of that which a wall would reflect.
  struct Ghost {
    std::ptrdiff_t population;
    std::ptrdiff_t reflected;
  };
  std::array<std::vector<Ghost>, 2> ghosts_;
  std::array<std::vector<double>, 3> column_force_;
  std::array<std::vector<Real>, 2> outgoing_;
  std::array<std::vector<Real>, 2> incoming_;
};

template <class Real>
Row<Real> Populations<Real>::row(int x, int y) {
  Row<Real> row;
  row.rest = at(0, x, y);
  for (int p = 0; p < d3q19::pairs; ++p) {
    const auto n = static_cast<std::size_t>(p);
    const int plus = d3q19::plus(p);
    const int minus = d3q19::minus(p);
    const auto& e = d3q19::e[n];
    row.plus[n] = at(plus, x, y);
    row.minus[n] = at(minus, x, y);
    if (!odd()) continue;
    int xn = x;
    int yn = y;
    if (neighbour(xn, yn, -e[0], -e[1])) row.plus[n] = at(minus, xn, yn) - e[2];
    xn = x;
    yn = y;
    if (neighbour(xn, yn, e[0], e[1])) row.minus[n] = at(plus, xn, yn) + e[2];
  }
  return row;
}

template <class Real>
bool Populations<Real>::wall_of(int x, int y, RowWall& wall) const {
  wall = {};
  const std::array<int, 2> node = {x, y};
  int walls = 0;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (options_.boundary[axis] != Boundary::regularized) continue;
    const int last = options_.nodes[axis] - 1;
    if (node[axis] != 0 && node[axis] != last) continue;
    wall.normal[axis] = node[axis] == 0 ? 1 : -1;
    velocity += options_.wall_velocity[axis][node[axis] == 0 ? 0 : 1];
    ++walls;
  }
  if (walls == 0) return false;
  velocity /= walls;
  wall.velocity = {velocity[0], velocity[1], velocity[2]};
  return true;
}

template <class Real>
void Populations<Real>::collide_column(int x, int y) {
  const Row<Real> populations = row(x, y);
  RowForce force{{options_.force[0], options_.force[1], options_.force[2]},
                 {nullptr, nullptr, nullptr}};
  RowWall wall;
  if (wall_of(x, y, wall)) {
    collide_wall(populations, 0, planes_, relaxation_, force, wall);
    return;
  }
  // One pass over the whole column: where patches meet it, their forces are laid side by side.
  for (const Patch& patch : patches_) {
    const int i = x - patch.begin[0];
    const int j = y - patch.begin[1];
    if (i < 0 || i >= patch.size[0] || j < 0 || j >= patch.size[1]) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<double>& column = column_force_[axis];
      if (force.local[axis] == nullptr) std::fill(column.begin(), column.end(), 0.0);
      force.local[axis] = column.data();
      const double* from = &patch.force[axis][static_cast<std::size_t>(patch.at(i, j, 0))];
      std::copy(from, from + patch.size[2],
                &column[static_cast<std::size_t>(patch.begin[2] - slab_.begin)]);
    }
  }
  collide(populations, 0, planes_, relaxation_, force);
}

// Half-way bounce-back off a wall that moves with u_w: f_(-i) = f_i* - 6 w_i rho0 c_i.u_w, added
// where the reflected population waits, which is its own array in both states.
template <class Real>
void Populations<Real>::drive_wall(int x, int y, int begin, int end, std::size_t axis, int side) {
  const Eigen::Vector3d& u = options_.wall_velocity[axis][static_cast<std::size_t>(side)];
  const int inward = side == 0 ? 1 : -1;
  for (int i = 1; i < Q; ++i) {
    const auto v = c(i);
    if (v[axis] != inward) continue;
    // A link that crosses walls of two axes belongs to the first axis.
    const std::array<int, 3> origin = {x - v[0], y - v[1], 0};
    bool mine = true;
    for (std::size_t first = 0; first < std::min<std::size_t>(axis, 2); ++first) {
      const bool outside = origin[first] < 0 || origin[first] >= options_.nodes[first];
      if (outside && options_.boundary[first] == Boundary::halfway) mine = false;
    }
    if (!mine) continue;
    const double add = 6 * d3q19::w(i) * (v[0] * u[0] + v[1] * u[1] + v[2] * u[2]);
    Real* f = at(i, x, y);
    for (int k = begin; k < end; ++k) f[k] = static_cast<Real>(static_cast<double>(f[k]) + add);
  }
}

template <class Real>
void Populations<Real>::drive_moving_walls() {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (options_.boundary[axis] != Boundary::halfway) continue;
    for (int side = 0; side < 2; ++side) {
      if (options_.wall_velocity[axis][static_cast<std::size_t>(side)].isZero(0)) continue;
      const int at_wall = side == 0 ? 0 : options_.nodes[axis] - 1;
      if (axis == 0) {
        for (int y = 0; y < ny_; ++y) drive_wall(at_wall, y, 0, planes_, axis, side);
      } else if (axis == 1) {
        for (int x = 0; x < nx_; ++x) drive_wall(x, at_wall, 0, planes_, axis, side);
      } else if (at_wall >= slab_.begin && at_wall < slab_.end) {
        const int k = at_wall - slab_.begin;
        for (int x = 0; x < nx_; ++x) {
          for (int y = 0; y < ny_; ++y) drive_wall(x, y, k, k + 1, axis, side);
        }
      }
    }
  }
}

template <class Real>
void Populations<Real>::step() {
  if (odd()) fetch_ghosts();
  for (int x = 0; x < nx_; ++x) {
    for (int y = 0; y < ny_; ++y) collide_column(x, y);
  }
  if (odd()) return_ghosts();
  drive_moving_walls();
  ghosts_ready_ = false;
  ++time_;
}

// In the odd state the nodes at the ends of a slab use populations of the planes beyond: those of
// array i with c_i pointing there. They are fetched before, and returned after the step. Listed
// here is each one that a node of this slab uses: array i at the column one c_i on from that of a
// node.
template <class Real>
void Populations<Real>::list_ghosts() {
  for (int side = 0; side < 2; ++side) {
    for (int i = 1; i < Q; ++i) {
      const auto v = c(i);
      if (v[2] != (side == 0 ? -1 : 1)) continue;
      for (int x = 0; x < nx_; ++x) {
        for (int y = 0; y < ny_; ++y) {
          int xn = x;
          int yn = y;
          if (!neighbour(xn, yn, v[0], v[1])) continue;
          ghosts_[static_cast<std::size_t>(side)].push_back(
              {at(i, xn, yn) - storage_.data(), at(opposite(i), x, y) - storage_.data()});
        }
      }
    }
  }
}

// Ghost plane below (side 0): the plane below's array i with c_iz = -1, and so on.
template <class Real>
void Populations<Real>::exchange(bool back) {
  const bool periodic = options_.boundary[2] == Boundary::periodic;
  std::array<int, 2> peer = {rank_ - 1, rank_ + 1};
  for (int& p : peer) {
    if (periodic) p = (p + ranks_) % ranks_;
    if (p < 0 || p >= ranks_) p = MPI_PROC_NULL;
  }
  // Fetching, the ghosts of one side are the neighbour's end plane of the other side: what a rank
  // gives to its lower neighbour are the populations of its plane 0 that move up.
  for (int side = 0; side < 2; ++side) {
    const auto s = static_cast<std::size_t>(side);
    // The populations that cross to that side's neighbour move its way; returned, they go back.
    const std::size_t moving = back ? s : 1 - s;
    const int own = side == 0 ? 0 : planes_ - 1;
    const int ghost = side == 0 ? -1 : planes_;
    const Real* plane = storage_.data() + (back ? ghost : own);
    outgoing_[s].clear();
    for (const Ghost& g : ghosts_[moving]) outgoing_[s].push_back(plane[g.population]);
    incoming_[s].resize(ghosts_[1 - moving].size());
  }
  const auto bytes = [](const std::vector<Real>& v) {
    return static_cast<int>(v.size() * sizeof(Real));
  };
  std::array<MPI_Request, 4> requests{};
  for (int side = 0; side < 2; ++side) {
    const auto s = static_cast<std::size_t>(side);
    check(MPI_Irecv(incoming_[s].data(), bytes(incoming_[s]), MPI_BYTE, peer[s], 1 - side, comm_,
                    &requests[s]),
          "MPI_Irecv");
    check(MPI_Isend(outgoing_[s].data(), bytes(outgoing_[s]), MPI_BYTE, peer[s], side, comm_,
                    &requests[2 + s]),
          "MPI_Isend");
  }
  check(MPI_Waitall(4, requests.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
  for (int side = 0; side < 2; ++side) {
    const auto s = static_cast<std::size_t>(side);
    if (peer[s] == MPI_PROC_NULL) continue;
    const std::size_t moving = back ? 1 - s : s;
    const int own = side == 0 ? 0 : planes_ - 1;
    const int ghost = side == 0 ? -1 : planes_;
    Real* plane = storage_.data() + (back ? own : ghost);
    std::size_t n = 0;
    for (const Ghost& g : ghosts_[moving]) plane[g.population] = incoming_[s][n++];
  }
}

// A half-way wall beyond the end plane: the ghosts are the node's own reflected populations.
template <class Real>
void Populations<Real>::reflect(int side, bool back) {
  const int own = side == 0 ? 0 : planes_ - 1;
  const int ghost = side == 0 ? -1 : planes_;
  for (const Ghost& g : ghosts_[static_cast<std::size_t>(side)]) {
    Real& reflected = storage_.data()[g.reflected + own];
    Real& beyond = storage_.data()[g.population + ghost];
    if (back) {
      reflected = beyond;
    } else {
      beyond = reflected;
    }
  }
}

template <class Real>
void Populations<Real>::fetch_ghosts() {
  if (ghosts_ready_) return;
  exchange(false);
  if (options_.boundary[2] == Boundary::halfway) {
    if (rank_ == 0) reflect(0, false);
    if (rank_ == ranks_ - 1) reflect(1, false);
  }
  ghosts_ready_ = true;
}

template <class Real>
void Populations<Real>::return_ghosts() {
  exchange(true);
  if (options_.boundary[2] == Boundary::halfway) {
    if (rank_ == 0) reflect(0, true);
    if (rank_ == ranks_ - 1) reflect(1, true);
  }
}

template <class Real>
void Populations<Real>::initialise(const std::function<NodeState(int, int, int)>& state) {
  time_ = 0;
  ghosts_ready_ = false;
  const Eigen::Vector3d& force = options_.force;
  for (int x = 0; x < nx_; ++x) {
    for (int y = 0; y < ny_; ++y) {
      for (int k = 0; k < planes_; ++k) {
        const NodeState s = state(x, y, slab_.begin + k);
        const Eigen::Vector3d& u = s.velocity;
        const double uu = u.squaredNorm();
        for (int i = 0; i < Q; ++i) {
          const auto v = c(i);
          const Eigen::Vector3d e(v[0], v[1], v[2]);
          const double cu = e.dot(u);
          const double equilibrium =
              (s.density - 1) + s.density * (3 * cu + 4.5 * cu * cu - 1.5 * uu);
          const double stress = -3 * s.density / relaxation_.omega_plus *
                                (e.dot(s.gradient * e) - s.gradient.trace() / 3);
          const double forcing = -0.5 * (3 * (e - u).dot(force) + 9 * cu * e.dot(force));
          at(i, x, y)[k] = static_cast<Real>(d3q19::w(i) * (equilibrium + stress + forcing));
        }
      }
    }
  }
}

template <class Real>
void Populations<Real>::read_velocity() {
  if (odd()) fetch_ghosts();
  const Eigen::Vector3d half = 0.5 * options_.force;
  for (Patch& patch : patches_) {
    const int begin = patch.begin[2] - slab_.begin;
    for (int i = 0; i < patch.size[0]; ++i) {
      for (int j = 0; j < patch.size[1]; ++j) {
        const auto first = static_cast<std::size_t>(patch.at(i, j, 0));
        const auto count = static_cast<std::size_t>(patch.size[2]);
        double* density = &patch.density[first] - begin;
        moments(row(patch.begin[0] + i, patch.begin[1] + j), begin, begin + patch.size[2], density,
                &patch.momentum[0][first] - begin, &patch.momentum[1][first] - begin,
                &patch.momentum[2][first] - begin);
        for (std::size_t n = first; n < first + count; ++n) {
          patch.density[n] += 1;
          for (std::size_t axis = 0; axis < 3; ++axis) {
            patch.momentum[axis][n] += half[static_cast<Eigen::Index>(axis)];
          }
        }
      }
    }
    for (auto& force : patch.force) std::fill(force.begin(), force.end(), 0.0);
  }
}

// Density and velocity of one column, to four arrays of planes_ numbers.
template <class Real>
void Populations<Real>::read_column(int x, int y, double* density,
                                    const std::array<double*, 3>& velocity) {
  moments(row(x, y), 0, planes_, density, velocity[0], velocity[1], velocity[2]);
  RowWall wall;
  const bool on_wall = wall_of(x, y, wall);
  for (int k = 0; k < planes_; ++k) {
    density[k] += 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double half_force = 0.5 * options_.force[static_cast<Eigen::Index>(axis)];
      velocity[axis][k] =
          on_wall ? wall.velocity[axis] : (velocity[axis][k] + half_force) / density[k];
    }
  }
}

template <class Real>
void Populations<Real>::fields(std::span<double> density, std::span<double> velocity) {
  if (odd()) fetch_ghosts();
  const auto planes = static_cast<std::size_t>(planes_);
  const std::size_t count = static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) * planes;
  if (density.size() != count || velocity.size() != 3 * count) {
    reject("fields need " + std::to_string(count) +
           " densities and three times as many velocities");
  }
  std::size_t first = 0;
  for (int x = 0; x < nx_; ++x) {
    for (int y = 0; y < ny_; ++y, first += planes) {
      read_column(x, y, &density[first],
                  {&velocity[first], &velocity[count + first], &velocity[2 * count + first]});
    }
  }
}

template <class Real>
std::vector<double> Populations<Real>::plane_sums() {
  if (odd()) fetch_ghosts();
  const auto planes = static_cast<std::size_t>(planes_);
  std::vector<double> column(4 * planes);
  std::vector<double> sums(4 * planes, 0.0);
  for (int x = 0; x < nx_; ++x) {
    for (int y = 0; y < ny_; ++y) {
      read_column(x, y, column.data(), {&column[planes], &column[2 * planes], &column[3 * planes]});
      for (std::size_t k = 0; k < planes; ++k) {
        sums[4 * k] += column[k] - 1;
        for (std::size_t axis = 1; axis < 4; ++axis) {
          sums[4 * k + axis] += column[k] * column[axis * planes + k];
        }
      }
    }
  }
  return sums;
}

std::unique_ptr<FluidImpl> make(MPI_Comm comm, const Options& options) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  validate(options, ranks);
  if (options.storage == Storage::single_precision) {
    return std::make_unique<Populations<float>>(comm, options);
  }
  return std::make_unique<Populations<double>>(comm, options);
}

}  // namespace

Fluid::Fluid(MPI_Comm comm, const Options& options) : impl_(make(comm, options)) {
  initialise([](int, int, int) { return NodeState{}; });
}
Fluid::~Fluid() = default;
Fluid::Fluid(Fluid&&) noexcept = default;
Fluid& Fluid::operator=(Fluid&&) noexcept = default;

const Options& Fluid::options() const {
  return impl_->options_;
}
MPI_Comm Fluid::comm() const {
  return impl_->comm_;
}
double Fluid::viscosity() const {
  return d3q19::c_s2 * (impl_->options_.tau - 0.5);
}
Range Fluid::slab() const {
  return impl_->slab_;
}
Range Fluid::slab(int rank) const {
  return share(impl_->options_.nodes[2], impl_->ranks_, rank);
}
Box Fluid::domain() const {
  return impl_->domain();
}
std::int64_t Fluid::time() const {
  return impl_->time_;
}
std::size_t Fluid::memory() const {
  return impl_->memory();
}
void Fluid::initialise(const std::function<NodeState(int, int, int)>& state) {
  impl_->initialise(state);
}
void Fluid::place_boxes(std::span<const Box> boxes) {
  impl_->place_boxes(boxes);
}
std::span<Patch> Fluid::patches() {
  return impl_->patches_;
}
void Fluid::read_velocity() {
  impl_->read_velocity();
}
void Fluid::update_velocity() {
  for (Patch& patch : impl_->patches_) {
    const int rows = patch.size[0] * patch.size[1];
    for (int r = 0; r < rows; ++r) {
      const std::ptrdiff_t first = r * patch.pitch + Patch::pad;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double* u = patch.velocity[axis].data() + first;
        const double* momentum = patch.momentum[axis].data() + first;
        const double* force = patch.force[axis].data() + first;
        const double* density = patch.density.data() + first;
#pragma GCC ivdep
        for (int k = 0; k < patch.size[2]; ++k) {
          u[k] = (momentum[k] + 0.5 * force[k]) / density[k];
        }
      }
    }
  }
}
void Fluid::step() {
  impl_->step();
}
void Fluid::fields(std::span<double> density, std::span<double> velocity) {
  impl_->fields(density, velocity);
}
Totals Fluid::totals() {
  return impl_->totals();
}

}  // namespace ductile::fluid
