// The tangent against the force's differences, PETSc's own Jacobian test, and the identities that a
// Hessian of an invariant energy obeys.
#include <gtest/gtest.h>
#include <petscsnes.h>

#include <cmath>
#include <string>
#include <vector>

#include "membrane/support.hpp"

namespace ductile::membrane {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::Points;

constexpr double eps = 2.2e-16;

VectorXd flat(const Points& points) {
  VectorXd all(3 * points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    all.segment<3>(3 * static_cast<Eigen::Index>(i)) = points[i];
  return all;
}

Points points_of(const VectorXd& all) {
  Points points(all.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = all.segment<3>(3 * static_cast<Eigen::Index>(i));
  return points;
}

MatrixXd dense(Mat mat) {
  PetscInt rows = 0, columns = 0;
  petsc_check(MatGetSize(mat, &rows, &columns));
  MatrixXd result = MatrixXd::Zero(rows, columns);
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

MatrixXd sparse_tangent(const Shell& shell, const Points& points) {
  const MatPtr k = shell.create_tangent();
  shell.tangent(test::to_vec(points).get(), k.get());
  return dense(k.get());
}

MatrixXd whole_tangent(const Shell& shell, const Points& points) {
  const VecPtr gradient = shell.create_vec();
  const double c = shell.volume_stiffness(test::to_vec(points).get(), gradient.get());
  const VecArray<const double> array(gradient.get());
  const auto g = VectorXd::Map(array.data(), static_cast<Eigen::Index>(array.size()));
  return sparse_tangent(shell, points) + c * g * g.transpose();
}

// -dF/dx. Central differences of two steps, extrapolated: the rest is of order h^4, the round-off
// eps/h.
MatrixXd difference_tangent(const Shell& shell, const Points& points, double h) {
  const auto n = static_cast<Eigen::Index>(3 * points.size());
  MatrixXd result(n, n);
  const VectorXd x = flat(points);
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto central = [&](double step) -> VectorXd {
      VectorXd up = x, down = x;
      up[j] += step;
      down[j] -= step;
      return (flat(test::forces(shell, points_of(down))) -
              flat(test::forces(shell, points_of(up)))) /
             (up[j] - down[j]);
    };
    result.col(j) = (4 * central(h) - central(2 * h)) / 3;
  }
  return result;
}

enum class Form { sphere, biconcave, sheet };

struct Case {
  const char* name;
  Moduli moduli;
  Form form;
};

// Edges of about 1.
Mesh reference(Form form) {
  if (form == Form::sphere) return icosphere(4, 4 / 1.2);
  if (form == Form::biconcave) return biconcave(4, 4 / 1.2);
  Mesh mesh;
  for (int i = 0; i <= 6; ++i) {
    for (int j = 0; j <= 5; ++j) mesh.vertices.emplace_back(i + .5 * j, .9 * j, 0);
  }
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 5; ++j) {
      const int v = 6 * i + j;
      mesh.triangles.push_back({v, v + 6, v + 1});
      mesh.triangles.push_back({v + 6, v + 7, v + 1});
    }
  }
  return mesh;
}

struct Deformed {
  explicit Deformed(const Case& c)
      : mesh(reference(c.form)), shell(mesh, c.moduli, {.open_sheet = c.form == Form::sheet}) {
    test::Random random;
    // A stretch first, lest the whole stay near its volume.
    points = test::perturbed(
        test::moved(mesh.vertices, Vector3d(1.1, .95, 1.05).asDiagonal(), {1, 2, 3}), .05, random);
  }
  Mesh mesh;
  Shell shell;
  Points points;
};

class Tangent : public testing::TestWithParam<Case> {};

INSTANTIATE_TEST_SUITE_P(
    Membrane, Tangent,
    testing::Values(
        Case{"SkalakSphere", {.k_s = 1, .k_a = 2}, Form::sphere},
        Case{"SkalakCell", {.k_s = 1, .k_a = 2}, Form::biconcave},
        Case{"SkalakSheet", {.k_s = 1, .k_a = 2}, Form::sheet},
        Case{"NeoHookeanSphere", {.law = StrainLaw::neo_hookean, .k_s = 1}, Form::sphere},
        Case{"NeoHookeanCell", {.law = StrainLaw::neo_hookean, .k_s = 1}, Form::biconcave},
        Case{"NeoHookeanSheet", {.law = StrainLaw::neo_hookean, .k_s = 1}, Form::sheet},
        Case{"BendingSphere", {.k_b = 1}, Form::sphere},
        Case{"BendingCell", {.k_b = 1}, Form::biconcave},
        Case{"BendingSheet", {.k_b = 1}, Form::sheet},
        Case{"VolumeSphere", {.k_v = 1}, Form::sphere},
        Case{"VolumeCell", {.k_v = 1}, Form::biconcave},
        Case{"AllSphere", {.k_s = 1, .k_a = 2, .k_b = .3, .k_v = 3}, Form::sphere},
        Case{"AllCell",
             {.law = StrainLaw::neo_hookean, .k_s = 1, .k_b = .3, .k_v = 3},
             Form::biconcave},
        Case{"AllSheet", {.k_s = 1, .k_a = 2, .k_b = .3}, Form::sheet}),
    [](const auto& c) { return std::string(c.param.name); });

// Steps of 2e-3 edges: h^4 leaves about 1e-10 and round-off 1e-12.
TEST_P(Tangent, IsTheDerivativeOfTheForce) {
  const Deformed d(GetParam());
  const MatrixXd k = whole_tangent(d.shell, d.points);
  const MatrixXd differences = difference_tangent(d.shell, d.points, 1e-3);
  EXPECT_LT((k - differences).norm(), 1e-8 * k.norm());
}

TEST_P(Tangent, IsSymmetricToTheLastBit) {
  const Deformed d(GetParam());
  const MatrixXd k = sparse_tangent(d.shell, d.points);
  EXPECT_GT(k.norm(), 0);
  EXPECT_EQ((k - k.transpose()).lpNorm<Eigen::Infinity>(), 0);
}

TEST_P(Tangent, DoesNotResistTranslations) {
  const Deformed d(GetParam());
  const MatrixXd k = sparse_tangent(d.shell, d.points);
  for (int axis = 0; axis < 3; ++axis) {
    const VectorXd shift = Vector3d::Unit(axis).replicate(d.points.size(), 1);
    EXPECT_LT((k * shift).norm(), 100 * eps * k.norm()) << axis;
  }
}

// F(R x) = R F(x) for an infinitesimal rotation: K (omega x x) = -omega x F.
TEST_P(Tangent, TurnsTheForceWithTheShell) {
  const Deformed d(GetParam());
  const MatrixXd k = sparse_tangent(d.shell, d.points);
  const Points f = test::forces(d.shell, d.points);
  for (int axis = 0; axis < 3; ++axis) {
    Points turn = d.points, expected = f;
    for (Vector3d& x : turn) x = Vector3d::Unit(axis).cross(x);
    for (Vector3d& x : expected) x = -Vector3d::Unit(axis).cross(x);
    EXPECT_LT((k * flat(turn) - flat(expected)).norm(), 100 * eps * k.norm() * flat(turn).norm())
        << axis;
    EXPECT_GT(flat(expected).norm(), 1e-3 * k.norm());
  }
}

TEST_P(Tangent, TurnsWithTheShell) {
  const Deformed d(GetParam());
  test::Random random;
  const Matrix3d rotation = random.rotation();
  const MatrixXd k = sparse_tangent(d.shell, d.points);
  const MatrixXd turned = sparse_tangent(d.shell, test::moved(d.points, rotation, {3, -2, 1}));
  const auto n = static_cast<Eigen::Index>(3 * d.points.size());
  MatrixXd all = MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; i += 3) all.block<3, 3>(i, i) = rotation;
  EXPECT_LT((turned - all * k * all.transpose()).norm(), 1000 * eps * k.norm());
}

}  // namespace
}  // namespace ductile::membrane
