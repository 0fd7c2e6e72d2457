#include "ductile/fluid/fluid.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "ductile/fluid/bench.hpp"
#include "ductile/fluid/d3q19.hpp"
#include "fluid_impl.hpp"

namespace ductile::fluid {
namespace {

// The options with all choices made.
Options validated(const Communicator& comm, Options options) {
  if (!(options.tau > 0.5) || !std::isfinite(options.tau)) {
    reject("tau = " + std::to_string(options.tau) + " must exceed 1/2");
  }
  if (options.collision == Collision::trt && !(options.magic > 0 && std::isfinite(options.magic))) {
    reject("magic = " + std::to_string(options.magic) + " must be positive and finite");
  }
  if (!options.force.allFinite()) reject("the force must be finite");
  if (!std::isfinite(options.lattice_velocity) ||
      (options.lattice_velocity != 0 && options.boundary[2] != Boundary::periodic)) {
    reject("the lattice moves along z only where that is periodic, with a finite velocity");
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
        reject(std::string("the velocity of a wall across ")
                   .append(name)
                   .append(" must have no component along ")
                   .append(name));
      }
    }
  }
  if (options.mirror != Mirror::none) {
    if (options.boundary[1] == Boundary::periodic) {
      reject("a mirror plane across y needs a wall at the other end of y");
    }
    if (!options.wall_velocity[1][0].isZero(0)) {
      reject("a mirror plane has no velocity: leave wall_velocity[1][0] zero");
    }
    for (const auto& walls : options.wall_velocity) {
      for (const Eigen::Vector3d& u : walls) {
        if (u.y() != 0) reject("walls that move along y are not symmetric about a mirror plane");
      }
    }
    if (options.force.y() != 0) reject("a force along y is not symmetric about a mirror plane");
  }
  if (options.arithmetic == Precision::single_precision &&
      options.storage == Precision::double_precision) {
    reject("arithmetic in single precision needs populations stored in single precision");
  }
  if (options.nodes[2] < comm.size()) {
    reject(std::to_string(options.nodes[2]) + " planes cannot be shared by " +
           std::to_string(comm.size()) + " ranks; use fewer ranks");
  }
  if (!options.instruction_set) options.instruction_set = best_instruction_set();
  int everywhere = available(*options.instruction_set) ? 1 : 0;
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, &everywhere, 1, MPI_INT, MPI_MIN, comm.get()),
            "MPI_Allreduce");
  if (everywhere == 0) {
    reject("a rank's machine or this program has no " +
           std::string(name(*options.instruction_set)));
  }
  return options;
}

}  // namespace

void reject(const std::string& what) {
  throw std::invalid_argument("fluid: " + what);
}

bool Totals::finite() const {
  return std::isfinite(mass) && momentum.allFinite();
}

FluidImpl::FluidImpl(Communicator comm, const Options& options)
    : options_(options), comm_(std::move(comm)), slab_(slab(comm_.rank())) {
  relaxation_.omega_plus = 1 / options.tau;
  relaxation_.omega_minus = options.collision == Collision::bgk
                                ? relaxation_.omega_plus
                                : 1 / (0.5 + options.magic / (options.tau - 0.5));
}

void FluidImpl::reset_motion() {
  set_motion({0, options_.lattice_velocity, 0});
}

void FluidImpl::set_motion(const LatticeMotion& motion) {
  motion_ = motion;
  force_ = options_.force;
  force_.z() -= motion.acceleration;
  wall_velocity_ = options_.wall_velocity;
  for (const std::size_t axis : {0, 1}) {
    if (options_.boundary[axis] == Boundary::periodic) continue;
    // Half-way walls reflect what has the whole force of the step in, half more than the velocity.
    double gained = motion.velocity - options_.lattice_velocity;
    if (options_.boundary[axis] == Boundary::halfway) gained += 0.5 * motion.acceleration;
    const bool mirror = axis == 1 && options_.mirror != Mirror::none;
    for (std::size_t side = mirror ? 1 : 0; side < 2; ++side)
      wall_velocity_[axis][side].z() -= gained;
  }
  walls_moved();
}

void FluidImpl::accelerate(double acceleration) {
  if (!std::isfinite(acceleration) || options_.boundary[2] != Boundary::periodic) {
    reject("the lattice moves along z only where that is periodic, with a finite acceleration");
  }
  LatticeMotion motion = motion_;
  motion.velocity += 0.5 * (acceleration - motion.acceleration);  // as that of the fluid
  motion.acceleration = acceleration;
  set_motion(motion);
}

void FluidImpl::move_lattice() {
  LatticeMotion motion = motion_;
  motion.position += motion.velocity;
  if (motion.acceleration == 0) {
    motion_ = motion;
    return;
  }
  motion.velocity += motion.acceleration;
  set_motion(motion);
}

Range FluidImpl::slab(int rank) const {
  const auto start = [&](int r) {
    return static_cast<int>(static_cast<std::int64_t>(options_.nodes[2]) * r / comm_.size());
  };
  return {start(rank), start(rank + 1)};
}

// On every rank `each` numbers of every plane, from those of the own planes: so that planes can be
// summed one by one in their order, whoever holds them.
std::vector<double> FluidImpl::of_all_planes(const std::vector<double>& own, int each) const {
  std::vector<int> counts;
  std::vector<int> offsets;
  for (int r = 0; r < comm_.size(); ++r) {
    const Range s = slab(r);
    counts.push_back(each * s.size());
    offsets.push_back(each * s.begin);
  }
  std::vector<double> all(static_cast<std::size_t>(each) *
                          static_cast<std::size_t>(options_.nodes[2]));
  mpi_check(MPI_Allgatherv(own.data(), static_cast<int>(own.size()), MPI_DOUBLE, all.data(),
                           counts.data(), offsets.data(), MPI_DOUBLE, comm_.get()),
            "MPI_Allgatherv");
  return all;
}

Totals FluidImpl::totals() {
  const std::vector<double> all = of_all_planes(plane_sums(), 4);
  Totals totals;
  for (std::size_t p = 0; p < all.size(); p += 4) {
    totals.mass += all[p];
    totals.momentum += Eigen::Vector3d(all[p + 1], all[p + 2], all[p + 3]);
  }
  return totals;
}

double FluidImpl::flow() {
  const std::vector<double> all = of_all_planes(plane_flows(), 1);
  return std::accumulate(all.begin(), all.end(), 0.0);
}

Fluid::Fluid(MPI_Comm comm, const Options& options) {
  Communicator own(comm);
  const Options all = validated(own, options);
  impl_ = make_populations(std::move(own), all);
  initialise([](int, int, int) { return NodeState{}; });
}
Fluid::~Fluid() = default;
Fluid::Fluid(Fluid&&) noexcept = default;
Fluid& Fluid::operator=(Fluid&&) noexcept = default;

const Options& Fluid::options() const {
  return impl_->options_;
}
MPI_Comm Fluid::comm() const {
  return impl_->comm_.get();
}
double Fluid::viscosity() const {
  return d3q19::c_s2 * (impl_->options_.tau - 0.5);
}
Range Fluid::slab() const {
  return impl_->slab_;
}
Range Fluid::slab(int rank) const {
  return impl_->slab(rank);
}
Box Fluid::domain() const {
  return impl_->domain();
}
const LatticeMotion& Fluid::motion() const {
  return impl_->motion_;
}
void Fluid::accelerate(double acceleration) {
  impl_->accelerate(acceleration);
}
std::int64_t Fluid::time() const {
  return impl_->time_;
}
std::size_t Fluid::memory() const {
  return impl_->memory();
}
std::int64_t Fluid::bytes_sent() const {
  return impl_->bytes_sent();
}
void Fluid::initialise(const std::function<NodeState(int, int, int)>& state) {
  impl_->initialise(state);
}
Box Fluid::box_around(const Box& reach) const {
  return impl_->box_around(reach);
}
void Fluid::place_boxes(std::span<const Box> boxes) {
  impl_->place_boxes(boxes);
}
bool Fluid::touches(int rank, const Box& box) const {
  return impl_->touches(rank, box);
}
void Fluid::reached(int rank, std::span<const double> positions, std::vector<int>& points,
                    std::vector<std::size_t>& split) const {
  impl_->reached(rank, positions, points, split);
}
void Fluid::read_velocity() {
  impl_->read_velocity();
}
void Fluid::update_velocity() {
  impl_->update_velocity();
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
double Fluid::flow() {
  return impl_->flow();
}
bool Fluid::finite() {
  int all = impl_->finite() ? 1 : 0;
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, comm()), "MPI_Allreduce");
  return all == 1;
}
void Fluid::save(const StateWriter& write) {
  impl_->save(write);
}
void Fluid::load(const StateReader& read) {
  impl_->load(read);
}

void stream_only(Fluid& fluid) {
  Inside::of(fluid).stream();
}

}  // namespace ductile::fluid
