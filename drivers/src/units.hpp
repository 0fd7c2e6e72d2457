// From the paper's units to the lattice's (dx = dt = rho0 = 1) and back.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "ductile/membrane/shell.hpp"
#include "scenario.hpp"

namespace ductile::drivers {

/// A body in lattice units. `moduli` counts for capsules alone.
struct BodySetup {
  double radius = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  int frequency = 0;  ///< of the mesh: 20 n^2 triangles, 10 n^2 + 2 markers
  membrane::Moduli moduli;
};

/// What a scenario is in lattice units.
///
/// Node (i, j, k) sits at (i, j, k). The channel's axis is at x = (nx - 1)/2, y = (ny - 1)/2, but
/// see below; the
/// scenario's z = 0 is at nz/2. Half-way walls lie at -1/2 and N - 1/2, so that 2W = N; regularized
/// ones on nodes 0 and N - 1, so that 2W = N - 1.
///
/// Of a channel symmetric about y = 0 the nodes at y >= 0 are kept, and counted from there: the
/// axis is at y = -1/2 or 0, as the whole channel has an even or an odd number of nodes along y.
struct LatticeSetup {
  std::array<int, 3> nodes{};  ///< nx, ny, nz
  fluid::Mirror mirror = fluid::Mirror::none;
  double half_width = 0;    ///< W
  double half_width_y = 0;  ///< in lattice spacings, as the whole nodes make it
  double length = 0;        ///< nz
  double tau = 0;
  double nu = 0;                          ///< (tau - 1/2)/3
  double u_max = 0;                       ///< of the empty channel: Re = 2 W U_max/nu
  double alpha = 0;                       ///< body force density along z, eq. (1)
  std::array<double, 2> wall_velocity{};  ///< along z, at x = -W and +W
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  double steps_per_time = 0;      ///< W^2/nu
  std::int64_t total_steps = 0;   ///< until run.time_limit
  std::vector<BodySetup> bodies;  ///< in the order of Scenario::bodies

  [[nodiscard]] std::int64_t node_count() const;
  /// Where the scenario's origin is.
  [[nodiscard]] Eigen::Vector3d origin() const;
  /// Largest imposed velocity over the speed of sound 1/sqrt(3).
  [[nodiscard]] double mach() const;
  /// Time in W^2/nu after so many steps.
  [[nodiscard]] double time(std::int64_t steps) const {
    return static_cast<double>(steps) / steps_per_time;
  }
  /// The number of steps nearest to an interval in W^2/nu, at least 1; 0 for an interval of 0.
  [[nodiscard]] std::int64_t steps(double interval) const;
  /// Lattice coordinates of a point given in W from the axis and the middle of the channel, and
  /// back.
  [[nodiscard]] Eigen::Vector3d to_lattice(const Eigen::Vector3d& position) const;
  [[nodiscard]] Eigen::Vector3d position(const Eigen::Vector3d& lattice) const;
  /// Lattice velocity to nu/W.
  [[nodiscard]] Eigen::Vector3d velocity(const Eigen::Vector3d& lattice) const {
    return lattice * (half_width / nu);
  }
};

/// W in lattice spacings for a number of nodes across.
double half_width(int nodes, fluid::Boundary walls);

/// U_max/(alpha W^2/eta) of the empty channel: 0.29468541 for the square duct, 1/2 between two
/// plates (no side walls). `half_width_y` in W.
double poiseuille_coefficient(double half_width_y, bool side_walls);

constexpr double paper_volume_modulus = 75000;  ///< rho nu^2/W^2

/// The volume modulus used where the scenario names none, in rho nu^2/W^2: the paper's 75000, or
/// where that is above 1.5 in lattice units, what 1.5 comes to, rounded down to three digits. The
/// explicit scheme bears more, unless the capsule or tau is small (stability.hpp).
double default_volume_modulus(double half_width, double nu);

/// Throws ScenarioError if the Mach number is above 0.3.
LatticeSetup lattice_setup(const Scenario& scenario);

}  // namespace ductile::drivers
