#include "kernel.hpp"

#include <cmath>
#include <utility>

namespace ductile::fluid {
namespace {

using d3q19::pairs;

// Unrolls f over p = 0 .. 8 at compile time, so that the loop over nodes is the only one left to
// vectorise.
template <class F, int... P>
[[gnu::always_inline]] inline void for_pairs(F&& f, std::integer_sequence<int, P...> /*p*/) {
  (f(std::integral_constant<int, P>{}), ...);
}
template <class F>
[[gnu::always_inline]] inline void for_pairs(F&& f) {
  for_pairs(std::forward<F>(f), std::make_integer_sequence<int, pairs>{});
}

template <int P, int axis>
constexpr int e_of() {
  return d3q19::e[P][axis];
}

// e_P . (x, y, z)
template <int P>
[[gnu::always_inline]] inline double along(double x, double y, double z) {
  constexpr int ex = e_of<P, 0>();
  constexpr int ey = e_of<P, 1>();
  constexpr int ez = e_of<P, 2>();
  if constexpr (ex != 0 && ey != 0) {
    return ey > 0 ? x + y : x - y;
  } else if constexpr (ex != 0 && ez != 0) {
    return ez > 0 ? x + z : x - z;
  } else if constexpr (ey != 0 && ez != 0) {
    return ez > 0 ? y + z : y - z;
  } else {
    return ex != 0 ? x : (ey != 0 ? y : z);
  }
}

// sum += e value
template <int e>
[[gnu::always_inline]] inline void add(double& sum, double value) {
  if constexpr (e > 0) sum += value;
  if constexpr (e < 0) sum -= value;
}

// The populations of one node less their rest weights: sums t and differences d of each pair.
struct Node {
  double rest;
  double t[pairs];
  double d[pairs];
};

struct Moments {
  double density_less_one;
  double x;
  double y;
  double z;
};

[[gnu::always_inline]] inline Moments moments_of(const Node& node) {
  Moments m{node.rest, 0, 0, 0};
  for_pairs([&](auto p) __attribute__((always_inline)) {
    m.density_less_one += node.t[p];
    add<e_of<p, 0>()>(m.x, node.d[p]);
    add<e_of<p, 1>()>(m.y, node.d[p]);
    add<e_of<p, 2>()>(m.z, node.d[p]);
  });
  return m;
}

template <class Real>
[[gnu::always_inline]] inline Node load(const Row<Real>& row, int k) {
  Node node;  // NOLINT(cppcoreguidelines-pro-type-member-init): every member is set below
  node.rest = static_cast<double>(row.rest[k]);
  for_pairs([&](auto p) __attribute__((always_inline)) {
    const auto plus = static_cast<double>(row.plus[p][k]);
    const auto minus = static_cast<double>(row.minus[p][k]);
    node.t[p] = plus + minus;
    node.d[p] = plus - minus;
  });
  return node;
}

// Relaxes a node of velocity u and density 1 + drho towards equilibrium, eqs. (2)-(4), and writes
// its populations back, those of each pair exchanged. With t = f_i + f_-i, d = f_i - f_-i:
//   t* = (1 - w+) t + 2 w_i [w+ (drho - 3/2 rho u.u + 9/2 rho (c.u)^2) + g+ (9 (c.u)(c.F) - 3 u.F)]
//   d* = (1 - w-) d + 2 w_i [3 w- rho c.u + 3 g- c.F],                        g = 1 - w/2
template <class Real>
[[gnu::always_inline]] inline void relax(const Row<Real>& row, int k, const Node& node,
                                         const Relaxation& relaxation, double drho, double ux,
                                         double uy, double uz, double fx, double fy, double fz) {
  const double wp = relaxation.omega_plus;
  const double wm = relaxation.omega_minus;
  const double gp = 1 - 0.5 * wp;
  const double gm = 1 - 0.5 * wm;
  const double rho = 1 + drho;
  const double common = wp * (drho - 1.5 * rho * (ux * ux + uy * uy + uz * uz)) -
                        3 * gp * (ux * fx + uy * fy + uz * fz);
  const double even = 4.5 * wp * rho;
  const double rx = even * ux + 9 * gp * fx;
  const double ry = even * uy + 9 * gp * fy;
  const double rz = even * uz + 9 * gp * fz;
  const double odd = 3 * wm * rho;
  const double qx = odd * ux + 3 * gm * fx;
  const double qy = odd * uy + 3 * gm * fy;
  const double qz = odd * uz + 3 * gm * fz;

  row.rest[k] = static_cast<Real>((1 - wp) * node.rest + d3q19::w(0) * common);
  for_pairs([&](auto p) __attribute__((always_inline)) {
    constexpr double w = d3q19::w(d3q19::plus(p));
    const double cu = along<p>(ux, uy, uz);
    const double t = 0.5 * (1 - wp) * node.t[p] + w * (common + cu * along<p>(rx, ry, rz));
    const double d = 0.5 * (1 - wm) * node.d[p] + w * along<p>(qx, qy, qz);
    row.minus[p][k] = static_cast<Real>(t + d);
    row.plus[p][k] = static_cast<Real>(t - d);
  });
}

template <class Real, bool local_force>
void collide_row(Row<Real> row, int begin, int end, Relaxation relaxation, RowForce force) {
#pragma GCC ivdep
  for (int k = begin; k < end; ++k) {
    double fx = force.uniform[0];
    double fy = force.uniform[1];
    double fz = force.uniform[2];
    if constexpr (local_force) {
      fx += force.local[0][k];
      fy += force.local[1][k];
      fz += force.local[2][k];
    }
    const Node node = load(row, k);
    const Moments m = moments_of(node);
    const double inverse = 1 / (1 + m.density_less_one);
    relax(row, k, node, relaxation, m.density_less_one, (m.x + 0.5 * fx) * inverse,
          (m.y + 0.5 * fy) * inverse, (m.z + 0.5 * fz) * inverse, fx, fy, fz);
  }
}

// How the population with e.n = `sign` of a pair stands to a wall of normal (nx, ny): true if it
// comes out of the wall in x or in y, and so is unknown.
template <int P, int sign, int nx, int ny>
constexpr bool leaves_wall() {
  return sign * e_of<P, 0>() * nx > 0 || sign * e_of<P, 1>() * ny > 0;
}

// Sum over the known populations of the equilibrium at unit density and wall velocity.
template <int nx, int ny>
double known_equilibrium(const std::array<double, 3>& u) {
  double sum = d3q19::w(0) * (1 - 1.5 * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]));
  for_pairs([&](auto p) {
    const double cu = along<p>(u[0], u[1], u[2]);
    const double even = 1 + 4.5 * cu * cu - 1.5 * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    const double w = d3q19::w(d3q19::plus(p));
    if constexpr (!leaves_wall<p, 1, nx, ny>()) sum += w * (even + 3 * cu);
    if constexpr (!leaves_wall<p, -1, nx, ny>()) sum += w * (even - 3 * cu);
  });
  return sum;
}

// Latt et al. 2008. On a face the density follows from the known populations and the wall's
// velocity; the unknown ones take the non-equilibrium part of their opposites; then all are rebuilt
// from density, velocity and the non-equilibrium stress. On an edge of the duct both walls hold the
// fluid, so that the velocity gradient vanishes, and with it that stress: the populations are the
// equilibrium's, and the known ones give the density.
// Half of Guo's forcing term is taken off, as in the bulk, so that the velocity of eq. (6) is the
// wall's.
template <class Real, int nx, int ny>
void collide_wall_row(Row<Real> row, int begin, int end, Relaxation relaxation, RowForce force,
                      RowWall wall) {
  constexpr bool edge = nx != 0 && ny != 0;
  const double ux = wall.velocity[0];
  const double uy = wall.velocity[1];
  const double uz = wall.velocity[2];
  const double fx = force.uniform[0];
  const double fy = force.uniform[1];
  const double fz = force.uniform[2];
  const double uu = 1.5 * (ux * ux + uy * uy + uz * uz);
  const double edge_norm = edge ? 1 / known_equilibrium<nx, ny>(wall.velocity) : 0;
  const double known_weight = edge ? known_equilibrium<nx, ny>({0, 0, 0}) : 0;
#pragma GCC ivdep
  for (int k = begin; k < end; ++k) {
    const auto rest = static_cast<double>(row.rest[k]);
    double drho = 0;
    double pxx = 0;
    double pyy = 0;
    double pzz = 0;
    double pxy = 0;
    double pxz = 0;
    double pyz = 0;
    if constexpr (edge) {
      double known = rest;
      for_pairs([&](auto p) __attribute__((always_inline)) {
        if constexpr (!leaves_wall<p, 1, nx, ny>()) known += static_cast<double>(row.plus[p][k]);
        if constexpr (!leaves_wall<p, -1, nx, ny>()) known += static_cast<double>(row.minus[p][k]);
      });
      drho = (known + known_weight) * edge_norm - 1;
    } else {
      // rho = sum_parallel f + 2 sum_towards f - F.n/2, with u.n = 0
      drho = rest - 0.5 * (nx * fx + ny * fy);
      for_pairs([&](auto p) __attribute__((always_inline)) {
        constexpr bool plus_out = leaves_wall<p, 1, nx, ny>();
        constexpr bool minus_out = leaves_wall<p, -1, nx, ny>();
        if constexpr (plus_out) {
          drho += 2 * static_cast<double>(row.minus[p][k]);
        } else if constexpr (minus_out) {
          drho += 2 * static_cast<double>(row.plus[p][k]);
        } else {
          drho += static_cast<double>(row.plus[p][k]) + static_cast<double>(row.minus[p][k]);
        }
      });
      const double rho = 1 + drho;
      for_pairs([&](auto p) __attribute__((always_inline)) {
        constexpr double w = d3q19::w(d3q19::plus(p));
        constexpr bool plus_out = leaves_wall<p, 1, nx, ny>();
        constexpr bool minus_out = leaves_wall<p, -1, nx, ny>();
        const double cu = along<p>(ux, uy, uz);
        const double even = w * (drho + rho * (4.5 * cu * cu - uu));
        const double odd = w * rho * 3 * cu;
        double t = 0;  // non-equilibrium of both populations of the pair
        if constexpr (plus_out) {
          t = 2 * (static_cast<double>(row.minus[p][k]) - (even - odd));
        } else if constexpr (minus_out) {
          t = 2 * (static_cast<double>(row.plus[p][k]) - (even + odd));
        } else {
          t = static_cast<double>(row.plus[p][k]) + static_cast<double>(row.minus[p][k]) - 2 * even;
        }
        constexpr int ex = e_of<p, 0>();
        constexpr int ey = e_of<p, 1>();
        constexpr int ez = e_of<p, 2>();
        add<ex * ex>(pxx, t);
        add<ey * ey>(pyy, t);
        add<ez * ez>(pzz, t);
        add<ex * ey>(pxy, t);
        add<ex * ez>(pxz, t);
        add<ey * ez>(pyz, t);
      });
    }
    const double rho = 1 + drho;
    const double trace = (pxx + pyy + pzz) / 3;
    Node node;  // NOLINT(cppcoreguidelines-pro-type-member-init): every member is set below
    node.rest = d3q19::w(0) * (drho - rho * uu - 4.5 * trace);
    for_pairs([&](auto p) __attribute__((always_inline)) {
      constexpr double w = d3q19::w(d3q19::plus(p));
      constexpr int ex = e_of<p, 0>();
      constexpr int ey = e_of<p, 1>();
      constexpr int ez = e_of<p, 2>();
      double q = -trace;  // (e e - 1/3):Pi
      add<ex * ex>(q, pxx);
      add<ey * ey>(q, pyy);
      add<ez * ez>(q, pzz);
      add<ex * ey>(q, 2 * pxy);
      add<ex * ez>(q, 2 * pxz);
      add<ey * ez>(q, 2 * pyz);
      const double cu = along<p>(ux, uy, uz);
      node.t[p] = 2 * w * (drho + rho * (4.5 * cu * cu - uu) + 4.5 * q);
      node.d[p] = 2 * w * 3 * (rho * cu - 0.5 * along<p>(fx, fy, fz));
    });
    relax(row, k, node, relaxation, drho, ux, uy, uz, fx, fy, fz);
  }
}

}  // namespace

template <class Real>
void collide(const Row<Real>& row, int begin, int end, const Relaxation& relaxation,
             const RowForce& force) {
  if (force.local[0] != nullptr) {
    collide_row<Real, true>(row, begin, end, relaxation, force);
  } else {
    collide_row<Real, false>(row, begin, end, relaxation, force);
  }
}

template <class Real>
void collide_wall(const Row<Real>& row, int begin, int end, const Relaxation& relaxation,
                  const RowForce& force, const RowWall& wall) {
  const auto run = [&](auto nx, auto ny) {
    collide_wall_row<Real, nx, ny>(row, begin, end, relaxation, force, wall);
  };
  const auto with_y = [&](auto nx) {
    if (wall.normal[1] < 0) {
      run(nx, std::integral_constant<int, -1>{});
    } else if (wall.normal[1] > 0) {
      run(nx, std::integral_constant<int, 1>{});
    } else if constexpr (nx != 0) {
      run(nx, std::integral_constant<int, 0>{});
    }
  };
  if (wall.normal[0] < 0) {
    with_y(std::integral_constant<int, -1>{});
  } else if (wall.normal[0] > 0) {
    with_y(std::integral_constant<int, 1>{});
  } else {
    with_y(std::integral_constant<int, 0>{});
  }
}

template <class Real>
void moments(const Row<Real>& row, int begin, int end, double* density, double* x, double* y,
             double* z) {
#pragma GCC ivdep
  for (int k = begin; k < end; ++k) {
    const Moments m = moments_of(load(row, k));
    density[k] = m.density_less_one;
    x[k] = m.x;
    y[k] = m.y;
    z[k] = m.z;
  }
}

template void collide(const Row<double>&, int, int, const Relaxation&, const RowForce&);
template void collide(const Row<float>&, int, int, const Relaxation&, const RowForce&);
template void collide_wall(const Row<double>&, int, int, const Relaxation&, const RowForce&,
                           const RowWall&);
template void collide_wall(const Row<float>&, int, int, const Relaxation&, const RowForce&,
                           const RowWall&);
template void moments(const Row<double>&, int, int, double*, double*, double*, double*);
template void moments(const Row<float>&, int, int, double*, double*, double*, double*);

}  // namespace ductile::fluid
