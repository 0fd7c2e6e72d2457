// The collision of one row of nodes along z: all of the fluid's arithmetic.
#pragma once

#include "ductile/fluid/d3q19.hpp"
#include "ductile/instruction_set.hpp"

namespace ductile::fluid {

/// Where the populations of a row are, stored as f_i - w_i. Streaming is in place (the AA pattern,
/// Bailey et al. 2009): f_i of the pair (+e, -e) is read from `plus` and f_(-i) from `minus`, and
/// the collided ones change places. Which arrays those are is the row's business: its own in even
/// steps; its neighbours' in odd ones, or its own again where a half-way wall reflects.
template <class Real>
struct Row {
  Real* rest;
  Real* plus[d3q19::pairs];
  Real* minus[d3q19::pairs];
};

struct Relaxation {
  double omega_plus;   // of the even moments: 1/tau
  double omega_minus;  // of the odd ones
};

/// Force density: uniform, plus arrays over the row where they are not null. Where there are such,
/// the velocity goes to other arrays over the row. T is what the collision computes in.
template <class T>
struct RowForce {
  double uniform[3];
  const T* local[3];
  T* velocity[3];
};

/// A regularized wall on the row: which way its normal points into the fluid, in x and y (-1, 0, 1;
/// both at the duct's edges), and its velocity, which has no component along the normals.
struct RowWall {
  int normal[2];
  double velocity[3];
};

/// The operations on nodes [begin, end) of a row, for one instruction set and a collision that
/// computes in T; what is only looked at is computed in double. A node's result is the
/// same to the last bit with any set, and wherever the node stands in the row.
template <class Real, class T>
struct Kernel {
  /// Collision, eqs. (2)-(6).
  void (*collide)(const Row<Real>& row, int begin, int end, const Relaxation& relaxation,
                  const RowForce<T>& force);
  /// The same on a regularized wall: the populations are first replaced by those of Latt et al.
  /// 2008. Local forces are not read.
  void (*collide_wall)(const Row<Real>& row, int begin, int end, const Relaxation& relaxation,
                       const RowForce<T>& force, const RowWall& wall);
  /// Density less one on a regularized wall, of the populations that collide_wall() will make.
  void (*wall_density)(const Row<Real>& row, int begin, int end, const double* uniform_force,
                       const RowWall& wall, double* density);
  /// Density less one and momentum, without any force; not for rows on a regularized wall.
  void (*moments)(const Row<Real>& row, int begin, int end, double* density, double* x, double* y,
                  double* z);
  /// Momentum with half of the uniform force in it and, if it weighs anything, density, in T: what
  /// the collision divides. Not for rows on a regularized wall.
  void (*momentum)(const Row<Real>& row, int begin, int end, const RowForce<T>& force, T* density,
                   T* x, T* y, T* z);
  /// sum[k] += share u_z, given half of the force along z; as moments().
  void (*add_flow)(const Row<Real>& row, int begin, int end, double half_force, double share,
                   double* sum);
  /// The loads and stores of a collision without the collision: populations change places.
  void (*stream)(const Row<Real>& row, int begin, int end);
};

/// kernel.cpp, compiled once for each of them.
namespace baseline {
template <class Real, class T>
const Kernel<Real, T>& kernel(bool compressible);
}
namespace avx2 {
template <class Real, class T>
const Kernel<Real, T>& kernel(bool compressible);
}
namespace avx512 {
template <class Real, class T>
const Kernel<Real, T>& kernel(bool compressible);
}

/// Of populations stored as Real, whose collision computes in T, with the one or the other
/// Equilibrium. `set` must be available.
template <class Real, class T>
const Kernel<Real, T>& kernel(InstructionSet set, bool compressible);

}  // namespace ductile::fluid
