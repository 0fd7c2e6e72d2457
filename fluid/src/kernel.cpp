// Compiled once for each instruction set, under the namespace DUCTILE_INSTRUCTION_SET. What is
// below is in an unnamed namespace, and nothing of the standard library is called: an inline
// function with external linkage might be linked from here into code for a lesser machine.
#include "kernel.hpp"

#include <cstddef>
#include <type_traits>
#include <utility>

#ifdef __AVX__
#include <immintrin.h>
#endif

namespace ductile::fluid {
namespace {

using d3q19::pairs;

// N numbers side by side, a plain number for N = 1. Arithmetic is that of the numbers.
template <class T, int N>
struct LanesOf {
  using type [[gnu::vector_size(N * sizeof(T))]] = T;
};
template <class T>
struct LanesOf<T, 1> {
  using type = T;
};
template <class T, int N>
using Lanes = typename LanesOf<T, N>::type;

// What the lanes V are made of, and how many they are.
template <class V>
struct Of {
  using Number = std::remove_cvref_t<decltype(std::declval<V&>()[0])>;
};
template <>
struct Of<float> {
  using Number = float;
};
template <>
struct Of<double> {
  using Number = double;
};
template <class V>
using Number = typename Of<V>::Number;
template <class V>
constexpr int count = sizeof(V) / sizeof(Number<V>);

constexpr int register_bytes =
#if defined(__AVX512F__)
    64;
#elif defined(__AVX__)
    32;
#else
    16;
#endif
// The most numbers of a kind that the processor computes at a time.
template <class T>
constexpr int widest = register_bytes / sizeof(T);

// As many numbers of another precision, exact or rounded to nearest.
template <class To, class From>
[[gnu::always_inline]] inline To convert(From values) {
  if constexpr (sizeof(To) == sizeof(From)) {
    return values;
  } else if constexpr (count<To> == 1) {
    return static_cast<To>(values);
  } else {
    // g++ 12 makes __builtin_convertvector of these in pieces.
#ifdef __AVX512F__
    if constexpr (sizeof(From) == 32 && sizeof(To) == 64)
      return _mm512_maskz_cvtps_pd(0xff, values);
    if constexpr (sizeof(From) == 64 && sizeof(To) == 32)
      return _mm512_maskz_cvtpd_ps(0xff, values);
#endif
#ifdef __AVX__
    if constexpr (sizeof(From) == 16 && sizeof(To) == 32) return _mm256_cvtps_pd(values);
    if constexpr (sizeof(From) == 32 && sizeof(To) == 16) return _mm256_cvtpd_ps(values);
#endif
    return __builtin_convertvector(values, To);
  }
}

template <class V>
using Half = Lanes<Number<V>, count<V> / 2>;

template <class V, std::size_t... k>
[[gnu::always_inline]] inline V joined(Half<V> low, Half<V> high, std::index_sequence<k...>) {
  if constexpr (count<V> == 2) {
    return V{low, high};
  } else {
    return __builtin_shufflevector(low, high, k...);
  }
}
template <int from, class V, std::size_t... k>
[[gnu::always_inline]] inline Half<V> part(V value, std::index_sequence<k...>) {
  if constexpr (count<V> == 2) {
    return value[from];
  } else {
    return __builtin_shufflevector(value, value, (from + k)...);
  }
}

// Which of a vector's numbers are in memory: all, or some of them, the first first. The others are
// zero when loaded and not stored.
struct All {
  template <int n>
  [[nodiscard, gnu::always_inline]] All low() const {
    return {};
  }
  template <int n>
  [[nodiscard, gnu::always_inline]] All high() const {
    return {};
  }
};
struct First {
  unsigned bits;  // of each number one, the first the lowest
  [[gnu::always_inline]] static First of(int n) { return {(1U << static_cast<unsigned>(n)) - 1U}; }
  // Those among the first n, and after them.
  template <int n>
  [[nodiscard, gnu::always_inline]] First low() const {
    return {bits & ((1U << n) - 1U)};
  }
  template <int n>
  [[nodiscard, gnu::always_inline]] First high() const {
    return {bits >> n};
  }
};

template <class L>
[[gnu::always_inline]] inline L load_some(const Number<L>* from, All /*which*/) {
  L values;
  __builtin_memcpy(&values, from, sizeof values);
  return values;
}
template <class L>
[[gnu::always_inline]] inline void store_some(Number<L>* to, L values, All /*which*/) {
  __builtin_memcpy(to, &values, sizeof values);
}

#ifdef __AVX512F__
// A row's last vector then takes no longer than any other.
constexpr bool loads_some = true;
template <class L>
[[gnu::always_inline]] inline L load_some(const Number<L>* from, First which) {
  constexpr bool single = sizeof(Number<L>) == sizeof(float);
  if constexpr (sizeof(L) == 64 && single) {
    return _mm512_maskz_loadu_ps(static_cast<__mmask16>(which.bits), from);
  } else if constexpr (sizeof(L) == 64) {
    return _mm512_maskz_loadu_pd(static_cast<__mmask8>(which.bits), from);
  } else {
    static_assert(sizeof(L) == 32 && single);
    return _mm256_maskz_loadu_ps(static_cast<__mmask8>(which.bits), from);
  }
}
template <class L>
[[gnu::always_inline]] inline void store_some(Number<L>* to, L values, First which) {
  constexpr bool single = sizeof(Number<L>) == sizeof(float);
  if constexpr (sizeof(L) == 64 && single) {
    _mm512_mask_storeu_ps(to, static_cast<__mmask16>(which.bits), values);
  } else if constexpr (sizeof(L) == 64) {
    _mm512_mask_storeu_pd(to, static_cast<__mmask8>(which.bits), values);
  } else {
    static_assert(sizeof(L) == 32 && single);
    _mm256_mask_storeu_ps(to, static_cast<__mmask8>(which.bits), values);
  }
}
#else
constexpr bool loads_some = false;
#endif

// Numbers that fill more than a register, being wider than those that they become, come and go by
// halves.
template <class V, class T, class Which>
[[gnu::always_inline]] inline V load(const T* from, Which which) {
  constexpr int n = count<V>;
  if constexpr (n * sizeof(T) > register_bytes) {
    return joined<V>(load<Half<V>>(from, which.template low<n / 2>()),
                     load<Half<V>>(from + n / 2, which.template high<n / 2>()),
                     std::make_index_sequence<n>{});
  } else {
    return convert<V>(load_some<Lanes<T, n>>(from, which));
  }
}

template <class T, class V, class Which>
[[gnu::always_inline]] inline void store(T* to, V value, Which which) {
  constexpr int n = count<V>;
  if constexpr (n * sizeof(T) > register_bytes) {
    store(to, part<0>(value, std::make_index_sequence<n / 2>{}), which.template low<n / 2>());
    store(to + n / 2, part<n / 2>(value, std::make_index_sequence<n / 2>{}),
          which.template high<n / 2>());
  } else {
    store_some(to, convert<Lanes<T, n>>(value), which);
  }
}

template <class V>
[[gnu::always_inline]] inline V all(Number<V> value) {
  return value - V{};
}

// a + b and a - b by the units that multiply and add, a product with one being exact: the same to
// the last bit. The kernel has many more sums than products, and where a processor has separate
// units for the two this shares out the work.
template <class V>
[[gnu::always_inline]] inline V plus(V a, V b) {
#ifdef __FMA__
  constexpr bool single = sizeof(Number<V>) == sizeof(float);
#ifdef __AVX512F__
  if constexpr (sizeof(V) == 64 && single) return _mm512_fmadd_ps(a, _mm512_set1_ps(1), b);
  if constexpr (sizeof(V) == 64 && !single) return _mm512_fmadd_pd(a, _mm512_set1_pd(1), b);
#endif
  if constexpr (sizeof(V) == 32 && single) return _mm256_fmadd_ps(a, _mm256_set1_ps(1), b);
  if constexpr (sizeof(V) == 32 && !single) return _mm256_fmadd_pd(a, _mm256_set1_pd(1), b);
#endif
  return a + b;
}
template <class V>
[[gnu::always_inline]] inline V minus(V a, V b) {
#ifdef __FMA__
  constexpr bool single = sizeof(Number<V>) == sizeof(float);
#ifdef __AVX512F__
  if constexpr (sizeof(V) == 64 && single) return _mm512_fnmadd_ps(b, _mm512_set1_ps(1), a);
  if constexpr (sizeof(V) == 64 && !single) return _mm512_fnmadd_pd(b, _mm512_set1_pd(1), a);
#endif
  if constexpr (sizeof(V) == 32 && single) return _mm256_fnmadd_ps(b, _mm256_set1_ps(1), a);
  if constexpr (sizeof(V) == 32 && !single) return _mm256_fnmadd_pd(b, _mm256_set1_pd(1), a);
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
constexpr double weight_at_rest = d3q19::w(0);

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

// The populations of some nodes less their rest weights: sums t and differences d of each pair.
template <class V>
struct Nodes {
  V rest;
  V t[pairs];
  V d[pairs];
};

template <class V, class Real, class Which>
[[gnu::always_inline]] inline Nodes<V> load_nodes(const Row<Real>& row, int k, Which which) {
  Nodes<V> nodes;  // NOLINT(cppcoreguidelines-pro-type-member-init): every member is set below
  nodes.rest = load<V>(row.rest + k, which);
  for_pairs([&]<int p>() __attribute__((always_inline)) {
    const V f = load<V>(row.plus[p] + k, which);
    const V opposite = load<V>(row.minus[p] + k, which);
    nodes.t[p] = plus<V>(f, opposite);
    nodes.d[p] = minus<V>(f, opposite);
  });
  return nodes;
}

template <class V>
struct Moments {
  V density_less_one;
  V x;
  V y;
  V z;
};

// The pairs in the order of d3q19::e: x y z xy x-y xz x-z yz y-z. Short chains of additions.
template <class V>
[[gnu::always_inline]] inline Moments<V> moments_of(const Nodes<V>& nodes) {
  const auto& t = nodes.t;
  const auto& d = nodes.d;
  Moments<V> m;  // NOLINT(cppcoreguidelines-pro-type-member-init): every member is set below
  m.density_less_one =
      (((t[3] + t[4]) + (t[5] + t[6])) + ((t[7] + t[8]) + (t[0] + t[1]))) + (t[2] + nodes.rest);
  m.x = ((d[3] + d[4]) + (d[5] + d[6])) + d[0];
  m.y = ((d[3] - d[4]) + (d[7] + d[8])) + d[1];
  m.z = ((d[5] - d[6]) + (d[7] - d[8])) + d[2];
  return m;
}

template <class V>
struct Vector {
  V x;
  V y;
  V z;
};

// The weight of the diagonals.
constexpr double w = 1.0 / 36;
static_assert(d3q19::w(7) == w);

template <class V>
constexpr bool is_single = sizeof(Number<V>) == sizeof(float);

// What a node's density 1 + drho weighs in its momentum.
template <bool compressible, class V>
[[gnu::always_inline]] inline V weighing(V drho) {
  if constexpr (compressible) return Number<V>{1} + drho;
  return all<V>(1);
}

template <class V>
[[gnu::always_inline]] inline Vector<V> combined(double a, const Vector<V>& x, double b,
                                                 const Vector<V>& y) {
  const auto of_x = static_cast<Number<V>>(a);
  const auto of_y = static_cast<Number<V>>(b);
  return {of_x * x.x + of_y * y.x, of_x * x.y + of_y * y.y, of_x * x.z + of_y * y.z};
}

// What the odd parts of pairs relax to and gain, along the axes: of the momentum m, that is j
// without the force, and of the force F. In double precision q of relax(), and nothing beside.
//
// In single precision rounding must not lean to one side, or it is momentum gained in every step:
// 1e-5 of a channel's flow. What leans is a factor of the momentum that is rounded, as 1/12 would
// be by 3e-8; its product with a number of few digits, as 1 - w- may be, since what is rounded off
// takes few values then; and a constant force that is added to numbers of which the last digit is
// worth a part of it. So there q is m/12, by a division, which is right to the last digit, and
//   d* = d - w- (d - 2 w_i 3 c.m) + 2 w_i 3 c.F;
// the force is put beside q, and added to the even part of a pair, the digits of which are worth
// less.
template <class V>
struct Odd {
  Vector<V> q;
  Vector<V> beside;
};
template <class V>
[[gnu::always_inline]] inline Odd<V> odd_of(double wm, const Vector<V>& m, const Vector<V>& j,
                                            const Vector<V>& force) {
  if constexpr (is_single<V>) {
    constexpr Number<V> c = 12;
    constexpr auto b = static_cast<Number<V>>(3 * w);
    return {{m.x / c, m.y / c, m.z / c}, {b * force.x, b * force.y, b * force.z}};
  } else {
    return {combined(w * 3 * wm, j, w * 3 * (1 - 0.5 * wm), force), Vector<V>{}};
  }
}

// Relaxes nodes of density 1 + drho, velocity u and momentum j = rho u towards equilibrium under
// the force F, eqs. (2)-(4), and writes their populations back, those of each pair exchanged. With
// t = f_i + f_-i, d = f_i - f_-i:
//   t* = (1 - w+) t + 2 w_i [w+ (drho - 3/2 u.j + 9/2 (c.u)(c.j)) + g+ (9 (c.u)(c.F) - 3 u.F)]
//   d* = (1 - w-) d + 2 w_i [3 w- c.j + 3 g- c.F],                        g = 1 - w/2
// r = 9/2 w+ j + 9 g+ F and q = 3 w- j + 3 g- F turn this into
//   t* = (1 - w+) t + 2 w_i [w+ drho - u.r/3 + (c.u)(c.r)],   d* = (1 - w-) d + 2 w_i c.q.
// Both are scaled by 1/36, the weight of the diagonals.
template <class V, class Real, class Which>
[[gnu::always_inline]] inline void relax(const Row<Real>& row, int k, Which which,
                                         const Nodes<V>& nodes, const Relaxation& relaxation,
                                         V drho, const Vector<V>& u, const Vector<V>& m,
                                         const Vector<V>& j, const Vector<V>& force) {
  using T = Number<V>;
  const double wp = relaxation.omega_plus;
  const double wm = relaxation.omega_minus;
  const Vector<V> r = combined(w * 4.5 * wp, j, w * 9 * (1 - 0.5 * wp), force);
  const auto [q, beside] = odd_of(wm, m, j, force);

  const V xx = u.x * r.x;
  const V yy = u.y * r.y;
  const V zz = u.z * r.z;
  const V xy = u.x * r.y + u.y * r.x;
  const V xz = u.x * r.z + u.z * r.x;
  const V yz = u.y * r.z + u.z * r.y;
  V ur = (xx + yy) + zz;
  const V third = (T{1} / T{3}) * ur;
  if constexpr (is_single<V>) ur = T{3} * third;  // lest the rounding of 1/3 be mass
  const V s = static_cast<T>(w * wp) * drho - third;

  const T keep_even = static_cast<T>(0.5 * (1 - wp));
  store(row.rest + k, static_cast<T>(1 - wp) * nodes.rest + T{12} * s, which);
  const auto put = [&]<int p>(V even, V odd, [[maybe_unused]] V more)
      __attribute__((always_inline)) {
    const V t = keep_even * nodes.t[p] + even;
    if constexpr (is_single<V>) {
      const V half = T{0.5} * nodes.d[p];
      const V d = half - static_cast<T>(wm) * (half - odd);
      store(row.minus[p] + k, plus(plus(t, more), d), which);
      store(row.plus[p] + k, (t - more) - d, which);
    } else {
      const T keep_odd = static_cast<T>(0.5 * (1 - wm));
      const V d = keep_odd * nodes.d[p] + odd;
      store(row.minus[p] + k, plus(t, d), which);
      store(row.plus[p] + k, t - d, which);
    }
  };
  constexpr T two = 2;
  put.template operator()<0>(two * (s + xx), two * q.x, two * beside.x);
  put.template operator()<1>(two * (s + yy), two * q.y, two * beside.y);
  put.template operator()<2>(two * (s + zz), two * q.z, two * beside.z);
  const V s_all = s + ur;
  const V s_xy = s_all - zz;
  put.template operator()<3>(s_xy + xy, q.x + q.y, beside.x + beside.y);
  put.template operator()<4>(s_xy - xy, q.x - q.y, beside.x - beside.y);
  const V s_xz = s_all - yy;
  put.template operator()<5>(s_xz + xz, q.x + q.z, beside.x + beside.z);
  put.template operator()<6>(s_xz - xz, q.x - q.z, beside.x - beside.z);
  const V s_yz = s_all - xx;
  put.template operator()<7>(s_yz + yz, q.y + q.z, beside.y + beside.z);
  put.template operator()<8>(s_yz - yz, q.y - q.z, beside.y - beside.z);
}

template <class V, class Which>
[[gnu::always_inline]] inline Vector<V> load_vector(const Number<V>* const* from, int k,
                                                    Which which) {
  return {load<V>(from[0] + k, which), load<V>(from[1] + k, which), load<V>(from[2] + k, which)};
}
template <class V, class Which>
[[gnu::always_inline]] inline void store_vector(Number<V>* const* to, int k, const Vector<V>& v,
                                                Which which) {
  store(to[0] + k, v.x, which);
  store(to[1] + k, v.y, which);
  store(to[2] + k, v.z, which);
}

template <class V>
[[gnu::always_inline]] inline Vector<V> uniform(const double* v) {
  using T = Number<V>;
  return {all<V>(static_cast<T>(v[0])), all<V>(static_cast<T>(v[1])), all<V>(static_cast<T>(v[2]))};
}

template <bool local, class V, class Which>
[[gnu::always_inline]] inline Vector<V> force_at(const RowForce<Number<V>>& force, int k,
                                                 [[maybe_unused]] Which which) {
  Vector<V> f = uniform<V>(force.uniform);
  if constexpr (local) {
    const Vector<V> more = load_vector<V>(force.local, k, which);
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
template <int nx, int ny, bool compressible>
struct WallRule {
  static constexpr bool edge = nx != 0 && ny != 0;
  double u[3];
  double f[3];

  WallRule(const double* force, const RowWall& wall)
      : u{wall.velocity[0], wall.velocity[1], wall.velocity[2]}, f{force[0], force[1], force[2]} {}

  template <class V>
  struct Known {
    V rest;
    V plus[pairs];
    V minus[pairs];
  };

  template <class V, class Real, class Which>
  [[gnu::always_inline]] static Known<V> load_known(const Row<Real>& row, int k, Which which) {
    Known<V> known;  // NOLINT(cppcoreguidelines-pro-type-member-init): the unknown are not read
    known.rest = load<V>(row.rest + k, which);
    for_pairs([&]<int p>() __attribute__((always_inline)) {
      if constexpr (counted<p, 1, nx, ny> != 0) known.plus[p] = load<V>(row.plus[p] + k, which);
      if constexpr (counted<p, -1, nx, ny> != 0) known.minus[p] = load<V>(row.minus[p] + k, which);
    });
    return known;
  }

  // rho = sum_known (1 - c.n_x)(1 - c.n_y) f - F.(n_x + n_y)/2, with u.n = 0 for either wall. Both
  // of a pair are known only if they run along the wall, and then each counts once.
  template <class V>
  [[gnu::always_inline]] V density_less_one(const Known<V>& known) const {
    using T = Number<V>;
    V drho = known.rest - static_cast<T>(0.5 * (nx * f[0] + ny * f[1]));
    for_pairs([&]<int p>() __attribute__((always_inline)) {
      constexpr int a = counted<p, 1, nx, ny>;
      constexpr int b = counted<p, -1, nx, ny>;
      if constexpr (a > 0 && b > 0) {
        drho += known.plus[p] + known.minus[p];
      } else if constexpr (a > 0) {
        drho += T{a} * known.plus[p];
      } else if constexpr (b > 0) {
        drho += T{b} * known.minus[p];
      }
    });
    return drho;
  }

  template <class V, class Real, class Which>
  [[gnu::always_inline]] void collide_nodes(const Row<Real>& row, int k, Which which,
                                            const Relaxation& relaxation) const {
    using T = Number<V>;
    constexpr T two = 2;
    Nodes<V> nodes;  // NOLINT(cppcoreguidelines-pro-type-member-init): every member is set below
    const Known<V> known = load_known<V>(row, k, which);
    const double uu = 1.5 * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    const V drho = density_less_one<V>(known);
    const V rho = weighing<compressible>(drho);
    V pxx{};
    V pyy{};
    V pzz{};
    V pxy{};
    V pxz{};
    V pyz{};
    if constexpr (!edge) {
      for_pairs([&]<int p>() __attribute__((always_inline)) {
        const double cu = along<p>(u[0], u[1], u[2]);
        const V even =
            static_cast<T>(weight<p>) * (drho + rho * static_cast<T>(4.5 * cu * cu - uu));
        const V odd = static_cast<T>(weight<p> * 3 * cu) * rho;
        V t;  // non-equilibrium of both populations of the pair
        const T half_force = static_cast<T>(1.5 * weight<p> * along<p>(f[0], f[1], f[2]));
        if constexpr (counted<p, 1, nx, ny> == 0) {
          t = two * (known.minus[p] - (even - odd + half_force));
        } else if constexpr (counted<p, -1, nx, ny> == 0) {
          t = two * (known.plus[p] - (even + odd - half_force));
        } else {
          t = (known.plus[p] + known.minus[p]) - two * even;
        }
        add<ex<p> * ex<p>>(pxx, t);
        add<ey<p> * ey<p>>(pyy, t);
        add<ez<p> * ez<p>>(pzz, t);
        add<ex<p> * ey<p>>(pxy, t);
        add<ex<p> * ez<p>>(pxz, t);
        add<ey<p> * ez<p>>(pyz, t);
      });
    }
    const V trace = (pxx + pyy + pzz) * (T{1} / T{3});
    nodes.rest =
        static_cast<T>(weight_at_rest) * (drho - rho * static_cast<T>(uu) - T{4.5} * trace);
    V moving{};  // of all that do not rest
    for_pairs([&]<int p>() __attribute__((always_inline)) {
      V q = -trace;  // (e e - 1/3):Pi
      add<ex<p> * ex<p>>(q, pxx);
      add<ey<p> * ey<p>>(q, pyy);
      add<ez<p> * ez<p>>(q, pzz);
      add<ex<p> * ey<p>>(q, two * pxy);
      add<ex<p> * ez<p>>(q, two * pxz);
      add<ey<p> * ez<p>>(q, two * pyz);
      const double cu = along<p>(u[0], u[1], u[2]);
      const double half_force = 0.5 * along<p>(f[0], f[1], f[2]);
      nodes.t[p] = static_cast<T>(2 * weight<p>) *
                   (drho + rho * static_cast<T>(4.5 * cu * cu - uu) + T{4.5} * q);
      moving += nodes.t[p];
      nodes.d[p] =
          static_cast<T>(6 * weight<p>) * (rho * static_cast<T>(cu) - static_cast<T>(half_force));
    });
    if constexpr (is_single<V>) nodes.rest = drho - moving;  // lest rounded weights be mass
    const Vector<V> velocity = uniform<V>(u);
    const Vector<V> j = {rho * velocity.x, rho * velocity.y, rho * velocity.z};
    const Vector<V> force = uniform<V>(f);
    const Vector<V> m = combined(1, j, -0.5, force);
    relax(row, k, which, nodes, relaxation, drho, velocity, m, j, force);
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

// Calls f<V>(k, which) for nodes [begin, end), as many at a time as V has lanes of the T: the
// widest vectors, then one of which some numbers are left out, or ever narrower ones, for what
// remains.
template <class T, int N = widest<T>, class F>
[[gnu::always_inline]] inline void for_nodes(int begin, int end, F&& f) {
  int k = begin;
#pragma GCC unroll 1
  for (; k + N <= end; k += N) f.template operator()<Lanes<T, N>>(k, All{});
  if constexpr (loads_some) {
    if (k < end) f.template operator()<Lanes<T, N>>(k, First::of(end - k));
  } else if constexpr (N > 1) {
    if (k < end) for_nodes<T, N / 2>(k, end, f);
  }
}

// The same with each array fetched ahead, once a cache line.
template <class T, class Real, class F>
[[gnu::always_inline]] inline void for_nodes_ahead(const Row<Real>& row, int begin, int end,
                                                   F&& f) {
  constexpr int line = cache_line / sizeof(Real);
  constexpr int N = widest<T>;
  static_assert(line % N == 0);
  int k = begin;
  for (; k + line <= end; k += line) {
    prefetch(row, k);
#pragma GCC unroll 1
    for (int j = 0; j < line; j += N) f.template operator()<Lanes<T, N>>(k + j, All{});
  }
  if (k < end) {
    prefetch(row, k);
    for_nodes<T>(k, end, f);
  }
}

// Rows are taken by value here, so that the compiler sees that no store changes where they are.
template <class T, bool compressible, bool local, class Real>
void collide_row(Row<Real> row, int begin, int end, Relaxation relaxation, RowForce<T> force) {
  for_nodes_ahead<T>(
      row, begin, end, [&]<class V>(int k, auto which) __attribute__((always_inline)) {
        const Vector<V> f = force_at<local, V>(force, k, which);
        const Nodes<V> nodes = load_nodes<V>(row, k, which);
        const Moments<V> m = moments_of(nodes);
        constexpr T half = 0.5;
        const Vector<V> j = {m.x + half * f.x, m.y + half * f.y, m.z + half * f.z};
        Vector<V> u = j;
        if constexpr (compressible) {
          const V inverse = T{1} / (T{1} + m.density_less_one);
          u = {j.x * inverse, j.y * inverse, j.z * inverse};
        }
        if constexpr (local) store_vector(force.velocity, k, u, which);
        relax(row, k, which, nodes, relaxation, m.density_less_one, u, {m.x, m.y, m.z}, j, f);
      });
}

template <class T, bool compressible, class Real>
void collide(const Row<Real>& row, int begin, int end, const Relaxation& relaxation,
             const RowForce<T>& force) {
  if (force.local[0] != nullptr) {
    collide_row<T, compressible, true>(row, begin, end, relaxation, force);
  } else {
    collide_row<T, compressible, false>(row, begin, end, relaxation, force);
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

template <class T, bool compressible, int nx, int ny, class Real>
void collide_wall_row(Row<Real> row, int begin, int end, Relaxation relaxation,
                      const RowForce<T>& force, const RowWall& wall) {
  const WallRule<nx, ny, compressible> rule(force.uniform, wall);
  for_nodes_ahead<T>(
      row, begin, end, [&]<class V>(int k, auto which) __attribute__((always_inline)) {
        rule.template collide_nodes<V>(row, k, which, relaxation);
      });
}

template <class T, bool compressible, class Real>
void collide_wall(const Row<Real>& row, int begin, int end, const Relaxation& relaxation,
                  const RowForce<T>& force, const RowWall& wall) {
  for_wall(wall, [&]<int nx, int ny>() {
    collide_wall_row<T, compressible, nx, ny>(row, begin, end, relaxation, force, wall);
  });
}

template <int nx, int ny, class Real>
void wall_density_row(Row<Real> row, int begin, int end, const double* force, const RowWall& wall,
                      double* density) {
  const WallRule<nx, ny, true> rule(force, wall);  // of which the density is no matter here
  for_nodes_ahead<double>(
      row, begin, end, [&]<class V>(int k, auto which) __attribute__((always_inline)) {
        store(density + k, rule.density_less_one(rule.template load_known<V>(row, k, which)),
              which);
      });
}

template <class Real>
void wall_density(const Row<Real>& row, int begin, int end, const double* force,
                  const RowWall& wall, double* density) {
  for_wall(wall, [&]<int nx, int ny>() {
    wall_density_row<nx, ny>(row, begin, end, force, wall, density);
  });
}

template <class Real>
void moments(const Row<Real>& row, int begin, int end, double* density, double* x, double* y,
             double* z) {
  for_nodes_ahead<double>(
      row, begin, end, [&]<class V>(int k, auto which) __attribute__((always_inline)) {
        const Moments<V> m = moments_of(load_nodes<V>(row, k, which));
        store(density + k, m.density_less_one, which);
        store(x + k, m.x, which);
        store(y + k, m.y, which);
        store(z + k, m.z, which);
      });
}

template <class T, bool compressible, class Real>
void momentum_row(Row<Real> row, int begin, int end, RowForce<T> force, T* density, T* x, T* y,
                  T* z) {
  for_nodes_ahead<T>(
      row, begin, end, [&]<class V>(int k, auto which) __attribute__((always_inline)) {
        constexpr T half = 0.5;
        const Moments<V> m = moments_of(load_nodes<V>(row, k, which));
        const Vector<V> f = uniform<V>(force.uniform);
        if constexpr (compressible) store(density + k, T{1} + m.density_less_one, which);
        store(x + k, m.x + half * f.x, which);
        store(y + k, m.y + half * f.y, which);
        store(z + k, m.z + half * f.z, which);
      });
}

template <class T, bool compressible, class Real>
void momentum(const Row<Real>& row, int begin, int end, const RowForce<T>& force, T* density, T* x,
              T* y, T* z) {
  momentum_row<T, compressible>(row, begin, end, force, density, x, y, z);
}

template <bool compressible, class Real>
void add_flow(const Row<Real>& row, int begin, int end, double half_force, double share,
              double* sum) {
  for_nodes_ahead<double>(
      row, begin, end, [&]<class V>(int k, auto which) __attribute__((always_inline)) {
        const Moments<V> m = moments_of(load_nodes<V>(row, k, which));
        const V u = (m.z + half_force) / weighing<compressible>(m.density_less_one);
        store(sum + k, load<V>(sum + k, which) + share * u, which);
      });
}

template <class Real>
void stream_row(Row<Real> row, int begin, int end) {
  for_nodes_ahead<Real>(
      row, begin, end, [&]<class Values>(int k, auto which) __attribute__((always_inline)) {
        const auto swap = [&](Real * a, Real * b) __attribute__((always_inline)) {
          const auto x = load<Values>(a + k, which);
          const auto y = load<Values>(b + k, which);
          store(a + k, y, which);
          store(b + k, x, which);
        };
        store(row.rest + k, -load<Values>(row.rest + k, which), which);
        for_pairs([&]<int p>() __attribute__((always_inline)) { swap(row.plus[p], row.minus[p]); });
      });
}

template <class Real>
void stream(const Row<Real>& row, int begin, int end) {
  stream_row(row, begin, end);
}

}  // namespace

namespace DUCTILE_INSTRUCTION_SET {

template <class Real, class T, bool compressible>
constexpr Kernel<Real, T> functions = {collide<T, compressible, Real>,
                                       collide_wall<T, compressible, Real>,
                                       wall_density<Real>,
                                       moments<Real>,
                                       momentum<T, compressible, Real>,
                                       add_flow<compressible, Real>,
                                       stream<Real>};

template <class Real, class T>
const Kernel<Real, T>& kernel(bool compressible) {
  return compressible ? functions<Real, T, true> : functions<Real, T, false>;
}
template const Kernel<double, double>& kernel<double, double>(bool);
template const Kernel<float, double>& kernel<float, double>(bool);
template const Kernel<float, float>& kernel<float, float>(bool);

}  // namespace DUCTILE_INSTRUCTION_SET

}  // namespace ductile::fluid
