// The collision of one row of nodes along z: all of the fluid's arithmetic.
#pragma once

#include <array>

#include "ductile/fluid/d3q19.hpp"

namespace ductile::fluid {

/// Where the populations of a row are, stored as f_i - w_i. Streaming is in place (the AA pattern,
/// Bailey et al. 2009): f_i of the pair (+e, -e) is read from `plus` and f_(-i) from `minus`, and
/// the collided ones change places. Which arrays those are is the row's business: its own in even
/// steps; its neighbours' in odd ones, or its own again where a half-way wall reflects.
template <class Real>
struct Row {
  Real* rest;
  std::array<Real*, d3q19::pairs> plus;
  std::array<Real*, d3q19::pairs> minus;
};

struct Relaxation {
  double omega_plus;   // of the even moments: 1/tau
  double omega_minus;  // of the odd ones
};

/// Force density: uniform, plus arrays over the row where they are not null.
struct RowForce {
  std::array<double, 3> uniform;
  std::array<const double*, 3> local;
};

/// A regularized wall on the row: which way its normal points into the fluid, in x and y (-1, 0, 1;
/// both at the duct's edges), and its velocity.
struct RowWall {
  std::array<int, 2> normal;
  std::array<double, 3> velocity;
};

/// Collides nodes [begin, end) of a row, eqs. (2)-(6).
template <class Real>
void collide(const Row<Real>& row, int begin, int end, const Relaxation& relaxation,
             const RowForce& force);

/// The same for a row on a regularized wall: the populations are first replaced by those of Latt et
/// al. 2008. Local forces are not read.
template <class Real>
void collide_wall(const Row<Real>& row, int begin, int end, const Relaxation& relaxation,
                  const RowForce& force, const RowWall& wall);

/// Density less one and momentum, without any force, of nodes [begin, end); on a wall row those of
/// the populations as they are.
template <class Real>
void moments(const Row<Real>& row, int begin, int end, double* density, double* x, double* y,
             double* z);

}  // namespace ductile::fluid
