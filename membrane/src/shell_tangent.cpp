// The Hessian of the shell's energy. Notation: vertices 0, 1, 2 of a triangle, e1 and e2 its edges
// from 0 to 1 and 2, n = e1 x e2, N = n/|n|.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "ductile/membrane/shell.hpp"
#include "shell_math.hpp"

namespace ductile::membrane {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::sqrt3;

// The values of a MATSEQBAIJ while this object lives.
class BlockValues {
 public:
  explicit BlockValues(Mat mat) : mat_(mat) { petsc_check(MatSeqBAIJGetArray(mat, &data_)); }
  BlockValues(const BlockValues&) = delete;
  BlockValues& operator=(const BlockValues&) = delete;
  ~BlockValues() { static_cast<void>(MatSeqBAIJRestoreArray(mat_, &data_)); }
  [[nodiscard]] double* data() const { return data_; }

 private:
  Mat mat_;
  double* data_ = nullptr;
};

// A column of a block, and a fourth number that nobody reads.
using Column = double __attribute__((vector_size(32)));

Column column(const Vector3d& v) {
  return Column{v[0], v[1], v[2], 0};
}
Column load(const double* p) {
  Column v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
void store(double* p, Column v) {
  std::memcpy(p, &v, sizeof v);
}

}  // namespace

// Only the blocks above the diagonal are summed, one for each pair of vertices, in columns that fit
// the machine's vectors. The others follow: below, by symmetry; on the diagonal, since a
// translation costs nothing, each is minus the sum of its row.
struct Shell::TangentPattern {
  // Two vertices a and b of an element.
  struct Place {
    int pair;
    int row, column;  // a and b, or b and a, so that `row` is the pair's first
  };
  struct Hinge {
    std::array<int, 4> vertices;  // tail, head, the left triangle's other, the right one's
    std::array<Place, 6> places;  // tail with head comes first
  };

  std::vector<PetscInt> rows, columns;  // compressed
  std::vector<int> pair_of;             // of each block; of diagonal ones the last, which is unused
  std::vector<int> diagonal;
  int pair_count = 0;
  std::vector<std::array<Place, 3>> triangles;  // vertices 0 1, 0 2, 1 2
  std::vector<Hinge> hinges;

  explicit TangentPattern(const Shell& shell) {
    hinges.resize(shell.hinges_.size());
    for (std::size_t h = 0; h < hinges.size(); ++h) {
      const auto& [left, right, tail, head, cos0, sin0] = shell.hinges_[h];
      const auto apex = [&, tail = tail, head = head](int triangle) {
        const auto& v = shell.triangles_[triangle];
        return v[0] + v[1] + v[2] - tail - head;
      };
      hinges[h].vertices = {tail, head, apex(left), apex(right)};
    }
    build_rows(shell);

    pair_of.resize(columns.size());
    for (int row = 0; row < shell.vertex_count_; ++row) {
      diagonal.push_back(slot(row, row));
      for (PetscInt k = rows[row]; k < rows[row + 1]; ++k) {
        if (columns[k] > row) pair_of[k] = pair_of[slot(columns[k], row)] = pair_count++;
      }
    }
    for (const int k : diagonal) pair_of[k] = pair_count;
    ++pair_count;
    const auto place = [&](const auto& vertices, int a, int b) {
      if (vertices[a] > vertices[b]) std::swap(a, b);
      return Place{pair_of[slot(vertices[a], vertices[b])], a, b};
    };
    for (const auto& v : shell.triangles_) {
      triangles.push_back({place(v, 0, 1), place(v, 0, 2), place(v, 1, 2)});
    }
    for (Hinge& hinge : hinges) {
      const auto& v = hinge.vertices;
      hinge.places = {place(v, 0, 1), place(v, 0, 2), place(v, 0, 3),
                      place(v, 1, 2), place(v, 1, 3), place(v, 2, 3)};
    }
  }

  // Whether `mat` has these rows and columns.
  [[nodiscard]] bool fits(Mat mat) const {
    PetscBool is_baij = PETSC_FALSE;
    petsc_check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(mat), MATSEQBAIJ, &is_baij));
    if (is_baij == PETSC_FALSE) return false;
    PetscInt block_size = 0;
    petsc_check(MatGetBlockSize(mat, &block_size));
    if (block_size != 3) return false;
    PetscInt n = 0;
    const PetscInt *i = nullptr, *j = nullptr;
    PetscBool done = PETSC_FALSE;
    petsc_check(MatGetRowIJ(mat, 0, PETSC_FALSE, PETSC_TRUE, &n, &i, &j, &done));
    const bool same = done == PETSC_TRUE && n + 1 == static_cast<PetscInt>(rows.size()) &&
                      std::equal(rows.begin(), rows.end(), i) &&
                      std::equal(columns.begin(), columns.end(), j);
    petsc_check(MatRestoreRowIJ(mat, 0, PETSC_FALSE, PETSC_TRUE, &n, &i, &j, &done));
    return same;
  }

 private:
  void build_rows(const Shell& shell) {
    std::vector<std::vector<PetscInt>> neighbours(shell.vertex_count_);
    for (const auto& v : shell.triangles_) {
      for (const int a : v) neighbours[a].insert(neighbours[a].end(), v.begin(), v.end());
    }
    for (const Hinge& hinge : hinges) {
      neighbours[hinge.vertices[2]].push_back(hinge.vertices[3]);
      neighbours[hinge.vertices[3]].push_back(hinge.vertices[2]);
    }
    rows.push_back(0);
    for (auto& row : neighbours) {
      std::sort(row.begin(), row.end());
      columns.insert(columns.end(), row.begin(), std::unique(row.begin(), row.end()));
      rows.push_back(static_cast<PetscInt>(columns.size()));
    }
  }

  [[nodiscard]] int slot(int row, int column) const {
    const auto begin = columns.begin();
    return static_cast<int>(std::lower_bound(begin + rows[row], begin + rows[row + 1], column) -
                            begin);
  }
};

const Shell::TangentPattern& Shell::tangent_pattern() const {
  if (!tangent_pattern_) tangent_pattern_ = std::make_shared<const TangentPattern>(*this);
  return *tangent_pattern_;
}

MatPtr Shell::create_tangent() const {
  const TangentPattern& pattern = tangent_pattern();
  Mat mat = nullptr;
  petsc_check(MatCreate(PETSC_COMM_SELF, &mat));
  MatPtr owner(mat);
  petsc_check(
      MatSetSizes(mat, 3 * vertex_count_, 3 * vertex_count_, PETSC_DETERMINE, PETSC_DETERMINE));
  petsc_check(MatSetType(mat, MATSEQBAIJ));
  petsc_check(
      MatSeqBAIJSetPreallocationCSR(mat, 3, pattern.rows.data(), pattern.columns.data(), nullptr));
  petsc_check(MatSetOption(mat, MAT_NEW_NONZERO_LOCATION_ERR, PETSC_TRUE));
  petsc_check(MatSetOption(mat, MAT_SYMMETRIC, PETSC_TRUE));
  petsc_check(MatSetOption(mat, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  return owner;
}

void Shell::tangent(Vec positions, Mat tangent) const {
  const TangentPattern& pattern = tangent_pattern();
  if (!pattern.fits(tangent)) {
    throw std::invalid_argument(
        "shell: the tangent's matrix is not one that create_tangent() of this shell made");
  }
  const auto array = array_of<const double>(positions, vertex_count_);
  {
    const BlockValues values(tangent);
    pair_blocks_.assign(pattern.pair_count, {});
    const double volume = update_normals(array.data());
    add_hinge_tangents(array.data(), pressure(volume));
    add_triangle_tangents(array.data());
    spread_tangent(values.data());
  }
  // Tells solvers that the values, which they may hold factors of, are new.
  petsc_check(MatAssemblyBegin(tangent, MAT_FINAL_ASSEMBLY));
  petsc_check(MatAssemblyEnd(tangent, MAT_FINAL_ASSEMBLY));
}

// Adds the volume's part and the first of the bending's two, E'' g g^T + E' dg/dx with
// g = dtheta/dx; fills moments_ for the second.
void Shell::add_hinge_tangents(const double* x, double p) const {
  const TangentPattern& pattern = *tangent_pattern_;
  const double stiffness = sqrt3 * moduli_.k_b;
  for (std::size_t h = 0; h < hinges_.size(); ++h) {
    const Hinge& hinge = hinges_[h];
    const auto& [vertices, places] = pattern.hinges[h];
    const Vector3d tail = point(x, hinge.tail);
    const Vector3d left = point(x, vertices[2]) - tail, right = point(x, vertices[3]) - tail;

    if (p != 0) {
      // d2V/dx_tail dx_head = [x_right - x_left]/6 with [a] b = a x b.
      const double sign = places[0].row == 0 ? 1 : -1;
      const Vector3d v = sign * p / 6 * (right - left);
      double* block = pair_blocks_[places[0].pair].values;
      store(block, load(block) + Column{0, v[2], -v[1], 0});
      store(block + 4, load(block + 4) + Column{-v[2], 0, v[0], 0});
      store(block + 8, load(block + 8) + Column{v[1], -v[0], 0, 0});
    }

    if (stiffness == 0) continue;
    const Angle theta = angle(hinge, x);
    const double sine = theta.sin * hinge.cos0 - theta.cos * hinge.sin0;
    const double cosine = theta.cos * hinge.cos0 + theta.sin * hinge.sin0;
    moments_[h] = stiffness * sine * theta.inverse_length;

    // A triangle of height H over the edge adds to g: -N/H at the vertex that faces the edge, and
    // N/H at the edge's ends times the barycentric coordinates (1 - beta, beta) of the height's
    // foot.
    const Vector3d edge = point(x, hinge.head) - tail;
    const double inverse_square = theta.inverse_length * theta.inverse_length;
    const double length = edge.squaredNorm() * theta.inverse_length;
    const double left_scale = length * inverse_norms_[hinge.left] * inverse_norms_[hinge.left];
    const double right_scale = length * inverse_norms_[hinge.right] * inverse_norms_[hinge.right];
    const Vector3d a = left_scale * normals_[hinge.left], b = right_scale * normals_[hinge.right];
    const double beta_a = left.dot(edge) * inverse_square;
    const double beta_b = right.dot(edge) * inverse_square;
    const Vector3d g0 = (1 - beta_a) * a + (1 - beta_b) * b, g1 = beta_a * a + beta_b * b;
    const std::array<Column, 4> g = {column(g0), column(g1), -column(a), -column(b)};
    const double second = stiffness * cosine;
    for (const auto& [pair, row, col] : places) {
      double* block = pair_blocks_[pair].values;
      const Column u = second * g[row];
      for (int k = 0; k < 3; ++k) store(block + 4 * k, load(block + 4 * k) + g[col][k] * u);
    }
  }
}

// Adds the strain's part and the bending's second.
void Shell::add_triangle_tangents(const double* x) const {
  const TangentPattern& pattern = *tangent_pattern_;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& [v0, v1, v2] = triangles_[t];
    const Element& e = elements_[t];
    const Vector3d e1 = point(x, v1) - point(x, v0), e2 = point(x, v2) - point(x, v0);
    const double g11 = e1.squaredNorm(), g12 = e1.dot(e2), g22 = e2.squaredNorm();
    const double norm = inverse_norms_[t];
    const Vector3d normal = norm * normals_[t];

    // Neither part changes under a translation: the derivatives with respect to e1 and e2, i and k
    // below, suffice. Both are of the form
    //   H_ik = s_ik 1 + (e1 e2 N) C_ik (e1 e2 N)^T.

    // Strain: dE/de_i = s_ij e_j as in force(), and with q = adj g and c2 q the second part of s
    //   H_ik = s_ik 1 + 4 A0 W11 (a_ij e_j)(a_kl e_l)^T + 4 A0 W22/det^2 (q_ij e_j)(q_kl e_l)^T
    //          + c2 e_j (dq_ij/de_k)^T.
    const double i1 = g11 * e.a11 + 2 * g12 * e.a12 + g22 * e.a22 - 2;
    const double i2 = normals_[t].squaredNorm() * e.inverse_det - 1;
    const Density density = strain_density(moduli_, i1, i2);
    const double c1 = 2 * e.area * density.w1, c2 = 2 * e.area * density.w2 * e.inverse_det;
    const double c11 = 4 * e.area * density.w11;
    const double c22 = 4 * e.area * density.w22 * e.inverse_det * e.inverse_det;
    const double s11 = c1 * e.a11 + c2 * g22;
    const double s12 = c1 * e.a12 - c2 * g12;
    const double s22 = c1 * e.a22 + c2 * g11;
    // C_11 = (whole1 skew1; skew1 mixed), C_12 = (skew1 whole; mixed skew2),
    // C_22 = (mixed skew2; skew2 whole2).
    const double mixed = c11 * e.a12 * e.a12 + c22 * g12 * g12 - c2;
    const double skew1 = c11 * e.a11 * e.a12 - c22 * g22 * g12;
    const double skew2 = c11 * e.a12 * e.a22 - c22 * g12 * g11;
    const double whole = c11 * e.a11 * e.a22 + c22 * g11 * g22 + 2 * c2;
    const double whole1 = c11 * e.a11 * e.a11 + c22 * g22 * g22;
    const double whole2 = c11 * e.a22 * e.a22 + c22 * g11 * g11;

    // Bending. An edge of length l and direction T in this triangle, in which U = N x T points
    // inwards, and H the height over it, gives
    //   dg_i/dx_k = (w_i w_k/H^2 + d_i d_k/(2 l^2)) (U N^T + N U^T)
    //               - (d_i w_k N T^T + w_i d_k T N^T)/(H l)
    // where w is -1 for the vertex that faces it and the barycentric coordinates of the height's
    // foot for its ends, and d is -1 and 1 for its ends. (The sum over the edge's two triangles is
    // exact; each alone is made symmetric.) So H_ik = N v_ik^T + v_ki N^T, v in the plane.
    const double p1 = g11 - g12, p2 = g22 - g12;
    const double r2 = norm * norm;
    const double l0 = 1 / (p1 + p2), l1 = 1 / g22, l2 = 1 / g11;  // 1/l^2 of the edges
    const double m0 = moments_[e.hinges[0]], m1 = moments_[e.hinges[1]], m2 = moments_[e.hinges[2]];
    // Of N x T l and T l of the three edges in turn, the parts along e1 and e2, times 1/|n|.
    const auto v = [&](double u0, double u1, double u2, double t0, double t1, double t2) {
      return Vector2d(norm * (-p2 * u0 + g22 * u1 - g12 * u2 + t0 - t2),
                      norm * (-p1 * u0 - g12 * u1 + g11 * u2 - t0 + t1));
    };
    const double half0 = m0 * l0 / 2, half1 = m1 * l1 / 2, half2 = m2 * l2 / 2;
    const double w0 = m0 * l0 * r2, w1 = m1 * r2, w2 = m2 * r2;
    const double t01 = m0 * p2 * l0, t02 = m0 * p1 * l0;
    const Vector2d v11 = v(w0 * p2 * p2 + half0, w1 * g22, w2 * g12 * g12 * l2 + half2,  //
                           -t01, 0, m2 * g12 * l2);
    const Vector2d v22 = v(w0 * p1 * p1 + half0, w1 * g12 * g12 * l1 + half1, w2 * g11,  //
                           t02, -m1 * g12 * l1, 0);
    const double u0 = w0 * p1 * p2 - half0, u1 = -w1 * g12, u2 = -w2 * g12;
    const Vector2d v12 = v(u0, u1, u2, -t02, 0, -m2), v21 = v(u0, u1, u2, t01, m1, 0);

    // The blocks of the vertices: H_12, and with a minus H_11 + H_21 for 0 1, H_12 + H_22 for 0 2.
    const std::array<TangentPattern::Place, 3>& places = pattern.triangles[t];
    const Column c_1 = column(e1), c_2 = column(e2), c_n = column(normal);
    // C without v: (a b; c d). `above` and `left` are v_ki and v_ik.
    const auto add = [&](const TangentPattern::Place& place, bool swapped, double s, double a,
                         double b, double c, double d, Vector2d above, Vector2d left) {
      if (swapped) {
        std::swap(b, c);
        std::swap(above, left);
      }
      const Vector3d y1 = a * e1 + b * e2 + above[0] * normal;
      const Vector3d y2 = c * e1 + d * e2 + above[1] * normal;
      const Vector3d y3 = left[0] * e1 + left[1] * e2;
      double* block = pair_blocks_[place.pair].values;
      store(block, load(block) + y1[0] * c_1 + y2[0] * c_2 + y3[0] * c_n + Column{s, 0, 0, 0});
      store(block + 4,
            load(block + 4) + y1[1] * c_1 + y2[1] * c_2 + y3[1] * c_n + Column{0, s, 0, 0});
      store(block + 8,
            load(block + 8) + y1[2] * c_1 + y2[2] * c_2 + y3[2] * c_n + Column{0, 0, s, 0});
    };
    add(places[0], places[0].row != 0, -(s11 + s12), -(whole1 + skew1), -(skew1 + mixed),
        -(skew1 + whole), -(mixed + skew2), -(v11 + v12), -(v11 + v21));
    add(places[1], places[1].row != 0, -(s12 + s22), -(skew1 + mixed), -(whole + skew2),
        -(mixed + skew2), -(skew2 + whole2), -(v21 + v22), -(v12 + v22));
    add(places[2], places[2].row != 1, s12, skew1, whole, mixed, skew2, v21, v12);
  }
}

void Shell::spread_tangent(double* values) const {
  const TangentPattern& pattern = *tangent_pattern_;
  for (int row = 0; row < vertex_count_; ++row) {
    // The row's sum; of symmetric sums a block and its transpose are the same part.
    Column sum[3] = {};
    for (PetscInt k = pattern.rows[row]; k < pattern.rows[row + 1]; ++k) {
      if (pattern.columns[k] == row) continue;
      const double* b = pair_blocks_[pattern.pair_of[k]].values;
      double* out = values + 9 * static_cast<std::ptrdiff_t>(k);
      for (int c = 0; c < 3; ++c) sum[c] += load(b + 4 * c);
      // PETSc's blocks, too, are column-major.
      const int down = pattern.columns[k] > row ? 1 : 4, right = 5 - down;
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) out[3 * c + r] = b[right * c + down * r];
      }
    }
    double* out = values + 9 * static_cast<std::ptrdiff_t>(pattern.diagonal[row]);
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) out[3 * c + r] = -(sum[c][r] + sum[r][c]) / 2;
    }
  }
}

double Shell::volume_stiffness(Vec positions, Vec gradient) const {
  const auto array = array_of<const double>(positions, vertex_count_);
  const auto out = array_of<double>(gradient, vertex_count_);
  std::fill(out.data(), out.data() + out.size(), 0.0);
  if (open_sheet_) return 0;
  update_normals(array.data());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (const int vertex : triangles_[t]) {
      Vector3d::Map(out.data() + 3 * static_cast<std::ptrdiff_t>(vertex)) += normals_[t] / 6;
    }
  }
  return moduli_.k_v / reference_volume_;
}

}  // namespace ductile::membrane
