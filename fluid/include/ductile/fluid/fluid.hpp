// The fluid: lattice Boltzmann (D3Q19) in a box of nodes, cut into slabs along z over the ranks.
#pragma once

#include <mpi.h>

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "ductile/fluid/instruction_set.hpp"

namespace ductile::fluid {

/// What bounds the box at both ends of an axis. With N nodes 0 .. N-1 along the axis:
enum class Boundary {
  periodic,    ///< node N is node 0
  halfway,     ///< no-slip walls at -1/2 and N - 1/2: half-way bounce-back, width N
  regularized  ///< no-slip walls on nodes 0 and N - 1: Latt et al. 2008 (the paper's), width N - 1
};

/// A plane of symmetry at the low end of y: the box is the upper half of a fluid that is the mirror
/// image of itself, and nodes below 0 are images of those above.
enum class Mirror {
  none,
  between_nodes,  ///< at y = -1/2: node -1 - j is the image of node j
  on_node         ///< at y = 0: node -j is the image of node j, and node 0 its own
};

enum class Collision {
  bgk,  ///< eq. (2)
  trt   ///< two relaxation times: odd moments relax so that (tau - 1/2)(tau_odd - 1/2) = magic
};

enum class Storage { double_precision, single_precision };

/// All that defines a fluid; lattice units (dx = dt = rho0 = 1).
struct Options {
  std::array<int, 3> nodes{};  ///< along x, y, z
  std::array<Boundary, 3> boundary{Boundary::periodic, Boundary::periodic, Boundary::periodic};
  Mirror mirror = Mirror::none;  ///< in place of the low wall across y
  /// Velocity of the wall at the low and the high end of each axis, tangential to the wall.
  std::array<std::array<Eigen::Vector3d, 2>, 3> wall_velocity{
      {{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()},
       {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()},
       {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}}};
  double tau = 1;  ///< relaxation time of the viscous stress; nu = (tau - 1/2)/3
  Collision collision = Collision::bgk;
  double magic = 3.0 / 16.0;                        ///< TRT only
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< uniform body force density
  /// Storage of the populations; arithmetic is always in double precision.
  Storage storage = Storage::double_precision;
  /// What the kernel runs on: the widest that this machine has, unless given. Results do not depend
  /// on it.
  std::optional<InstructionSet> instruction_set;
};

/// Density, velocity and velocity gradient at a node; gradient(a, b) = du_b/dx_a.
struct NodeState {
  double density = 1;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
};

/// Sums over all nodes; the same to the last bit on any number of ranks. With a mirror plane those
/// of the half above it: nodes on the plane count half.
struct Totals {
  double mass = 0;                                     ///< sum of rho - 1
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();  ///< sum of rho u, half the uniform force in
  [[nodiscard]] bool finite() const;
};

/// A range of planes or nodes, end excluded.
struct Range {
  int begin = 0;
  int end = 0;
  [[nodiscard]] int size() const { return end - begin; }
};

/// A box of nodes around bodies. z may run outside [0, nz) where the axis is periodic, y below 0
/// where there is a mirror plane.
using Box = std::array<Range, 3>;

/// The part of a box that lies on this rank: where a force acts that varies from node to node, and
/// where the velocity is known. Arrays run over x, y, z, z fastest; each row of z is `pitch` long,
/// with `pad` planes on either side of the `size[2]` that are this rank's own. In those planes the
/// velocity is 0 and the force is ignored, so that a stencil may reach over the edge.
///
/// Below a mirror plane density and velocity are the image of those above, and the force is taken
/// to be, whatever is written there: a body across the plane may spread its force on both sides. On
/// the plane no force acts along y.
struct Patch {
  static constexpr int pad = 4;
  int box = 0;                 ///< index of the box it belongs to
  std::array<int, 3> begin{};  ///< first own node; z in [0, nz)
  std::array<int, 3> size{};   ///< own nodes along each axis
  std::ptrdiff_t pitch = 0;

  std::array<std::vector<double>, 3> force;     ///< beyond the uniform one, for the next step
  std::array<std::vector<double>, 3> velocity;  ///< (rho u0 + force/2)/rho
  std::vector<double> density;                  ///< as of read_velocity()
  std::array<std::vector<double>, 3> momentum;  ///< rho u0, likewise

  /// Index of node (i, j, k), counted from `begin`; k may lie in the padding.
  [[nodiscard]] std::ptrdiff_t at(int i, int j, int k) const {
    return (static_cast<std::ptrdiff_t>(i) * size[1] + j) * pitch + pad + k;
  }
};

class FluidImpl;

/// The fluid's populations and their evolution. Every member marked collective is called by all
/// ranks of the communicator, in the same order.
class Fluid {
 public:
  /// Collective. Each rank holds an even share of the planes. The fluid is at rest.
  /// Throws std::invalid_argument, on every rank, if tau <= 1/2, magic <= 0, an axis has fewer than
  /// 2 nodes (4 with walls on nodes), z is regularized, a wall velocity has a normal component,
  /// a mirror plane faces no wall, the force or a wall's velocity is not symmetric about it, there
  /// are more ranks than planes, or a given instruction set is not available.
  Fluid(MPI_Comm comm, const Options& options);
  ~Fluid();
  Fluid(Fluid&&) noexcept;
  Fluid& operator=(Fluid&&) noexcept;
  Fluid(const Fluid&) = delete;
  Fluid& operator=(const Fluid&) = delete;

  /// As given, with the instruction set that was chosen.
  [[nodiscard]] const Options& options() const;
  [[nodiscard]] MPI_Comm comm() const;
  /// nu = c_s^2 (tau - 1/2).
  [[nodiscard]] double viscosity() const;
  /// Planes of this rank, and of any rank.
  [[nodiscard]] Range slab() const;
  [[nodiscard]] Range slab(int rank) const;
  /// Nodes on which a body may act: all but the walls' own, and with a mirror plane their images.
  [[nodiscard]] Box domain() const;
  /// The box, made larger if it must be to hold the image of all that it has below a mirror plane.
  [[nodiscard]] Box with_image(Box box) const;
  /// Time steps done.
  [[nodiscard]] std::int64_t time() const;
  /// Bytes held by this rank: populations, messages and patches.
  [[nodiscard]] std::size_t memory() const;
  /// Bytes of populations that this rank has sent to other ranks.
  [[nodiscard]] std::int64_t bytes_sent() const;

  /// Sets the populations of every own node to equilibrium plus the first-order non-equilibrium
  /// part of the state's gradient, w_i rho (-tau/c_s^2)(c c - c_s^2 1):grad u, less half of Guo's
  /// forcing term, as in a slowly varying flow. `state` is called with own nodes (i, j, k), and is
  /// symmetric where a mirror plane lies on them; time is reset to 0. Collective.
  void initialise(const std::function<NodeState(int, int, int)>& state);

  /// Replaces the boxes by these, which must be disjoint, inside domain() and hold the images of
  /// their nodes below a mirror plane; each rank keeps its part. Forces are zero until written.
  /// Every rank is given all boxes. Throws std::invalid_argument for a box that is not so.
  void place_boxes(std::span<const Box> boxes);
  [[nodiscard]] std::span<Patch> patches();

  /// Reads density and momentum (half of the uniform force in, eq. (6)) in all patches from the
  /// populations: for bodies that must know the velocity before they choose their force.
  /// Collective.
  void read_velocity();
  /// In all patches, velocity <- (momentum + force/2)/density.
  void update_velocity();

  /// One time step, eqs. (2)-(6), from t to t + 1: collides with the uniform force plus that of the
  /// patches, and streams. Leaves in the patches the velocity at t, half of the whole force in, and
  /// no force. Collective.
  void step();

  /// Density and velocity (half of the uniform force in) of the own slab: nx ny nz_own numbers,
  /// x, y, z with z fastest; velocity holds three such arrays, one a component. On the nodes of a
  /// regularized wall the velocity is the wall's, and the density the sum of the populations as
  /// they have arrived, before the wall's rule replaces them. Collective.
  void fields(std::span<double> density, std::span<double> velocity);
  /// Collective.
  Totals totals();

 private:
  friend void stream_only(Fluid& fluid);
  std::unique_ptr<FluidImpl> impl_;
};

}  // namespace ductile::fluid
