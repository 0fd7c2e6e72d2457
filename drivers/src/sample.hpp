// What the output side is told about the run at one instant.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace ductile::drivers {

/// State of one body, non-dimensional as in the paper.
struct BodySample {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< volume centroid [W]; z is not wrapped
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< of the centroid [nu/W]
  double slip = 0;           ///< largest of surface minus fluid velocity [nu/W]
  bool capsule = false;      ///< whether the three numbers below mean anything
  double deformation = 0;    ///< Taylor's D
  double volume_error = 0;   ///< (V - V0)/V0
  double strain_energy = 0;  ///< E_s/(k_s a^2)
};

/// State of all bodies at `time` [W^2/nu]. In a pair the first is the leading one.
struct Sample {
  double time = 0;
  std::vector<BodySample> bodies;
};

/// Axial distance of a pair, z_lead - z_lag [W]: negative once the two have swapped places.
inline double axial_distance(const Sample& sample) {
  return sample.bodies.at(0).position.z() - sample.bodies.at(1).position.z();
}

}  // namespace ductile::drivers
