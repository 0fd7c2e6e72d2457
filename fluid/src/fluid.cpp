#include "ductile/fluid/fluid.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "ductile/fluid/bench.hpp"
#include "ductile/fluid/d3q19.hpp"
#include "fluid_impl.hpp"

namespace ductile::fluid {
namespace {

// The options with all choices made.
Options validated(int ranks, Options options) {
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
  if (options.nodes[2] < ranks) {
    reject(std::to_string(options.nodes[2]) + " planes cannot be shared by " +
           std::to_string(ranks) + " ranks; use fewer ranks");
  }
  if (!options.instruction_set) options.instruction_set = best_instruction_set();
  if (!available(*options.instruction_set)) {
    reject("this machine or this program has no " + std::string(name(*options.instruction_set)));
  }
  return options;
}

}  // namespace

void reject(const std::string& what) {
  throw std::invalid_argument("fluid: " + what);
}

Range share(int planes, int ranks, int rank) {
  const auto start = [&](int r) {
    return static_cast<int>(static_cast<std::int64_t>(planes) * r / ranks);
  };
  return {start(rank), start(rank + 1)};
}

bool Totals::finite() const {
  return std::isfinite(mass) && momentum.allFinite();
}

FluidImpl::FluidImpl(Communicator comm, const Options& options)
    : options_(options),
      comm_(std::move(comm)),
      slab_(share(options.nodes[2], comm_.size(), comm_.rank())) {
  relaxation_.omega_plus = 1 / options.tau;
  relaxation_.omega_minus = options.collision == Collision::bgk
                                ? relaxation_.omega_plus
                                : 1 / (0.5 + options.magic / (options.tau - 0.5));
}

Box FluidImpl::domain() const {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int wall = options_.boundary[axis] == Boundary::regularized ? 1 : 0;
    box[axis] = {wall, options_.nodes[axis] - wall};
  }
  if (options_.mirror != Mirror::none) box[1].begin = image(box[1].end - 1);
  return box;
}

Box FluidImpl::with_image(Box box) const {
  if (options_.mirror != Mirror::none && box[1].begin < 0) {
    box[1].end = std::max(box[1].end, image(box[1].begin) + 1);
  }
  return box;
}

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
    if (with_image(box)[1].end != box[1].end) {
      reject("box of nodes " + std::to_string(box[1].begin) + " to " + std::to_string(box[1].end) +
             " along y does not hold the image of its nodes below the mirror plane");
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
  list_met();
}

void FluidImpl::list_met() {
  const std::size_t columns = column(options_.nodes[0], 0);
  std::vector<std::vector<std::size_t>> met(columns);
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    const Patch& patch = patches_[p];
    for (int i = 0; i < patch.size[0]; ++i) {
      for (int j = std::max(0, -patch.begin[1]); j < patch.size[1]; ++j) {
        met[column(patch.begin[0] + i, patch.begin[1] + j)].push_back(p);
      }
    }
  }
  first_met_ = {0};
  met_.clear();
  for (auto& of_column : met) {
    std::sort(of_column.begin(), of_column.end(), [&](std::size_t a, std::size_t b) {
      return patches_[a].begin[2] < patches_[b].begin[2];
    });
    met_.insert(met_.end(), of_column.begin(), of_column.end());
    first_met_.push_back(met_.size());
  }
}

Totals FluidImpl::totals() {
  const std::vector<double> own = plane_sums();
  // Planes are summed one by one in their order, whoever holds them.
  std::vector<int> counts;
  std::vector<int> offsets;
  for (int r = 0; r < comm_.size(); ++r) {
    const Range s = share(options_.nodes[2], comm_.size(), r);
    counts.push_back(4 * s.size());
    offsets.push_back(4 * s.begin);
  }
  std::vector<double> all(4 * static_cast<std::size_t>(options_.nodes[2]));
  mpi_check(MPI_Allgatherv(own.data(), static_cast<int>(own.size()), MPI_DOUBLE, all.data(),
                           counts.data(), offsets.data(), MPI_DOUBLE, comm_.get()),
            "MPI_Allgatherv");
  Totals totals;
  for (std::size_t p = 0; p < all.size(); p += 4) {
    totals.mass += all[p];
    totals.momentum += Eigen::Vector3d(all[p + 1], all[p + 2], all[p + 3]);
  }
  return totals;
}

// Below a mirror plane force is not used. On one on nodes, what a body gives from both sides
// cancels along y, but for round-off.
void FluidImpl::drop_image_force() {
  if (options_.mirror == Mirror::none) return;
  for (Patch& patch : patches_) {
    for (int i = 0; i < patch.size[0]; ++i) {
      for (int y = patch.begin[1]; y <= std::min(0, image(0)); ++y) {
        const auto first = static_cast<std::size_t>(patch.at(i, y - patch.begin[1], -Patch::pad));
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (y < 0 || axis == 1) std::fill_n(&patch.force[axis][first], patch.pitch, 0.0);
        }
      }
    }
  }
}

void FluidImpl::fill_image(const Patch& patch, std::vector<double>& values, double sign) const {
  for (int i = 0; i < patch.size[0]; ++i) {
    for (int y = patch.begin[1]; y < 0; ++y) {
      const double* from = values.data() + patch.at(i, image(y) - patch.begin[1], 0);
      double* to = values.data() + patch.at(i, y - patch.begin[1], 0);
      for (int k = 0; k < patch.size[2]; ++k) to[k] = sign * from[k];
    }
  }
}

void FluidImpl::fill_image(const Patch& patch, std::array<std::vector<double>, 3>& vectors) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    fill_image(patch, vectors[axis], axis == 1 ? -1 : 1);
  }
}

void FluidImpl::update_velocity() {
  drop_image_force();
  for (Patch& patch : patches_) {
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
    fill_image(patch, patch.velocity);
  }
}

Fluid::Fluid(MPI_Comm comm, const Options& options) {
  Communicator own(comm);
  const Options all = validated(own.size(), options);
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
  return share(impl_->options_.nodes[2], impl_->comm_.size(), rank);
}
Box Fluid::domain() const {
  return impl_->domain();
}
Box Fluid::with_image(Box box) const {
  return impl_->with_image(box);
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

void stream_only(Fluid& fluid) {
  fluid.impl_->stream();
}

}  // namespace ductile::fluid
