// The paper's units and the lattice's (dx = dt = rho0 = 1): each conversion, written once.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ductile::suspension {

/// nu of a fluid of relaxation time tau.
inline double lattice_viscosity(double tau) {
  return (tau - 0.5) / 3;
}

/// In the paper lengths are in W, half the channel's width along x, times in W^2/nu, velocities in
/// nu/W, angular velocities in nu/W^2, flow rates in nu W, forces in rho nu^2, torques in rho nu^2
/// W and pressures in rho nu^2/W^2; positions are taken from the channel's axis and the middle of
/// its length. A function called lattice_... takes a number in the paper's unit and gives it in
/// lattice units; one without that prefix goes the other way. Energies are counted in k_s a^2 of
/// the capsule that has them (BodyPlan::energy_unit).
class Units {
 public:
  Units() = default;
  /// W in lattice spacings, nu in lattice units, and the lattice coordinates of the paper's origin.
  Units(double half_width, double viscosity, const Eigen::Vector3d& origin)
      : W_(half_width), nu_(viscosity), origin_(origin) {}

  [[nodiscard]] double half_width() const { return W_; }
  [[nodiscard]] double viscosity() const { return nu_; }
  [[nodiscard]] const Eigen::Vector3d& origin() const { return origin_; }

  [[nodiscard]] double lattice_length(double length) const { return length * W_; }
  [[nodiscard]] double length(double lattice) const { return lattice / W_; }
  [[nodiscard]] Eigen::Vector3d lattice_position(const Eigen::Vector3d& position) const {
    return position * W_ + origin_;
  }
  [[nodiscard]] Eigen::Vector3d position(const Eigen::Vector3d& lattice) const {
    return (lattice - origin_) / W_;
  }

  /// Steps in a unit of time, W^2/nu.
  [[nodiscard]] double steps_per_time() const { return W_ * W_ / nu_; }
  /// The number of steps nearest to an interval, at least 1; 0 for an interval of 0.
  [[nodiscard]] std::int64_t lattice_steps(double interval) const {
    return interval > 0 ? std::max<std::int64_t>(1, std::llround(interval * steps_per_time())) : 0;
  }
  [[nodiscard]] double time(std::int64_t steps) const {
    return static_cast<double>(steps) / steps_per_time();
  }

  [[nodiscard]] double lattice_velocity(double velocity) const { return velocity * (nu_ / W_); }
  [[nodiscard]] double velocity(double lattice) const { return lattice * (W_ / nu_); }
  [[nodiscard]] Eigen::Vector3d velocity(const Eigen::Vector3d& lattice) const {
    return lattice * (W_ / nu_);
  }

  [[nodiscard]] Eigen::Vector3d angular_velocity(const Eigen::Vector3d& lattice) const {
    return lattice * (W_ * W_ / nu_);
  }
  /// Of a volume per time.
  [[nodiscard]] double flow_rate(double lattice) const { return lattice * (1 / (nu_ * W_)); }

  [[nodiscard]] Eigen::Vector3d lattice_acceleration(const Eigen::Vector3d& acceleration) const {
    return acceleration * (nu_ * nu_ / (W_ * W_ * W_));
  }

  [[nodiscard]] double force(double lattice) const { return lattice * (1 / (nu_ * nu_)); }
  [[nodiscard]] double torque(double lattice) const { return lattice * (1 / (nu_ * nu_ * W_)); }
  [[nodiscard]] double lattice_pressure(double pressure) const {
    return pressure * nu_ * nu_ / (W_ * W_);
  }

  [[nodiscard]] double pressure(double lattice) const { return lattice * W_ * W_ / (nu_ * nu_); }

  /// k_s of a capsule of `radius` a in lattice spacings: La = k_s a/(rho nu^2), eq. (19).
  [[nodiscard]] double lattice_shear_modulus(double laplace, double radius) const {
    return laplace * nu_ * nu_ / radius;
  }

 private:
  double W_ = 1;
  double nu_ = 1;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
};

}  // namespace ductile::suspension
