// What the membrane's tests share.
#pragma once

#include <Eigen/Core>

#include "ductile/membrane/shell.hpp"
#include "ductile/surface/mesh.hpp"
#include "membrane/surface_support.hpp"

namespace ductile::membrane {
using surface::icosphere;
using surface::Mesh;
}  // namespace ductile::membrane

namespace ductile::membrane::test {

using namespace surface::test;

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

}  // namespace ductile::membrane::test
