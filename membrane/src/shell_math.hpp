// What the shell's sources share.
#pragma once

#include <petscvec.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "ductile/membrane/petsc.hpp"
#include "ductile/membrane/shell.hpp"

namespace ductile::membrane {

inline Eigen::Vector3d point(const double* x, int vertex) {
  return Eigen::Vector3d::Map(x + 3 * static_cast<std::ptrdiff_t>(vertex));
}

/// Strain energy density and its derivatives with respect to I1 and I2; the mixed second one is 0
/// in both laws.
struct Density {
  double w, w1, w2, w11, w22;
};

inline Density strain_density(const Moduli& k, double i1, double i2) {
  if (k.law == StrainLaw::skalak) {
    return {k.k_s / 12 * (i1 * i1 + 2 * i1 - 2 * i2) + k.k_a / 12 * i2 * i2, k.k_s / 6 * (i1 + 1),
            (k.k_a * i2 - k.k_s) / 6, k.k_s / 6, k.k_a / 6};
  }
  const double inverse = 1 / (i2 + 1);
  return {k.k_s / 6 * (i1 - 1 + inverse), k.k_s / 6, -k.k_s / 6 * inverse * inverse, 0,
          k.k_s / 3 * inverse * inverse * inverse};
}

/// Throws std::invalid_argument unless `vec` has three numbers for each vertex.
template <class T>
VecArray<T> array_of(Vec vec, int vertex_count) {
  PetscInt size = 0;
  petsc_check(VecGetLocalSize(vec, &size));
  if (size != 3 * vertex_count) {
    throw std::invalid_argument("shell: a vector of " + std::to_string(size) + " numbers for " +
                                std::to_string(vertex_count) + " vertices");
  }
  return VecArray<T>(vec);
}

inline Shell::Angle Shell::angle(const Hinge& hinge, const double* x) const {
  const Eigen::Vector3d& left = normals_[hinge.left];
  const Eigen::Vector3d& right = normals_[hinge.right];
  const Eigen::Vector3d edge = point(x, hinge.head) - point(x, hinge.tail);
  const double scale = inverse_norms_[hinge.left] * inverse_norms_[hinge.right];
  const double inverse_length = 1 / std::sqrt(edge.squaredNorm());
  return {left.dot(right) * scale, left.cross(right).dot(edge) * (scale * inverse_length),
          inverse_length};
}

}  // namespace ductile::membrane
