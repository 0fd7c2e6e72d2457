// Compiled once for each instruction set, under the namespace DUCTILE_INSTRUCTION_SET. What is
// below is in an unnamed namespace, and nothing of the standard library is called: an inline
// function with external linkage might be linked from here into code for a lesser machine.
#include "kernel.hpp"

#ifdef __AVX__
#include <immintrin.h>
#endif

namespace ductile::fluid {
namespace {

using d3q19::pairs;

#if defined(__AVX512F__)
constexpr int widest = 8;
#elif defined(__AVX__)
constexpr int widest = 4;
#else
constexpr int widest = 2;
#endif

// N numbers side by side, a plain number for N = 1. Arithmetic is that of the numbers.
template <class T, int N>
struct LanesOf {
  using type [[gnu::vector_size(N * sizeof(T))]] = T;
};
template <class T>
struct LanesOf<T, 1> {
  using type = T;
};
template <int N>
using Lanes = typename LanesOf<double, N>::type;

template <int N, class Stored>
[[gnu::always_inline]] inline Lanes<N> widen(Stored values) {
  if constexpr (N == 1) {
    return static_cast<double>(values);
  } else {
    // g++ 12 makes __builtin_convertvector of four or eight single numbers in pieces.
    if constexpr (sizeof(Stored) == N * sizeof(float)) {
#ifdef __AVX512F__
      if constexpr (N == 8) return _mm512_maskz_cvtps_pd(0xff, values);
#endif
#ifdef __AVX__
      if constexpr (N == 4) return _mm256_cvtps_pd(values);
#endif
    }
    return __builtin_convertvector(values, Lanes<N>);
  }
}

template <int N, class Real>
[[gnu::always_inline]] inline Lanes<N> load(const Real* from) {
  typename LanesOf<Real, N>::type values;
  __builtin_memcpy(&values, from, sizeof values);
  return widen<N>(values);
}

template <int N, class Real>
[[gnu::always_inline]] inline void store(Real* to, Lanes<N> value) {
  using Stored = typename LanesOf<Real, N>::type;
  Stored values;
  if constexpr (N == 1) {
    values = static_cast<Real>(value);
  } else {
    values = __builtin_convertvector(value, Stored);
  }
  __builtin_memcpy(to, &values, sizeof values);
}

template <int N>
[[gnu::always_inline]] inline Lanes<N> all(double value) {
  return value - Lanes<N>{};
}

// a + b and a - b by the units that multiply and add, a product with one being exact: the same to
// the last bit. The kernel has many more sums than products, and where a processor has separate
// units for the two this shares out the work.
template <int N>
[[gnu::always_inline]] inline Lanes<N> plus(Lanes<N> a, Lanes<N> b) {
#ifdef __FMA__
#ifdef __AVX512F__
  if constexpr (N == 8) return _mm512_fmadd_pd(a, _mm512_set1_pd(1), b);
#endif
  if constexpr (N == 4) return _mm256_fmadd_pd(a, _mm256_set1_pd(1), b);
#endif
  return a + b;
}
template <int N>
[[gnu::always_inline]] inline Lanes<N> minus(Lanes<N> a, Lanes<N> b) {
#ifdef __FMA__
#ifdef __AVX512F__
  if constexpr (N == 8) return _mm512_fnmadd_pd(b, _mm512_set1_pd(1), a);
#endif
  if constexpr (N == 4) return _mm256_fnmadd_pd(b, _mm256_set1_pd(1), a);
#endif
  return a - b;
}

// Unrolls f over the pairs p = 0 .. 8 at compile time.
template <int p = 0, class F>
[[gnu::always_inline]] inline void for_pairs(F&& f) {
  if constexpr (p < pairs) {
    f.template operator()<p>();
    for_pairs<p + 1>(f);
  }
}

template <int p>
constexpr int ex = d3q19::e[p][0];
template <int p>
constexpr int ey = d3q19::e[p][1];
template <int p>
constexpr int ez = d3q19::e[p][2];
// w_i of a pair
template <int p>
constexpr double weight = d3q19::w(2 * p + 1);

// sum += e value
template <int e, class T>
[[gnu::always_inline]] inline void add(T& sum, T value) {
  if constexpr (e > 0) sum += value;
  if constexpr (e < 0) sum -= value;
}

// e_p . (x, y, z)
template <int p, class T>
[[gnu::always_inline]] inline T along(T x, T y, T z) {
  if constexpr (ex<p> != 0 && ey<p> != 0) {
    return ey<p> > 0 ? x + y : x - y;
  } else if constexpr (ex<p> != 0 && ez<p> != 0) {
    return ez<p> > 0 ? x + z : x - z;
  } else if constexpr (ey<p> != 0 && ez<p> != 0) {
    return ez<p> > 0 ? y + z : y - z;
  } else {
    return ex<p> != 0 ? x : (ey<p> != 0 ? y : z);
  }
}

// The populations of N nodes less their rest weights: sums t and differences d of each pair.
template <int N>
struct Nodes {
  Lanes<N> rest;
  Lanes<N> t[pairs];
  Lanes<N> d[pairs];
};

template <int N, class Real>
[[gnu::always_inline]] inline Nodes<N> load_nodes(const Row<Real>& row, int k) {
  Nodes<N> nodes;  // NOLINT(cppcoreguidelines-pro-type-member-init): every member is set below
  nodes.rest = load<N>(row.rest + k);
  for_pairs([&]<int p>() __attribute__((always_inline)) {
    const Lanes<N> f = load<N>(row.plus[p] + k);
    const Lanes<N> opposite = load<N>(row.minus[p] + k);
    nodes.t[p] = plus<N>(f, opposite);
    nodes.d[p] = minus<N>(f, opposite);
  });
  return nodes;
}

template <int N>
struct Moments {
  Lanes<N> density_less_one;
  Lanes<N> x;
  Lanes<N> y;
  Lanes<N> z;
};

// The pairs in the order of d3q19::e: x y z xy x-y xz x-z yz y-z. Short chains of additions.
template <int N>
[[gnu::always_inline]] inline Moments<N> moments_of(const Nodes<N>& nodes) {
  const auto& t = nodes.t;
  const auto& d = nodes.d;
  Moments<N> m;  // NOLINT(cppcoreguidelines-pro-type-member-init): every member is set below
  m.density_less_one =
      (((t[3] + t[4]) + (t[5] + t[6])) + ((t[7] + t[8]) + (t[0] + t[1]))) + (t[2] + nodes.rest);
  m.x = ((d[3] + d[4]) + (d[5] + d[6])) + d[0];
  m.y = ((d[3] - d[4]) + (d[7] + d[8])) + d[1];
  m.z = ((d[5] - d[6]) + (d[7] - d[8])) + d[2];
  return m;
}

template <int N>
struct Vector {
  Lanes<N> x;
  Lanes<N> y;
  Lanes<N> z;
};

// Relaxes nodes of density 1 + drho, velocity u and momentum j = rho u towards equilibrium under
// the force F, eqs. (2)-(4), and writes their populations back, those of each pair exchanged. With
// t = f_i + f_-i, d = f_i - f_-i:
//   t* = (1 - w+) t + 2 w_i [w+ (drho - 3/2 u.j + 9/2 (c.u)(c.j)) + g+ (9 (c.u)(c.F) - 3 u.F)]
//   d* = (1 - w-) d + 2 w_i [3 w- c.j + 3 g- c.F],                        g = 1 - w/2
// r = 9/2 w+ j + 9 g+ F and q = 3 w- j + 3 g- F turn this into
//   t* = (1 - w+) t + 2 w_i [w+ drho - u.r/3 + (c.u)(c.r)],   d* = (1 - w-) d + 2 w_i c.q.
// Both are scaled by 1/36, the weight of the diagonals.
template <int N, class Real>
[[gnu::always_inline]] inline void relax(const Row<Real>& row, int k, const Nodes<N>& nodes,
                                         const Relaxation& relaxation, Lanes<N> drho,
                                         const Vector<N>& u, const Vector<N>& j,
                                         const Vector<N>& force) {
  constexpr double w = 1.0 / 36;
  static_assert(d3q19::w(7) == w);
  const double wp = relaxation.omega_plus;
  const double wm = relaxation.omega_minus;
  const auto combine = [](double a, const Vector<N>& x, double b, const Vector<N>& y)
      __attribute__((always_inline)) {
    return Vector<N>{a * x.x + b * y.x, a * x.y + b * y.y, a * x.z + b * y.z};
  };
  const Vector<N> r = combine(w * 4.5 * wp, j, w * 9 * (1 - 0.5 * wp), force);
  const Vector<N> q = combine(w * 3 * wm, j, w * 3 * (1 - 0.5 * wm), force);

  const Lanes<N> xx = u.x * r.x;
  const Lanes<N> yy = u.y * r.y;
  const Lanes<N> zz = u.z * r.z;
  const Lanes<N> xy = u.x * r.y + u.y * r.x;
  const Lanes<N> xz = u.x * r.z + u.z * r.x;
  const Lanes<N> yz = u.y * r.z + u.z * r.y;
  const Lanes<N> ur = (xx + yy) + zz;
  const Lanes<N> s = (w * wp) * drho - (1.0 / 3) * ur;

  const double keep_even = 0.5 * (1 - wp);
  const double keep_odd = 0.5 * (1 - wm);
  store<N>(row.rest + k, (1 - wp) * nodes.rest + 12.0 * s);
  const auto put = [&]<int p>(Lanes<N> even, Lanes<N> odd) __attribute__((always_inline)) {
    const Lanes<N> t = keep_even * nodes.t[p] + even;
    const Lanes<N> d = keep_odd * nodes.d[p] + odd;
    store<N>(row.minus[p] + k, plus<N>(t, d));
    store<N>(row.plus[p] + k, t - d);
  };
  put.template operator()<0>(2.0 * (s + xx), 2.0 * q.x);
  put.template operator()<1>(2.0 * (s + yy), 2.0 * q.y);
  put.template operator()<2>(2.0 * (s + zz), 2.0 * q.z);
  const Lanes<N> s_all = s + ur;
  const Lanes<N> s_xy = s_all - zz;
  put.template operator()<3>(s_xy + xy, q.x + q.y);
  put.template operator()<4>(s_xy - xy, q.x - q.y);
  const Lanes<N> s_xz = s_all - yy;
  put.template operator()<5>(s_xz + xz, q.x + q.z);
  put.template operator()<6>(s_xz - xz, q.x - q.z);
  const Lanes<N> s_yz = s_all - xx;
  put.template operator()<7>(s_yz + yz, q.y + q.z);
  put.template operator()<8>(s_yz - yz, q.y - q.z);
}

template <int N>
[[gnu::always_inline]] inline Vector<N> load_vector(const double* const* from, int k) {
  return {load<N>(from[0] + k), load<N>(from[1] + k), load<N>(from[2] + k)};
}
template <int N>
[[gnu::always_inline]] inline void store_vector(double* const* to, int k, const Vector<N>& v) {
  store<N>(to[0] + k, v.x);
  store<N>(to[1] + k, v.y);
  store<N>(to[2] + k, v.z);
}

template <bool local, int N>
[[gnu::always_inline]] inline Vector<N> force_at(const RowForce& force, int k) {
  Vector<N> f = {all<N>(force.uniform[0]), all<N>(force.uniform[1]), all<N>(force.uniform[2])};
  if constexpr (local) {
    const Vector<N> more = load_vector<N>(force.local, k);
    f = {f.x + more.x, f.y + more.y, f.z + more.z};
  }
  return f;
}

// Of the population along `sign` e_p that arrives at a wall of normal (nx, ny), in x and in y:
// (1 - c.n_x)(1 - c.n_y), how often a wall's density counts it. 0 for those that would come out of
// the wall and are unknown, 1 for those along it; from the fluid 2, at the edge of two walls 4.
template <int p, int sign, int nx, int ny>
constexpr int counted = (1 - sign * nx * ex<p>)*(1 - sign * ny * ey<p>);

// Latt et al. 2008. The density follows from the known populations, so that no mass passes the wall
// (doc/equations.md). On a face the unknown ones take the non-equilibrium part of their opposites;
// then all are rebuilt from density, velocity and the non-equilibrium stress. On an edge of the
// duct both walls hold the fluid, so that the velocity gradient vanishes, and with it that stress:
// the populations are the equilibrium's.
// Half of Guo's forcing term is taken off, as in the bulk, so that the velocity of eq. (6) is the
// wall's.
template <int nx, int ny>
struct WallRule {
  static constexpr bool edge = nx != 0 && ny != 0;
  double u[3];
  double f[3];

  WallRule(const RowForce& force, const RowWall& wall)
      : u{wall.velocity[0], wall.velocity[1], wall.velocity[2]},
        f{force.uniform[0], force.uniform[1], force.uniform[2]} {}

  template <int N>
  struct Known {
    Lanes<N> rest;
    Lanes<N> plus[pairs];
    Lanes<N> minus[pairs];
  };

  template <int N, class Real>
  [[gnu::always_inline]] static Known<N> load_known(const Row<Real>& row, int k) {
    Known<N> known;  // NOLINT(cppcoreguidelines-pro-type-member-init): the unknown are not read
    known.rest = load<N>(row.rest + k);
    for_pairs([&]<int p>() __attribute__((always_inline)) {
      if constexpr (counted<p, 1, nx, ny> != 0) known.plus[p] = load<N>(row.plus[p] + k);
      if constexpr (counted<p, -1, nx, ny> != 0) known.minus[p] = load<N>(row.minus[p] + k);
    });
    return known;
  }

  // rho = sum_known (1 - c.n_x)(1 - c.n_y) f - F.(n_x + n_y)/2, with u.n = 0 for either wall. Both
  // of a pair are known only if they run along the wall, and then each counts once.
  template <int N>
  [[gnu::always_inline]] Lanes<N> density_less_one(const Known<N>& known) const {
    Lanes<N> drho = known.rest - 0.5 * (nx * f[0] + ny * f[1]);
    for_pairs([&]<int p>() __attribute__((always_inline)) {
      constexpr int a = counted<p, 1, nx, ny>;
      constexpr int b = counted<p, -1, nx, ny>;
      if constexpr (a > 0 && b > 0) {
        drho += known.plus[p] + known.minus[p];
      } else if constexpr (a > 0) {
        drho += double{a} * known.plus[p];
      } else if constexpr (b > 0) {
        drho += double{b} * known.minus[p];
      }
    });
    return drho;
  }

  template <int N, class Real>
  [[gnu::always_inline]] void collide_nodes(const Row<Real>& row, int k,
                                            const Relaxation& relaxation) const {
    Nodes<N> nodes;  // NOLINT(cppcoreguidelines-pro-type-member-init): every member is set below
    const Known<N> known = load_known<N>(row, k);
    const double uu = 1.5 * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    const Lanes<N> drho = density_less_one<N>(known);
    const Lanes<N> rho = 1.0 + drho;
    Lanes<N> pxx{};
    Lanes<N> pyy{};
    Lanes<N> pzz{};
    Lanes<N> pxy{};
    Lanes<N> pxz{};
    Lanes<N> pyz{};
    if constexpr (!edge) {
      for_pairs([&]<int p>() __attribute__((always_inline)) {
        const double cu = along<p>(u[0], u[1], u[2]);
        const Lanes<N> even = weight<p> * (drho + rho * (4.5 * cu * cu - uu));
        const Lanes<N> odd = (weight<p> * 3 * cu) * rho;
        Lanes<N> t;  // non-equilibrium of both populations of the pair
        if constexpr (counted<p, 1, nx, ny> == 0) {
          t = 2.0 * (known.minus[p] - (even - odd));
        } else if constexpr (counted<p, -1, nx, ny> == 0) {
          t = 2.0 * (known.plus[p] - (even + odd));
        } else {
          t = (known.plus[p] + known.minus[p]) - 2.0 * even;
        }
        add<ex<p> * ex<p>>(pxx, t);
        add<ey<p> * ey<p>>(pyy, t);
        add<ez<p> * ez<p>>(pzz, t);
        add<ex<p> * ey<p>>(pxy, t);
        add<ex<p> * ez<p>>(pxz, t);
        add<ey<p> * ez<p>>(pyz, t);
      });
    }
    const Lanes<N> trace = (pxx + pyy + pzz) * (1.0 / 3);
    nodes.rest = d3q19::w(0) * (drho - rho * uu - 4.5 * trace);
    for_pairs([&]<int p>() __attribute__((always_inline)) {
      Lanes<N> q = -trace;  // (e e - 1/3):Pi
      add<ex<p> * ex<p>>(q, pxx);
      add<ey<p> * ey<p>>(q, pyy);
      add<ez<p> * ez<p>>(q, pzz);
      add<ex<p> * ey<p>>(q, 2.0 * pxy);
      add<ex<p> * ez<p>>(q, 2.0 * pxz);
      add<ey<p> * ez<p>>(q, 2.0 * pyz);
      const double cu = along<p>(u[0], u[1], u[2]);
      nodes.t[p] = (2 * weight<p>)*(drho + rho * (4.5 * cu * cu - uu) + 4.5 * q);
      nodes.d[p] = (6 * weight<p>)*(rho * cu - 0.5 * along<p>(f[0], f[1], f[2]));
    });
    relax<N>(row, k, nodes, relaxation, drho, {all<N>(u[0]), all<N>(u[1]), all<N>(u[2])},
             {rho * u[0], rho * u[1], rho * u[2]}, {all<N>(f[0]), all<N>(f[1]), all<N>(f[2])});
  }
};

constexpr int cache_line = 64;
// How far ahead of their use populations are fetched into the second-level cache, in bytes along
// each of the nineteen arrays. Rows follow each other in memory, so that this reaches over their
// ends. The first-level cache has too few misses under way at a time to be fetched into from so
// far.
constexpr int ahead = 1024;

template <class Real>
[[gnu::always_inline]] inline void prefetch(const Row<Real>& row, int k) {
  const auto fetch = [&](const Real* p) __attribute__((always_inline)) {
    __builtin_prefetch(reinterpret_cast<const char*>(p + k) + ahead, 0, 2);
  };
  fetch(row.rest);
  for_pairs([&]<int p>() __attribute__((always_inline)) {
    fetch(row.plus[p]);
    fetch(row.minus[p]);
  });
}

// Calls f<N>(k) for nodes [begin, end), N at a time: the widest vectors, then ever narrower ones
// for what remains.
template <int N = widest, class F>
[[gnu::always_inline]] inline void for_nodes(int begin, int end, F&& f) {
  int k = begin;
#pragma GCC unroll 1
  for (; k + N <= end; k += N) f.template operator()<N>(k);
  if constexpr (N > 1) {
    if (k < end) for_nodes<N / 2>(k, end, f);
  }
}

// The same with each array fetched ahead, once a cache line.
template <class Real, class F>
[[gnu::always_inline]] inline void for_nodes_ahead(const Row<Real>& row, int begin, int end,
                                                   F&& f) {
  constexpr int line = cache_line / sizeof(Real);
  int k = begin;
  for (; k + line <= end; k += line) {
    prefetch(row, k);
#pragma GCC unroll 1
    for (int j = 0; j < line; j += widest) f.template operator()<widest>(k + j);
  }
  if (k < end) {
    prefetch(row, k);
    for_nodes(k, end, f);
  }
}

// Rows are taken by value here, so that the compiler sees that no store changes where they are.
template <bool local, class Real>
void collide_row(Row<Real> row, int begin, int end, Relaxation relaxation, RowForce force) {
  for_nodes_ahead(
      row, begin, end, [&]<int N>(int k) __attribute__((always_inline)) {
        const Vector<N> f = force_at<local, N>(force, k);
        const Nodes<N> nodes = load_nodes<N>(row, k);
        const Moments<N> m = moments_of<N>(nodes);
        const Lanes<N> inverse = 1.0 / (1.0 + m.density_less_one);
        const Vector<N> j = {m.x + 0.5 * f.x, m.y + 0.5 * f.y, m.z + 0.5 * f.z};
        const Vector<N> u = {j.x * inverse, j.y * inverse, j.z * inverse};
        if constexpr (local) store_vector<N>(force.velocity, k, u);
        relax<N>(row, k, nodes, relaxation, m.density_less_one, u, j, f);
      });
}

template <class Real>
void collide(const Row<Real>& row, int begin, int end, const Relaxation& relaxation,
             const RowForce& force) {
  if (force.local[0] != nullptr) {
    collide_row<true>(row, begin, end, relaxation, force);
  } else {
    collide_row<false>(row, begin, end, relaxation, force);
  }
}

// Calls f<nx, ny>() with the wall's normal.
template <class F>
void for_wall(const RowWall& wall, F&& f) {
  const auto with_y = [&]<int nx>() {
    if (wall.normal[1] < 0) {
      f.template operator()<nx, -1>();
    } else if (wall.normal[1] > 0) {
      f.template operator()<nx, 1>();
    } else if constexpr (nx != 0) {
      f.template operator()<nx, 0>();
    }
  };
  if (wall.normal[0] < 0) {
    with_y.template operator()<-1>();
  } else if (wall.normal[0] > 0) {
    with_y.template operator()<1>();
  } else {
    with_y.template operator()<0>();
  }
}

template <int nx, int ny, class Real>
void collide_wall_row(Row<Real> row, int begin, int end, Relaxation relaxation,
                      const RowForce& force, const RowWall& wall) {
  const WallRule<nx, ny> rule(force, wall);
  for_nodes_ahead(
      row, begin, end, [&]<int N>(int k) __attribute__((always_inline)) {
        rule.template collide_nodes<N>(row, k, relaxation);
      });
}

template <class Real>
void collide_wall(const Row<Real>& row, int begin, int end, const Relaxation& relaxation,
                  const RowForce& force, const RowWall& wall) {
  for_wall(wall, [&]<int nx, int ny>() {
    collide_wall_row<nx, ny>(row, begin, end, relaxation, force, wall);
  });
}

template <int nx, int ny, class Real>
void wall_density_row(Row<Real> row, int begin, int end, const RowForce& force, const RowWall& wall,
                      double* density) {
  const WallRule<nx, ny> rule(force, wall);
  for_nodes_ahead(
      row, begin, end, [&]<int N>(int k) __attribute__((always_inline)) {
        store<N>(density + k,
                 rule.template density_less_one<N>(rule.template load_known<N>(row, k)));
      });
}

template <class Real>
void wall_density(const Row<Real>& row, int begin, int end, const RowForce& force,
                  const RowWall& wall, double* density) {
  for_wall(wall, [&]<int nx, int ny>() {
    wall_density_row<nx, ny>(row, begin, end, force, wall, density);
  });
}

template <class Real>
void moments(const Row<Real>& row, int begin, int end, double* density, double* x, double* y,
             double* z) {
  for_nodes_ahead(
      row, begin, end, [&]<int N>(int k) __attribute__((always_inline)) {
        const Moments<N> m = moments_of<N>(load_nodes<N>(row, k));
        store<N>(density + k, m.density_less_one);
        store<N>(x + k, m.x);
        store<N>(y + k, m.y);
        store<N>(z + k, m.z);
      });
}

template <class Real>
void add_flow(const Row<Real>& row, int begin, int end, double half_force, double share,
              double* sum) {
  for_nodes_ahead(
      row, begin, end, [&]<int N>(int k) __attribute__((always_inline)) {
        const Moments<N> m = moments_of<N>(load_nodes<N>(row, k));
        const Lanes<N> u = (m.z + half_force) / (1.0 + m.density_less_one);
        store<N>(sum + k, load<N>(sum + k) + share * u);
      });
}

template <class Real>
void stream_row(Row<Real> row, int begin, int end) {
  for_nodes_ahead(
      row, begin, end, [&]<int N>(int k) __attribute__((always_inline)) {
        using Values = typename LanesOf<Real, N>::type;
        const auto swap = [&](Real * a, Real * b) __attribute__((always_inline)) {
          Values x;
          Values y;
          __builtin_memcpy(&x, a + k, sizeof x);
          __builtin_memcpy(&y, b + k, sizeof y);
          __builtin_memcpy(a + k, &y, sizeof y);
          __builtin_memcpy(b + k, &x, sizeof x);
        };
        Values rest;
        __builtin_memcpy(&rest, row.rest + k, sizeof rest);
        rest = -rest;
        __builtin_memcpy(row.rest + k, &rest, sizeof rest);
        for_pairs([&]<int p>() __attribute__((always_inline)) { swap(row.plus[p], row.minus[p]); });
      });
}

template <class Real>
void stream(const Row<Real>& row, int begin, int end) {
  stream_row(row, begin, end);
}

}  // namespace

namespace DUCTILE_INSTRUCTION_SET {

template <class Real>
const Kernel<Real>& kernel() {
  static constexpr Kernel<Real> functions = {collide<Real>, collide_wall<Real>, wall_density<Real>,
                                             moments<Real>, add_flow<Real>,     stream<Real>};
  return functions;
}
template const Kernel<double>& kernel();
template const Kernel<float>& kernel();

}  // namespace DUCTILE_INSTRUCTION_SET

}  // namespace ductile::fluid
