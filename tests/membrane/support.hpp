// What the membrane's tests share.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "ductile/membrane/shell.hpp"

namespace ductile::membrane::test {

using Points = std::vector<Eigen::Vector3d>;

inline VecPtr to_vec(const Points& points) {
  VecPtr vec = create_vec(static_cast<int>(points.size()));
  const VecArray<double> x(vec.get());
  for (std::size_t i = 0; i < points.size(); ++i) Eigen::Vector3d::Map(&x[3 * i]) = points[i];
  return vec;
}

inline Energies energies(const Shell& shell, const Points& points) {
  return shell.energies(to_vec(points).get());
}

inline Points forces(const Shell& shell, const Points& points) {
  const VecPtr force = shell.create_vec();
  shell.force(to_vec(points).get(), force.get());
  const VecArray<const double> f(force.get());
  Points result(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) result[i] = Eigen::Vector3d::Map(&f[3 * i]);
  return result;
}

inline Eigen::MatrixXd dense(Mat mat) {
  PetscInt rows = 0, columns = 0;
  petsc_check(MatGetSize(mat, &rows, &columns));
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(rows, columns);
  for (PetscInt row = 0; row < rows; ++row) {
    PetscInt count = 0;
    const PetscInt* column = nullptr;
    const double* value = nullptr;
    petsc_check(MatGetRow(mat, row, &count, &column, &value));
    for (PetscInt k = 0; k < count; ++k) result(row, column[k]) = value[k];
    petsc_check(MatRestoreRow(mat, row, &count, &column, &value));
  }
  return result;
}

inline Eigen::MatrixXd sparse_tangent(const Shell& shell, const Points& points) {
  const MatPtr k = shell.create_tangent();
  shell.tangent(to_vec(points).get(), k.get());
  return dense(k.get());
}

/// The whole Hessian, the volume's dense part included.
inline Eigen::MatrixXd whole_tangent(const Shell& shell, const Points& points) {
  const VecPtr gradient = shell.create_vec();
  const double c = shell.volume_stiffness(to_vec(points).get(), gradient.get());
  const VecArray<const double> array(gradient.get());
  const auto g = Eigen::VectorXd::Map(array.data(), static_cast<Eigen::Index>(array.size()));
  return sparse_tangent(shell, points) + c * g * g.transpose();
}

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

}  // namespace ductile::membrane::test
