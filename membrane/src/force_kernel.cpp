// Compiled once for each instruction set, under the namespace DUCTILE_INSTRUCTION_SET. What is
// below is in an unnamed namespace, and nothing of the standard library is called: an inline
// function with external linkage might be linked from here into code for a lesser machine.
#include "force_kernel.hpp"

#include "lanes.hpp"

namespace ductile::membrane {
namespace {

// Lanes are a number of four triangles, or of four edges.
struct Vector {
  Lanes x, y, z;
};
[[gnu::always_inline]] inline Vector operator-(const Vector& a, const Vector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline Vector operator+(const Vector& a, const Vector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[gnu::always_inline]] inline Vector operator*(Lanes c, const Vector& a) {
  return {c * a.x, c * a.y, c * a.z};
}
[[gnu::always_inline]] inline Lanes dot(const Vector& a, const Vector& b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}
[[gnu::always_inline]] inline Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// What four vertices or triangles have: a vector, and the fourth number.
struct Gathered {
  Vector vector;
  Lanes fourth;
};
[[gnu::always_inline]] inline Gathered gather(const Four* from, const int* which) {
  Lanes rows[4] = {load(from[which[0]].of), load(from[which[1]].of), load(from[which[2]].of),
                   load(from[which[3]].of)};
  transpose(rows);
  return {{rows[0], rows[1], rows[2]}, rows[3]};
}
[[gnu::always_inline]] inline Lanes gather(const double* from, const int* which) {
  return Lanes{from[which[0]], from[which[1]], from[which[2]], from[which[3]]};
}

// How many of the four from n on there are.
[[gnu::always_inline]] inline std::size_t present(std::size_t n, std::size_t count) {
  return count - n < 4 ? count - n : 4;
}

double normals(const ForceElements& elements, const Four* position, Four* normal) {
  const Four& first = position[0];  // near the shell, lest its distance cost digits
  const Vector origin = {first.of[0] - Lanes{}, first.of[1] - Lanes{}, first.of[2] - Lanes{}};
  double volume = 0;
  for (std::size_t t = 0; t < elements.triangles; t += 4) {
    const Vector x0 = gather(position, elements.vertex[0] + t).vector;
    const Vector x1 = gather(position, elements.vertex[1] + t).vector;
    const Vector x2 = gather(position, elements.vertex[2] + t).vector;
    const Vector n = cross(x1 - x0, x2 - x0);
    Lanes rows[4] = {n.x, n.y, n.z, 1.0 / root(dot(n, n))};
    transpose(rows);
    for (std::size_t k = 0; k < 4; ++k) store(normal[t + k].of, rows[k]);
    const Lanes part = dot(x0 - origin, n);
    for (std::size_t k = 0; k < present(t, elements.triangles); ++k) volume += part[k];
  }
  return volume;
}

void moments(const ForceElements& elements, double bending, const Four* position,
             const Four* normal, double* moment) {
  for (std::size_t h = 0; h < elements.edges; h += 4) {
    const Gathered left = gather(normal, elements.left + h);
    const Gathered right = gather(normal, elements.right + h);
    const Vector edge =
        gather(position, elements.head + h).vector - gather(position, elements.tail + h).vector;
    const Lanes scale = left.fourth * right.fourth;
    const Lanes inverse_length = 1.0 / root(dot(edge, edge));
    const Lanes cosine = dot(left.vector, right.vector) * scale;
    const Lanes sine = dot(cross(left.vector, right.vector), edge) * (scale * inverse_length);
    const Lanes of_difference = sine * load(elements.cos0 + h) - cosine * load(elements.sin0 + h);
    store(moment + h, bending * of_difference * inverse_length);
  }
}

template <bool skalak>
void forces_by(const ForceElements& elements, const ForceModuli& moduli, double pressure,
               const Four* position, const Four* normal, const double* moment, Four* force) {
  for (std::size_t t = 0; t < elements.triangles; t += 4) {
    const Vector x0 = gather(position, elements.vertex[0] + t).vector;
    const Vector e1 = gather(position, elements.vertex[1] + t).vector - x0;
    const Vector e2 = gather(position, elements.vertex[2] + t).vector - x0;
    Lanes rows[4] = {load(normal[t].of), load(normal[t + 1].of), load(normal[t + 2].of),
                     load(normal[t + 3].of)};
    transpose(rows);
    const Vector n = {rows[0], rows[1], rows[2]};
    const Lanes g11 = dot(e1, e1);
    const Lanes g12 = dot(e1, e2);
    const Lanes g22 = dot(e2, e2);

    // Strain: dE/de_i = s_ij e_j with the stress s = 2 A0 dW/dg = 2 A0 (W1 dI1/dg + W2 dI2/dg).
    const Lanes a11 = load(elements.a11 + t);
    const Lanes a12 = load(elements.a12 + t);
    const Lanes a22 = load(elements.a22 + t);
    const Lanes inverse_det = load(elements.inverse_det + t);
    const Lanes area = load(elements.area + t);
    const Lanes i2 = dot(n, n) * inverse_det - 1.0;
    Lanes w1;
    Lanes w2;
    if constexpr (skalak) {
      const Lanes i1 = g11 * a11 + 2.0 * g12 * a12 + g22 * a22 - 2.0;
      w1 = moduli.k_s / 6 * (i1 + 1.0);
      w2 = (moduli.k_a * i2 - moduli.k_s) / 6.0;
    } else {
      const Lanes inverse = 1.0 / (i2 + 1.0);
      w1 = moduli.k_s / 6 - Lanes{};
      w2 = -moduli.k_s / 6 * inverse * inverse;
    }
    const Lanes c1 = 2.0 * area * w1;
    const Lanes c2 = 2.0 * area * w2 * inverse_det;
    const Lanes s11 = c1 * a11 + c2 * g22;
    const Lanes s12 = c1 * a12 - c2 * g12;
    const Lanes s22 = c1 * a22 + c2 * g11;

    // Bending: this triangle's part of dtheta/dx of its edges is along its normal n. With the
    // edge k, of length l, facing vertex k,
    //   dtheta/dx_k = -(l/n^2) n,   dtheta/dx_i = (p_j/(l n^2)) n,   p_i = e_ij . e_ik,
    // for its ends i and j; l^2 = p_i + p_j. The moments hold (dE/dtheta)/l.
    const Lanes p0 = g12;
    const Lanes p1 = g11 - g12;
    const Lanes p2 = g22 - g12;
    const Lanes m0 = gather(moment, elements.edge[0] + t);
    const Lanes m1 = gather(moment, elements.edge[1] + t);
    const Lanes m2 = gather(moment, elements.edge[2] + t);
    const Lanes b01 = p2 * (m1 - m0);
    const Lanes b12 = p0 * (m2 - m1);
    const Lanes b20 = p1 * (m0 - m2);
    const Lanes scale = rows[3] * rows[3];
    const Lanes b0 = (b01 - b20) * scale;
    const Lanes b1 = (b12 - b01) * scale;
    const Lanes b2 = (b20 - b12) * scale;

    const Vector strain1 = s11 * e1 + s12 * e2;
    const Vector strain2 = s12 * e1 + s22 * e2;
    const Vector at[3] = {(strain1 + strain2) - (b0 + pressure / 6) * n,
                          strain1 + (b1 + pressure / 6) * n, strain2 + (b2 + pressure / 6) * n};
    Lanes parts[3][4];
    for (int corner = 0; corner < 3; ++corner) {
      parts[corner][0] = at[corner].x;
      parts[corner][1] = at[corner].y;
      parts[corner][2] = at[corner].z;
      parts[corner][3] = Lanes{};
      transpose(parts[corner]);
    }
    // Triangle by triangle, so that a vertex has its parts in their order.
    for (std::size_t k = 0; k < present(t, elements.triangles); ++k) {
      double* f0 = force[elements.vertex[0][t + k]].of;
      double* f1 = force[elements.vertex[1][t + k]].of;
      double* f2 = force[elements.vertex[2][t + k]].of;
      store(f0, load(f0) + parts[0][k]);
      store(f1, load(f1) - parts[1][k]);
      store(f2, load(f2) - parts[2][k]);
    }
  }
}

void forces(const ForceElements& elements, const ForceModuli& moduli, double pressure,
            const Four* position, const Four* normal, const double* moment, Four* force) {
  (moduli.skalak ? forces_by<true> : forces_by<false>)(elements, moduli, pressure, position, normal,
                                                       moment, force);
}

}  // namespace

namespace DUCTILE_INSTRUCTION_SET {

const ForceKernel& force_kernel() {
  static constexpr ForceKernel functions = {normals, moments, forces};
  return functions;
}

}  // namespace DUCTILE_INSTRUCTION_SET

}  // namespace ductile::membrane
