// What is known of the bodies at one instant, in the paper's units: a table of quantities, and the
// numbers that it gives.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "ductile/membrane/capsule.hpp"
#include "ductile/rigid/body.hpp"
#include "ductile/suspension/plan.hpp"

namespace ductile::suspension {

/// A body as the quantities see it, on the rank that owns it; lattice units.
struct Observation {
  const Units& units;
  const BodyPlan& plan;
  Eigen::Vector3d centroid;  ///< of the volume; z is not wrapped
  /// Of the centroid in the latest step; before the first the velocity with which the body starts:
  /// the initial flow's on its surface, 0 of a rigid body that is not as dense as the fluid.
  Eigen::Vector3d displacement;
  /// In the latest step, or with which the body starts. Of a capsule that of the rigid motion which
  /// comes nearest to the velocities of its vertices: least squares, weighted with their areas.
  Eigen::Vector3d angular_velocity;
  double slip = 0;                             ///< largest of surface minus fluid velocity
  const membrane::Capsule* capsule = nullptr;  ///< null unless it is one
  membrane::Shape moments{};                   ///< of the capsule's surface
  /// The capsule's vertex that starts furthest along z and nearest to the plane across y through
  /// its centre: of all the one with the largest z - |y - y_centre|.
  Eigen::Vector3d marker = Eigen::Vector3d::Zero();
  const rigid::Body* rigid = nullptr;  ///< null unless it is one
};

/// A number that is recorded of bodies.
struct Quantity {
  enum class Of { every_body, capsules, rigid_bodies };
  std::string_view name;  ///< the column NAME_name[unit] of trajectory.csv
  std::string_view unit;
  Of of;
  double (*get)(const Observation&);  ///< in that unit

  [[nodiscard]] bool applies(bool capsule) const {
    return of == Of::every_body || (of == Of::capsules) == capsule;
  }
};

/// All of them. A new one is a row of this table, in quantities.cpp, and nothing else.
std::span<const Quantity> quantities();
/// The first so many are position and velocity.
constexpr std::size_t motion_quantities = 6;

/// The numbers of one body.
struct BodySample {
  bool capsule = false;
  /// In the order of quantities(); 0 where the quantity does not apply to the body.
  std::vector<double> values = std::vector<double>(quantities().size());

  /// The number of that name. Throws std::out_of_range if quantities() has none.
  [[nodiscard]] double operator[](std::string_view name) const;
  [[nodiscard]] double& operator[](std::string_view name);
  [[nodiscard]] Eigen::Vector3d position() const { return Eigen::Vector3d::Map(values.data()); }
  [[nodiscard]] Eigen::Vector3d velocity() const { return Eigen::Vector3d::Map(&values[3]); }
};

/// The numbers of an observed body.
BodySample sample(const Observation& body);

/// All bodies at `time` [W^2/nu], in the order of Plan::bodies. In a pair the first is the leading
/// one.
struct Sample {
  double time = 0;
  std::vector<BodySample> bodies;
  /// Integral of u_z over the channel's cross-section, its mean over z [nu W]: the trapezoidal rule
  /// where walls lie on nodes, else that of midpoints, both of second order. u is that of
  /// Suspension::fields(); what a mirror plane leaves out is counted.
  double flow_rate = 0;
  /// Of more than two bodies distances_ahead() [W], else nothing.
  std::vector<double> ahead{};
  /// The largest Mach number on the lattice as it moves now: Plan::mach() or a body's.
  double mach = 0;
};

/// From each body to the next one ahead along z, in a channel that repeats after `length`: not
/// negative, and all together the length. Of bodies at the same z the later one in the list is
/// ahead.
std::vector<double> distances_ahead(std::span<const double> z, double length);

/// Axial distance of a pair, z_lead - z_lag [W]: negative once the two have swapped places.
inline double axial_distance(const Sample& sample) {
  return sample.bodies.at(0).position().z() - sample.bodies.at(1).position().z();
}

}  // namespace ductile::suspension
