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
#include <string_view>
#include <vector>

#include "ductile/instruction_set.hpp"

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

/// The node of which node y is the image, and the other way round; `mirror` is not none.
constexpr int image(Mirror mirror, int y) {
  return mirror == Mirror::between_nodes ? -1 - y : -y;
}

enum class Collision {
  bgk,  ///< eq. (2)
  trt   ///< two relaxation times: odd moments relax so that (tau - 1/2)(tau_odd - 1/2) = magic
};

/// What the density is besides the pressure p = (rho - rho0)/3.
enum class Equilibrium {
  compressible,   ///< eq. (3): it multiplies the velocity; the momentum is rho u
  incompressible  ///< nothing: the momentum is rho0 u (He and Luo 1997)
};

enum class Precision { double_precision, single_precision };

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
  double magic = 3.0 / 16.0;  ///< TRT only
  Equilibrium equilibrium = Equilibrium::compressible;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< uniform body force density
  /// Of the lattice itself along z, at the start: see LatticeMotion. The velocities above, and all
  /// that the fluid is given and tells but for that, are those on the lattice.
  double lattice_velocity = 0;
  Precision storage = Precision::double_precision;  ///< of the populations
  /// Of the collision, and so of force, velocity and momentum in boxes, and of what Points spread
  /// and interpolate. Single needs populations stored in single precision. What is told of the
  /// fluid (fields(), totals(), flow()) is computed in double either way.
  Precision arithmetic = Precision::double_precision;
  /// The kernel runs on the widest that this machine has, unless one is given. Results do not
  /// depend on it.
  std::optional<InstructionSet> instruction_set;
};

/// Density, velocity and velocity gradient at a node; gradient(a, b) = du_b/dx_a.
struct NodeState {
  double density = 1;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
};

/// Integrals over the fluid's volume as sums over its nodes, the same to the last bit on any number
/// of ranks: nodes on a regularized wall count half, as the wall halves the cell around them, and a
/// quarter on the edge of two. With a mirror plane they are those of the half above it: nodes on
/// the plane count half.
struct Totals {
  /// of rho - 1; constant but for round-off, whatever the walls (doc/equations.md)
  double mass = 0;
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();  ///< half the uniform force in
  [[nodiscard]] bool finite() const;
};

/// How the lattice itself moves along z, in a frame at rest: node (i, j, k) is at z = k + position
/// there, and what moves with u on the lattice moves with u + velocity.
struct LatticeMotion {
  double position = 0;
  double velocity = 0;
  double acceleration = 0;  ///< gained in the step to come
};

/// Takes a named part of a state; the numbers are valid during the call alone.
using StateWriter = std::function<void(std::string_view name, std::span<const double> numbers)>;
/// Fills `numbers` with the part of that name, or throws if it has none of that size.
using StateReader = std::function<void(std::string_view name, std::span<double> numbers)>;

/// A range of planes or nodes, end excluded.
struct Range {
  int begin = 0;
  int end = 0;
  [[nodiscard]] int size() const { return end - begin; }
  bool operator==(const Range&) const = default;
};

/// A box of nodes. z may run outside [0, nz) where the axis is periodic, y below 0 where there is a
/// mirror plane.
using Box = std::array<Range, 3>;

class FluidImpl;

/// The fluid's populations and their evolution. Forces act and velocities are told at points
/// (points.hpp), in boxes of nodes placed around them; how nodes are kept in memory and shared
/// among ranks is the fluid's own affair. Every member marked collective is called by all ranks of
/// the communicator, in the same order.
class Fluid {
 public:
  /// Collective. Each rank holds an even share of the planes. The fluid is at rest.
  /// Throws std::invalid_argument, on every rank, if tau <= 1/2, magic <= 0, a number is not
  /// finite, an axis has fewer than 2 nodes (4 with walls on nodes), z is regularized, a wall
  /// velocity has a normal component, the lattice moves and z is not periodic, a mirror plane faces
  /// no wall, the force or a wall's velocity is not symmetric about it, there are more ranks than
  /// planes, arithmetic is single with double storage, or a given instruction set is not available
  /// on the machine of every rank.
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
  /// Nodes that points may reach: all but the walls' own, and with a mirror plane their images.
  [[nodiscard]] Box domain() const;
  /// Of the lattice, now. Its position is 0 at the start.
  [[nodiscard]] const LatticeMotion& motion() const;
  /// Lets the lattice gain the velocity `acceleration` in each step from now on. On the lattice
  /// that is a uniform force of the opposite sign, and walls, which go on as they did in the frame
  /// at rest, gain the opposite velocity. Velocities of the fluid that are told now have half of
  /// that force in, as LatticeMotion::velocity has the opposite half: u + velocity is as it was.
  /// Not collective, but called by all ranks alike. Throws std::invalid_argument if it is not
  /// finite, or z not periodic.
  void accelerate(double acceleration);
  /// Time steps done.
  [[nodiscard]] std::int64_t time() const;
  /// Bytes held by this rank: populations, messages, and force and velocity in the boxes.
  [[nodiscard]] std::size_t memory() const;
  /// Bytes of populations that this rank has sent to other ranks.
  [[nodiscard]] std::int64_t bytes_sent() const;

  /// Sets the populations of every own node to equilibrium plus the first-order non-equilibrium
  /// part of the state's gradient, w_i rho (-tau/c_s^2)(c c - c_s^2 1):grad u, less half of Guo's
  /// forcing term, as in a slowly varying flow. `state` is called with own nodes (i, j, k), and is
  /// symmetric where a mirror plane lies on them; time and the lattice's motion are what they were
  /// at the start. Boxes stay; force in them is dropped. Collective.
  void initialise(const std::function<NodeState(int, int, int)>& state);

  /// The box to place for points that reach the nodes of `reach`, which domain() holds and which is
  /// no longer than a periodic channel: with room for the points to move by a node or two, and
  /// with the images of its nodes below a mirror plane.
  [[nodiscard]] Box box_around(const Box& reach) const;
  /// Replaces the boxes in which points act, one for each body or group of points; they may
  /// overlap. Force in them is zero. Every rank is given all boxes and keeps what is its own. Not
  /// collective. Throws std::invalid_argument for a box that is not inside domain() or longer than
  /// a periodic channel.
  void place_boxes(std::span<const Box> boxes);
  /// Whether the rank holds any node of the box.
  [[nodiscard]] bool touches(int rank, const Box& box) const;
  /// points <- those of the positions, 3n numbers, that reach nodes of the rank, in their order,
  /// and split <- where in `points` those are of which that rank does not hold all nodes that they
  /// reach: what Points::whole() says there.
  void reached(int rank, std::span<const double> positions, std::vector<int>& points,
               std::vector<std::size_t>& split) const;

  /// Reads momentum (half of the uniform force in, eq. (6)) and, if it weighs anything, density in
  /// all boxes from the populations: for bodies that must know the velocity before they choose
  /// their force. Collective.
  void read_velocity();
  /// In all boxes, velocity <- (momentum + force/2)/density, or without the density where that is
  /// no part of the momentum.
  void update_velocity();

  /// One time step, eqs. (2)-(6), from t to t + 1: collides with the uniform force plus that of the
  /// points, and streams. Leaves in the boxes the velocity at t, half of the whole force in, and no
  /// force. Collective.
  void step();

  /// Density and velocity (half of the uniform force in) of the own slab: nx ny nz_own numbers,
  /// x, y, z with z fastest; velocity holds three such arrays, one a component. On the nodes of a
  /// regularized wall they are what the wall's rule makes them; on the edge of two the velocity is
  /// the mean of theirs along the edge. Collective.
  void fields(std::span<double> density, std::span<double> velocity);
  /// Collective.
  Totals totals();
  /// The integral of u_z (half of the uniform force in) over the fluid's volume, summed as Totals
  /// are: over the number of planes it is the flow rate, by the trapezoidal rule where walls lie on
  /// nodes, else by that of midpoints. Takes half as long as a step or more. Collective.
  double flow();
  /// Whether density and velocity are finite numbers, on every rank alike. Cheap, for looking
  /// often: only some nodes are looked at, but what is not finite spreads by a node in each step,
  /// so that eight steps after it began none is missed. Collective.
  bool finite();

  /// Writes all that determines the future but force that points have added since the last step.
  /// "time" is one number, "lattice" three, those of LatticeMotion; "f00" to "f18" are f_i - w_i of
  /// the own slab's nodes, as they are about to collide, of velocity d3q19::c(i): nx ny nz_own
  /// numbers, x, y, z with z fastest. A node's do not depend on how the slabs are cut. Collective.
  void save(const StateWriter& write);
  /// The state of a fluid with the same options but for the instruction set, on any number of
  /// ranks: from here on results are the same to the last bit as of the one that was saved.
  /// Populations are rounded if their storage is not that of the saved ones. Boxes stay; force in
  /// them is dropped. Collective. What the reader throws passes through; the fluid then holds parts
  /// of two states and must load or initialise() before it steps again.
  void load(const StateReader& read);

 private:
  friend struct Inside;
  std::unique_ptr<FluidImpl> impl_;
};

}  // namespace ductile::fluid
