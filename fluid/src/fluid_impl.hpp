// The fluid behind its interface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ductile/fluid/fluid.hpp"
#include "ductile/fluid/mpi.hpp"
#include "kernel.hpp"
#include "patch.hpp"

namespace ductile::fluid {

/// Throws std::invalid_argument.
[[noreturn]] void reject(const std::string& what);
/// The part of a fluid that does not depend on how populations are stored.
class FluidImpl {
 public:
  /// `options` are valid.
  FluidImpl(Communicator comm, const Options& options);
  virtual ~FluidImpl() = default;
  FluidImpl(const FluidImpl&) = delete;
  FluidImpl& operator=(const FluidImpl&) = delete;

  virtual void initialise(const std::function<NodeState(int, int, int)>& state) = 0;
  virtual void read_velocity() = 0;
  virtual void step() = 0;
  /// The loads and stores of a step, and nothing else.
  virtual void stream() = 0;
  virtual void fields(std::span<double> density, std::span<double> velocity) = 0;
  virtual void save(const StateWriter& write) = 0;
  virtual void load(const StateReader& read) = 0;
  /// The sums of rho - 1 and of rho u of each own plane.
  virtual std::vector<double> plane_sums() = 0;
  /// The sum of u_z of each own plane.
  virtual std::vector<double> plane_flows() = 0;
  /// Whether what is looked at of the own slab is finite.
  virtual bool finite() = 0;
  [[nodiscard]] virtual std::size_t memory() const = 0;
  [[nodiscard]] virtual std::int64_t bytes_sent() const = 0;

  /// As at the start.
  void reset_motion();
  /// Also sets what follows from it: the uniform force and the walls' velocities on the lattice.
  void set_motion(const LatticeMotion& motion);
  void accelerate(double acceleration);
  /// The lattice's part of a step.
  void move_lattice();

  [[nodiscard]] Box box_around(const Box& reach) const;
  void place_boxes(std::span<const Box> boxes);
  [[nodiscard]] bool touches(int rank, const Box& box) const;
  void reached(int rank, std::span<const double> positions, std::vector<int>& points,
               std::vector<std::size_t>& split) const;
  void update_velocity();
  Totals totals();
  double flow();
  [[nodiscard]] Box domain() const;
  /// The box, made larger if it must be to hold the image of all that it has below a mirror plane.
  [[nodiscard]] Box with_image(Box box) const;
  [[nodiscard]] Range slab(int rank) const;
  /// The number of planes after which z repeats, 0 if it does not.
  [[nodiscard]] int period() const {
    return options_.boundary[2] == Boundary::periodic ? options_.nodes[2] : 0;
  }
  /// The node of which node y is the image in the mirror plane, and the other way round.
  [[nodiscard]] int image(int y) const { return fluid::image(options_.mirror, y); }
  /// What a node of this density weighs in its momentum.
  [[nodiscard]] double weighing(double density) const { return compressible() ? density : 1; }
  [[nodiscard]] bool compressible() const {
    return options_.equilibrium == Equilibrium::compressible;
  }
  /// Which of the two states of the AA pattern the populations are in.
  [[nodiscard]] bool odd() const { return odd_; }
  [[nodiscard]] std::size_t column(int x, int y) const {
    return static_cast<std::size_t>(x) * static_cast<std::size_t>(options_.nodes[1]) +
           static_cast<std::size_t>(y);
  }

  void drop_force();
  /// The image of force below a mirror plane is added above it, along y on it cancelled.
  void fold_force();
  /// Adds the image of force on a mirror plane that goes through nodes; once a step.
  void double_force_on_plane();
  /// Velocity below a mirror plane becomes the image of what is above.
  void fill_image_of_velocity(Patch& patch) const;
  /// Room for the momentum, and for the density if it weighs anything, which few bodies ask for.
  template <class T>
  void make_moments(LocalFields<T>& local) const {
    const std::size_t count = local.force[0].size();
    if (compressible()) local.density.resize(count, T{1});
    for (auto& momentum : local.momentum) momentum.resize(count, T{0});
  }

  Options options_;
  Communicator comm_;
  Range slab_;
  Relaxation relaxation_{};
  LatticeMotion motion_;
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero();                // uniform, on the lattice
  std::array<std::array<Eigen::Vector3d, 2>, 3> wall_velocity_{};  // on the lattice
  std::int64_t time_ = 0;
  bool odd_ = false;
  std::vector<Box> boxes_;   // disjoint
  std::vector<int> holder_;  // the one of boxes_ that holds each box asked for
  std::vector<Patch> patches_;
  /// The patches that meet column c, from low to high z, are met_[first_met_[c]] to
  /// met_[first_met_[c + 1]], end excluded.
  std::vector<std::size_t> first_met_;
  std::vector<std::size_t> met_;

 private:
  /// wall_velocity_ has changed.
  virtual void walls_moved() = 0;
  void place_patches(int index);
  template <class Number>
  void fold(const Patch& patch, std::array<std::vector<Number>, 3>& force) const;
  template <class Number>
  void update(const Patch& patch, LocalFields<Number>& local) const;
  template <class Number>
  void fill_image(const Patch& patch, std::array<std::vector<Number>, 3>& vectors) const;
  void list_met();
  [[nodiscard]] std::optional<std::size_t> row_on_plane(const Patch& patch, int i) const;
  [[nodiscard]] std::vector<double> of_all_planes(const std::vector<double>& own, int each) const;
};

/// Opens a Fluid to the library's own sources and to its tests.
struct Inside {
  static FluidImpl& of(Fluid& fluid) { return *fluid.impl_; }
};

std::unique_ptr<FluidImpl> make_populations(Communicator comm, const Options& options);

}  // namespace ductile::fluid
