// A plan: all that a coupled system of fluid and bodies needs, in lattice units (dx = dt = rho0 =
// 1). Whoever has a plan can put the system together, judge its stability and estimate its cost
// without knowing where the plan came from.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "ductile/fluid/duct.hpp"
#include "ductile/fluid/fluid.hpp"
#include "ductile/membrane/integrator.hpp"
#include "ductile/membrane/shell.hpp"
#include "ductile/rigid/lubrication.hpp"
#include "ductile/surface/mesh.hpp"
#include "ductile/surface/shape.hpp"
#include "ductile/suspension/units.hpp"

namespace ductile::suspension {

/// What makes a body a capsule.
struct CapsulePlan {
  membrane::Moduli moduli;  ///< of the membrane where it is computed
  double mobility = 1e-3;   ///< in dx/eta, see membrane::CapsuleOptions
  double retraction = 0;    ///< how far inside of the surface the membrane is computed
  membrane::Scheme integrator = membrane::reference_scheme();
  membrane::IntegratorOptions integrator_options;
};

/// What fills the surface of a rigid body.
enum class Interior {
  fluid,  ///< fluid that the surface alone moves: markers on the surface
  solid   ///< fluid that moves with the body: inner shells of markers too, rigid::lined()
};

/// What makes a body a rigid one.
struct RigidPlan {
  double density_ratio = 1;
  int corrections = 5;    ///< iterations of multi-direct forcing
  double memory = 0;      ///< see rigid::Options
  double retraction = 0;  ///< how far inside of the surface the markers lie
  Interior interior = Interior::fluid;
  double slip = 0;  ///< along the surface: rigid::Surface::missed, in dx/eta
  double roughness = rigid::usual_roughness;  ///< in radii, of spheres that touch, see has_films()
};

struct BodyPlan {
  std::string name;
  std::shared_ptr<const surface::Shape> shape;  ///< in its own frame
  int frequency = 0;                            ///< of its mesh: 20 n^2 triangles
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  std::variant<CapsulePlan, RigidPlan> kind;

  /// Null unless the body is of that kind.
  [[nodiscard]] const CapsulePlan* capsule() const { return std::get_if<CapsulePlan>(&kind); }
  [[nodiscard]] const RigidPlan* rigid() const { return std::get_if<RigidPlan>(&kind); }
  /// How far inside of the surface the markers lie.
  [[nodiscard]] double retraction() const {
    return std::visit([](const auto& plan) { return plan.retraction; }, kind);
  }
  /// Its surface in its own frame, on which output is drawn.
  [[nodiscard]] surface::Mesh mesh() const { return shape->mesh(frequency); }
  /// That of its markers: a capsule's membrane, a rigid body's without those inside.
  [[nodiscard]] surface::Mesh marker_mesh() const { return shape->mesh(frequency, -retraction()); }
  /// k_s r^2 of the membrane, the unit of a capsule's energies: r is less than the radius by the
  /// retraction. 0 of any other body.
  [[nodiscard]] double energy_unit() const {
    const CapsulePlan* plan = capsule();
    const double radius = shape->radius() - retraction();
    return plan == nullptr ? 0 : plan->moduli.k_s * radius * radius;
  }
};

/// The flow at t = 0: as in the channel without bodies, or none.
enum class Start { developed, rest };

/// Node (i, j, k) sits at (i, j, k). Half-way walls lie at -1/2 and N - 1/2, so that 2W = N;
/// regularized ones on nodes 0 and N - 1, so that 2W = N - 1. The channel's axis is at x = (nx -
/// 1)/2, y = (ny - 1)/2, and z = 0 of the paper at nz/2. With a mirror plane the nodes at y >= 0
/// are kept, and counted from there: the axis is at y = -1/2 or 0.
struct Plan {
  fluid::Options fluid;
  Start start = Start::developed;
  /// Largest velocity of the empty channel; fluid.force drives it. See drive().
  double u_max = 0;
  /// Whether the lattice goes on to move with the bodies: it follows the mean of their velocities.
  /// All in a plan but fluid.wall_velocity, and all that a suspension tells but where the nodes of
  /// fields() are, is in the frame at rest.
  bool follow = false;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< on the excess mass of rigid bodies
  std::vector<BodyPlan> bodies;
  Units units;

  /// The units of a channel with this fluid: W and the origin from the box, nu from tau.
  static Units channel_units(const fluid::Options& fluid);
  /// Sets u_max and the driving force along z so that Re = 2 W u_max/nu, for a channel that is
  /// empty and developed: eq. (1), or plane Poiseuille flow where y is periodic. Needs fluid and
  /// units.
  void drive(double reynolds);
  /// Lets the lattice move along z from the start: fluid.lattice_velocity <- velocity, and the
  /// walls' velocities on the lattice are less by that. Truncation errors that grow with the
  /// velocity on the lattice then vanish where the fluid moves as the lattice does
  /// (doc/equations.md, "Galilean invariance"). Needs fluid; may be called again.
  void ride(double velocity);

  /// Throws std::invalid_argument, naming the value, if the plan contradicts itself: units of
  /// another fluid, a developed flow where none is known, a body without a shape, names that are
  /// empty or taken, or a body with films (has_films()) that is not on the mirror plane. What the
  /// solvers refuse is theirs to say.
  void check() const;

  [[nodiscard]] bool side_walls() const { return fluid.boundary[1] != fluid::Boundary::periodic; }
  /// Half of the channel's width along y in lattice spacings, on both sides of a mirror plane.
  [[nodiscard]] double half_width_y() const;
  [[nodiscard]] double length() const { return fluid.nodes[2]; }
  /// Velocities along z of the walls at x = -W and x = W, in the frame at rest.
  [[nodiscard]] std::array<double, 2> wall_velocity() const {
    return {fluid.wall_velocity[0][0].z() + fluid.lattice_velocity,
            fluid.wall_velocity[0][1].z() + fluid.lattice_velocity};
  }
  [[nodiscard]] std::int64_t node_count() const;
  /// Largest imposed velocity over the speed of sound 1/sqrt(3), on a lattice with this velocity
  /// or, by default, that of the start.
  [[nodiscard]] double mach(double lattice_velocity) const;
  [[nodiscard]] double mach() const { return mach(fluid.lattice_velocity); }
};

/// W in lattice spacings for a number of nodes across.
double half_width(int nodes, fluid::Boundary walls);

/// U_max/(alpha W^2/eta) of the empty channel: 0.29468541 for the square duct, 1/2 between two
/// plates (no side walls). `half_width_y` in W.
double poiseuille_coefficient(double half_width_y, bool side_walls);

/// Whether the body takes part in films: a rigid sphere with slip, not lighter than the fluid. What
/// the lattice does not resolve of the flow between two such comes from lubrication theory
/// (rigid::Lubrication).
bool has_films(const BodyPlan& body);

/// The flow of a plan at t = 0, which is the same all along z.
class InitialFlow {
 public:
  /// Of a plan that passes check(), without its bodies.
  explicit InitialFlow(const Plan& plan);
  /// At (x, y) of the lattice, inside of the walls or on them, in the frame at rest.
  [[nodiscard]] fluid::NodeState at(double x, double y) const;

 private:
  std::array<double, 2> half_width_;
  Eigen::Vector3d axis_;
  double force_over_viscosity_;
  std::array<double, 2> wall_velocity_;
  bool side_walls_;
  std::optional<fluid::DuctFlow> duct_;  // none at rest
};

/// The rank that each body belongs to: as even a share of the bodies as there is for every rank, in
/// the order of their centres along the periodic channel, so that a body starts near the planes of
/// its rank and few of its markers have to be sent.
std::vector<int> owners(const Plan& plan, int ranks);

/// The fluid of a plan in its initial state. Collective. Throws as fluid::Fluid.
fluid::Fluid make_fluid(const Plan& plan, MPI_Comm comm);

}  // namespace ductile::suspension
