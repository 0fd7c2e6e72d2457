// What the tests of surfaces and membranes share.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace ductile::surface::test {

using Points = std::vector<Eigen::Vector3d>;

/// Independent uniform numbers in [-size, size].
class Random {
 public:
  double operator()(double size = 1) {
    return std::uniform_real_distribution<double>(-size, size)(generator_);
  }
  Eigen::Vector3d vector(double size = 1) {
    const double x = (*this)(size), y = (*this)(size), z = (*this)(size);
    return {x, y, z};
  }
  Eigen::Matrix3d rotation() {
    Eigen::Vector4d q;
    for (double& c : q) c = (*this)();
    return Eigen::Quaterniond(q).normalized().toRotationMatrix();
  }

 private:
  std::mt19937 generator_{12345};
};

/// `points` with each coordinate moved by up to `size`.
inline Points perturbed(Points points, double size, Random& random) {
  for (Eigen::Vector3d& x : points) x += random.vector(size);
  return points;
}

inline Points moved(Points points, const Eigen::Matrix3d& map, const Eigen::Vector3d& shift) {
  for (Eigen::Vector3d& x : points) x = map * x + shift;
  return points;
}

/// Message of the invalid_argument that `action` throws.
template <class Action>
std::string refusal(Action&& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "(nothing thrown)";
}

inline void expect_contains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in '" << text << "'";
}

}  // namespace ductile::surface::test
