// Developed laminar flow in a rectangular duct.
#pragma once

#include <Eigen/Core>
#include <array>

namespace ductile::fluid {

/// Flow along z in the duct |x| <= half_width[0], |y| <= half_width[1], driven by the uniform force
/// density `force` (the paper's alpha) in a fluid of dynamic viscosity `viscosity`: eq. (1),
/// written for the series to run along x or y, whichever converges faster. Any consistent units.
class DuctFlow {
 public:
  /// Throws std::invalid_argument unless both half-widths and the viscosity are positive.
  DuctFlow(std::array<double, 2> half_width, double force, double viscosity);

  /// Axial velocity at (x, y); 0 on and outside the walls.
  [[nodiscard]] double velocity(double x, double y) const;
  /// (du/dx, du/dy) at (x, y) inside.
  [[nodiscard]] Eigen::Vector2d gradient(double x, double y) const;
  /// Velocity on the axis.
  [[nodiscard]] double maximum() const { return velocity(0, 0); }
  /// Mean velocity over the cross-section.
  [[nodiscard]] double mean() const;

 private:
  std::array<double, 2> half_width_;
  double scale_;  // force/viscosity
};

}  // namespace ductile::fluid
