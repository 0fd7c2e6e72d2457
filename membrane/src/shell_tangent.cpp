// The Hessian of the shell's energy. Notation: vertices 0, 1, 2 of a triangle, e1 and e2 its edges
// from 0 to 1 and 2, n = e1 x e2, N = n/|n|.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "ductile/membrane/shell.hpp"
#include "shell_math.hpp"

namespace ductile::membrane {
namespace {

using Eigen::Matrix3d;
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

// PETSc's blocks, too, are column-major within.
Eigen::Map<Matrix3d> block(double* values, int slot) {
  return Matrix3d::Map(values + 9 * static_cast<std::ptrdiff_t>(slot));
}

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

}  // namespace

// Only the upper triangle of the matrix is summed; mirror() makes the lower one.
struct Shell::TangentPattern {
  // The block of two vertices that lies above the diagonal.
  struct Pair {
    int slot;
    bool swapped;  // it is that of (second, first)
    void add(double* values, const Matrix3d& matrix) const {
      if (swapped) {
        block(values, slot) += matrix.transpose();
      } else {
        block(values, slot) += matrix;
      }
    }
  };
  struct Triangle {
    std::array<int, 3> diagonal;
    std::array<Pair, 3> pairs;  // vertices 0 1, 0 2, 1 2
  };
  struct Hinge {
    std::array<int, 4> vertices;  // tail, head, the left triangle's other, the right one's
    std::array<int, 4> diagonal;
    struct Ordered {
      int slot;
      int row, column;  // in `vertices`
    };
    // Tail with head comes first, left with right last.
    std::array<Ordered, 6> pairs;
  };
  struct Mirror {
    int upper, lower;
  };
  std::vector<PetscInt> rows, columns;  // compressed
  std::vector<Triangle> triangles;
  std::vector<Hinge> hinges;
  std::vector<int> diagonals;
  std::vector<Mirror> mirrors;

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

    for (const auto& v : shell.triangles_) {
      triangles.push_back({{slot(v[0], v[0]), slot(v[1], v[1]), slot(v[2], v[2])},
                           {pair(v[0], v[1]), pair(v[0], v[2]), pair(v[1], v[2])}});
    }
    for (Hinge& hinge : hinges) {
      for (int a = 0; a < 4; ++a) hinge.diagonal[a] = slot(hinge.vertices[a], hinge.vertices[a]);
      int number = 0;
      for (int a = 0; a < 4; ++a) {
        for (int b = a + 1; b < 4; ++b) {
          const Pair p = pair(hinge.vertices[a], hinge.vertices[b]);
          hinge.pairs[number++] = {p.slot, p.swapped ? b : a, p.swapped ? a : b};
        }
      }
    }
    for (int row = 0; row < shell.vertex_count_; ++row) {
      diagonals.push_back(slot(row, row));
      for (PetscInt k = rows[row]; k < rows[row + 1]; ++k) {
        if (columns[k] > row) mirrors.push_back({k, slot(columns[k], row)});
      }
    }
  }

  void mirror(double* values) const {
    for (const int slot : diagonals) {
      double* m = block(values, slot).data();
      m[1] = m[3];
      m[2] = m[6];
      m[5] = m[7];
    }
    for (const auto& [upper, lower] : mirrors) {
      block(values, lower) = block(values, upper).transpose();
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
  [[nodiscard]] Pair pair(int first, int second) const {
    return first < second ? Pair{slot(first, second), false} : Pair{slot(second, first), true};
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
    std::fill_n(values.data(), 9 * pattern.columns.size(), 0.0);
    const double volume = update_normals(array.data());
    add_hinge_tangents(array.data(), pressure(volume), values.data());
    add_triangle_tangents(array.data(), values.data());
    pattern.mirror(values.data());
  }
  // Tells solvers that the values, which they may hold factors of, are new.
  petsc_check(MatAssemblyBegin(tangent, MAT_FINAL_ASSEMBLY));
  petsc_check(MatAssemblyEnd(tangent, MAT_FINAL_ASSEMBLY));
}

// The volume's part, and of the bending's (E'' g g^T + E' dg/dx, g = dtheta/dx) the first; fills
// moments_ for the second.
void Shell::add_hinge_tangents(const double* x, double p, double* values) const {
  const TangentPattern& pattern = tangent_pattern();
  const double stiffness = sqrt3 * moduli_.k_b;
  for (std::size_t h = 0; h < hinges_.size(); ++h) {
    const Hinge& hinge = hinges_[h];
    const TangentPattern::Hinge& place = pattern.hinges[h];
    const Vector3d tail = point(x, hinge.tail);
    const Vector3d left = point(x, place.vertices[2]) - tail;
    const Vector3d right = point(x, place.vertices[3]) - tail;

    if (p != 0) {
      // d2V/dx_tail dx_head = [x_right - x_left]/6 with [a] b = a x b. No other blocks of V are
      // other than 0.
      const double sign = hinge.tail < hinge.head ? 1 : -1;
      block(values, place.pairs[0].slot) += cross_matrix(sign * p / 6 * (right - left));
    }

    if (stiffness == 0) continue;
    const Angle theta = angle(hinge, x);
    const double sine = theta.sin * hinge.cos0 - theta.cos * hinge.sin0;
    const double cosine = theta.cos * hinge.cos0 + theta.sin * hinge.sin0;
    moments_[h] = stiffness * sine * theta.inverse_length;

    // Of each triangle, g is -N/H of the vertex at the height H over the edge, and N/H times the
    // barycentric coordinates (1 - beta, beta) of that height's foot for the edge's ends.
    const Vector3d edge = point(x, hinge.head) - tail;
    const double inverse_square = theta.inverse_length * theta.inverse_length;
    const double length = edge.squaredNorm() * theta.inverse_length;
    const double left_scale = length * inverse_norms_[hinge.left] * inverse_norms_[hinge.left];
    const double right_scale = length * inverse_norms_[hinge.right] * inverse_norms_[hinge.right];
    const Vector3d a = left_scale * normals_[hinge.left], b = right_scale * normals_[hinge.right];
    const double beta_a = left.dot(edge) * inverse_square;
    const double beta_b = right.dot(edge) * inverse_square;
    const std::array<Vector3d, 4> g = {(1 - beta_a) * a + (1 - beta_b) * b, beta_a * a + beta_b * b,
                                       -a, -b};
    const double second = stiffness * cosine;
    const std::array<Vector3d, 4> g2 = {second * g[0], second * g[1], second * g[2], second * g[3]};
    for (int k = 0; k < 4; ++k) block(values, place.diagonal[k]) += g2[k] * g[k].transpose();
    for (const auto& [slot, row, column] : place.pairs) {
      block(values, slot) += g2[row] * g[column].transpose();
    }
  }
}

// The strain's part and the bending's second.
void Shell::add_triangle_tangents(const double* x, double* values) const {
  const TangentPattern& pattern = tangent_pattern();
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& [v0, v1, v2] = triangles_[t];
    const Element& e = elements_[t];
    const Vector3d e1 = point(x, v1) - point(x, v0), e2 = point(x, v2) - point(x, v0);
    const double g11 = e1.squaredNorm(), g12 = e1.dot(e2), g22 = e2.squaredNorm();
    const double norm = inverse_norms_[t];
    const Vector3d normal = norm * normals_[t];

    // Neither part changes under a translation, so that only the derivatives with respect to e1 and
    // e2, i and k below, are needed. Both are of the form
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
      return Eigen::Vector2d(norm * (-p2 * u0 + g22 * u1 - g12 * u2 + t0 - t2),
                             norm * (-p1 * u0 - g12 * u1 + g11 * u2 - t0 + t1));
    };
    const double half0 = m0 * l0 / 2, half1 = m1 * l1 / 2, half2 = m2 * l2 / 2;
    const double w0 = m0 * l0 * r2, w1 = m1 * r2, w2 = m2 * r2;
    const double t01 = m0 * p2 * l0, t02 = m0 * p1 * l0;
    const Eigen::Vector2d v11 = v(w0 * p2 * p2 + half0, w1 * g22, w2 * g12 * g12 * l2 + half2,  //
                                  -t01, 0, m2 * g12 * l2);
    const Eigen::Vector2d v22 = v(w0 * p1 * p1 + half0, w1 * g12 * g12 * l1 + half1, w2 * g11,  //
                                  t02, -m1 * g12 * l1, 0);
    const double u0 = w0 * p1 * p2 - half0, u1 = -w1 * g12, u2 = -w2 * g12;
    const Eigen::Vector2d v12 = v(u0, u1, u2, -t02, 0, -m2), v21 = v(u0, u1, u2, t01, m1, 0);

    const auto hessian = [&](double s, double c00, double c01, double c10, double c11_,
                             const Eigen::Vector2d& v_ik, const Eigen::Vector2d& v_ki) {
      Matrix3d h = e1 * (c00 * e1 + c01 * e2 + v_ki[0] * normal).transpose() +
                   e2 * (c10 * e1 + c11_ * e2 + v_ki[1] * normal).transpose() +
                   normal * (v_ik[0] * e1 + v_ik[1] * e2).transpose();
      h.diagonal().array() += s;
      return h;
    };
    const Matrix3d h11 = hessian(s11, whole1, skew1, skew1, mixed, v11, v11);
    const Matrix3d h12 = hessian(s12, skew1, whole, mixed, skew2, v12, v21);
    const Matrix3d h22 = hessian(s22, mixed, skew2, skew2, whole2, v22, v22);
    const Matrix3d h01 = -(h11 + h12.transpose()), h02 = -(h12 + h22);

    const TangentPattern::Triangle& place = pattern.triangles[t];
    block(values, place.diagonal[0]) -= h01 + h02;
    block(values, place.diagonal[1]) += h11;
    block(values, place.diagonal[2]) += h22;
    place.pairs[0].add(values, h01);
    place.pairs[1].add(values, h02);
    place.pairs[2].add(values, h12);
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
