// The tangent against the force's differences, PETSc's own Jacobian test, and the identities that a
// Hessian of an invariant energy obeys.
#include <gtest/gtest.h>
#include <petscsnes.h>

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <string>
#include <vector>

#include "ductile/surface/biconcave.hpp"
#include "membrane/support.hpp"

namespace ductile::membrane {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::Points;
using test::sparse_tangent;
using test::whole_tangent;

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
Mesh reference(Form form, int frequency) {
  if (form == Form::sphere) return icosphere(frequency, frequency / 1.2);
  if (form == Form::biconcave) return surface::Biconcave(frequency / 1.2).mesh(frequency);
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
  explicit Deformed(const Case& c, int frequency = 4)
      : mesh(reference(c.form, frequency)),
        shell(mesh, c.moduli, {.open_sheet = c.form == Form::sheet}) {
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

// Steps of 1e-3 edges leave about 1e-11.
TEST_P(Tangent, IsTheDerivativeOfTheForce) {
  const Deformed d(GetParam());
  const MatrixXd k = whole_tangent(d.shell, d.points);
  const MatrixXd differences = difference_tangent(d.shell, d.points, 1e-3);
  EXPECT_LT((k - differences).norm(), 1e-9 * k.norm());
}

// What PETSc's vectors and callbacks hold in the next test.
struct Problem {
  const Shell* shell;
  MatPtr sparse;
  VecPtr gradient;
  double c = 0;
};

PetscErrorCode residual(SNES /*snes*/, Vec x, Vec f, void* context) {
  static_cast<const Problem*>(context)->shell->force(x, f);
  return VecScale(f, -1);
}
PetscErrorCode jacobian(SNES /*snes*/, Vec x, Mat /*whole*/, Mat /*sparse*/, void* context) {
  auto& problem = *static_cast<Problem*>(context);
  problem.shell->tangent(x, problem.sparse.get());
  problem.c = problem.shell->volume_stiffness(x, problem.gradient.get());
  return 0;
}
PetscErrorCode multiply(Mat whole, Vec in, Vec out) {
  void* context = nullptr;
  PetscCall(MatShellGetContext(whole, &context));
  const auto& problem = *static_cast<const Problem*>(context);
  PetscCall(MatMult(problem.sparse.get(), in, out));
  double product = 0;
  PetscCall(VecDot(problem.gradient.get(), in, &product));
  return VecAXPY(out, problem.c * product, problem.gradient.get());
}

std::string printed;
PetscErrorCode capture(FILE* /*file*/, const char* format, va_list arguments) {
  char line[4096];
  size_t length = 0;
  PetscCall(PetscVSNPrintf(line, sizeof line, format, &length, arguments));
  printed += line;
  return 0;
}

// PETSc differences forward with steps of 1.5e-8 |x|, |x| of all coordinates, which leaves about
// 1e-7.
TEST_P(Tangent, PassesPetscsJacobianTest) {
  const Deformed d(GetParam(), 2);
  Problem problem{&d.shell, d.shell.create_tangent(), d.shell.create_vec()};
  const VecPtr x = test::to_vec(d.points), f = d.shell.create_vec();
  const auto n = static_cast<PetscInt>(3 * d.points.size());
  Mat mat = nullptr;
  petsc_check(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, &problem, &mat));
  const MatPtr whole(mat);
  petsc_check(
      MatShellSetOperation(whole.get(), MATOP_MULT, reinterpret_cast<void (*)()>(&multiply)));
  SNES snes = nullptr;
  petsc_check(SNESCreate(PETSC_COMM_SELF, &snes));
  petsc_check(SNESSetOptionsPrefix(snes, "tangent_"));
  petsc_check(SNESSetFunction(snes, f.get(), &residual, &problem));
  Mat of_snes = GetParam().moduli.k_v > 0 ? whole.get() : problem.sparse.get();
  petsc_check(SNESSetJacobian(snes, of_snes, problem.sparse.get(), &jacobian, &problem));
  petsc_check(PetscOptionsSetValue(nullptr, "-tangent_snes_test_jacobian", nullptr));
  petsc_check(SNESSetFromOptions(snes));
  // A step of Richardson's in place of a Newton step: the tangent may be singular.
  petsc_check(SNESSetTolerances(snes, 0, 0, 0, 1, 10));
  KSP ksp = nullptr;
  petsc_check(SNESGetKSP(snes, &ksp));
  petsc_check(KSPSetType(ksp, KSPPREONLY));
  PC pc = nullptr;
  petsc_check(KSPGetPC(ksp, &pc));
  petsc_check(PCSetType(pc, PCNONE));
  printed.clear();
  const auto standard = PetscVFPrintf;
  PetscVFPrintf = &capture;
  const PetscErrorCode code = SNESSolve(snes, nullptr, x.get());
  PetscVFPrintf = standard;
  petsc_check(PetscOptionsClearValue(nullptr, "-tangent_snes_test_jacobian"));
  petsc_check(code);
  petsc_check(SNESDestroy(&snes));
  const auto at = printed.find("||J - Jfd||_F/||J||_F = ");
  ASSERT_NE(at, std::string::npos) << printed;
  const double ratio = std::stod(printed.substr(at + 24));
  EXPECT_LT(ratio, 1e-6);
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

TEST(TangentMatrix, HoldsNeighboursAndTheVerticesAcrossEdgesAndNoMore) {
  const Mesh mesh = icosphere(4, 1);
  const MatPtr k = Shell(mesh, {.k_b = 1}).create_tangent();
  const auto vertices = static_cast<double>(mesh.vertices.size()), edges = 3 * (vertices - 2);
  MatInfo info;
  petsc_check(MatGetInfo(k.get(), MAT_LOCAL, &info));
  EXPECT_EQ(info.nz_used, 9 * (vertices + 4 * edges));
  EXPECT_EQ(info.nz_allocated, info.nz_used);
  EXPECT_EQ(info.mallocs, 0);
}

// Every pair of an octahedron's vertices that no edge joins faces one another across four edges.
TEST(TangentMatrix, SumsTheEdgesThatTwoVerticesFaceAcross) {
  Mesh mesh{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}, {}};
  for (const int x : {0, 1}) {
    for (const int y : {2, 3}) {
      for (const int z : {4, 5}) {
        if ((x + y + z) % 2 == 0) {
          mesh.triangles.push_back({x, y, z});
        } else {
          mesh.triangles.push_back({x, z, y});
        }
      }
    }
  }
  test::Random random;
  const Points points = test::perturbed(mesh.vertices, .1, random);
  const Shell shell(mesh, {.k_s = 1, .k_a = 2, .k_b = .3, .k_v = 3});
  const MatrixXd k = whole_tangent(shell, points);
  EXPECT_LT((k - difference_tangent(shell, points, 1e-3)).norm(), 1e-9 * k.norm());
}

// Two triangles on the same three vertices: those that face across an edge are one.
TEST(TangentMatrix, OfAFlatBagIsRight) {
  const Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {.3, .8, .1}}, {{0, 1, 2}, {0, 2, 1}}};
  test::Random random;
  const Points points = test::perturbed(mesh.vertices, .1, random);
  const Shell shell(mesh, {.k_s = 1, .k_b = .3},
                    {.flat_reference_angles = true, .open_sheet = true});
  const MatrixXd k = whole_tangent(shell, points);
  EXPECT_LT((k - difference_tangent(shell, points, 1e-3)).norm(), 1e-9 * k.norm());
}

// k_v/V0 (V - V0) g is the gradient of the volume energy.
TEST(TangentMatrix, VolumeStiffnessIsThatOfTheVolumeEnergy) {
  const Deformed d({"", {.k_v = 2}, Form::biconcave});
  const VecPtr x = test::to_vec(d.points), gradient = d.shell.create_vec();
  const double c = d.shell.volume_stiffness(x.get(), gradient.get());
  EXPECT_EQ(c, 2 / d.shell.reference_volume());
  const double excess = d.shell.shape(x.get()).volume - d.shell.reference_volume();
  const VecArray<const double> g(gradient.get());
  const VectorXd f = flat(test::forces(d.shell, d.points));
  for (Eigen::Index i = 0; i < f.size(); ++i)
    EXPECT_NEAR(c * excess * g[i], -f[i], 1000 * eps * f.lpNorm<Eigen::Infinity>());
}

TEST(TangentMatrix, OpenSheetHasNoVolumeStiffness) {
  const Deformed d({"", {.k_s = 2}, Form::sheet});
  const VecPtr gradient = d.shell.create_vec();
  petsc_check(VecSet(gradient.get(), 1));
  EXPECT_EQ(d.shell.volume_stiffness(test::to_vec(d.points).get(), gradient.get()), 0);
  double norm = 1;
  petsc_check(VecNorm(gradient.get(), NORM_INFINITY, &norm));
  EXPECT_EQ(norm, 0);
}

// PETSc keeps inverses and factors until it hears that the values have changed.
TEST(TangentMatrix, NewValuesReachASolver) {
  const Deformed d({"", {.k_s = 1, .k_a = 2, .k_b = .3}, Form::sphere});
  const VecPtr x = test::to_vec(d.points), y = d.shell.create_vec();
  test::Random random;
  const VecPtr b = test::to_vec(test::perturbed(Points(d.points.size()), 1, random));
  const MatPtr k = d.shell.create_tangent();
  for (const char* type : {PCPBJACOBI, PCLU}) {
    KSP ksp = nullptr;
    petsc_check(KSPCreate(PETSC_COMM_SELF, &ksp));
    PC pc = nullptr;
    petsc_check(KSPGetPC(ksp, &pc));
    petsc_check(PCSetType(pc, type));
    petsc_check(KSPSetType(ksp, KSPPREONLY));
    std::vector<double> norms;
    for (const double scale : {1., 2.}) {
      const VecPtr scaled = d.shell.create_vec();
      petsc_check(VecAXPY(scaled.get(), scale, x.get()));
      d.shell.tangent(scaled.get(), k.get());
      petsc_check(MatShift(k.get(), 1));
      petsc_check(KSPSetOperators(ksp, k.get(), k.get()));
      petsc_check(KSPSolve(ksp, b.get(), y.get()));
      double norm = 0;
      petsc_check(VecNorm(y.get(), NORM_2, &norm));
      norms.push_back(norm);
    }
    petsc_check(KSPDestroy(&ksp));
    EXPECT_GT(std::abs(norms[1] / norms[0] - 1), .01) << type;
  }
}

TEST(TangentMatrix, OfAnotherShellIsRefused) {
  const Shell shell(icosphere(3, 1), {.k_s = 1});
  const VecPtr x = test::to_vec(icosphere(3, 1).vertices);
  const MatPtr other = Shell(icosphere(4, 1), {.k_s = 1}).create_tangent();
  test::expect_contains(test::refusal([&] { shell.tangent(x.get(), other.get()); }),
                        "is not one that create_tangent() of this shell made");
  Mat dense = nullptr;
  const PetscInt n = 3 * shell.vertex_count();
  petsc_check(MatCreateSeqDense(PETSC_COMM_SELF, n, n, nullptr, &dense));
  const MatPtr owner(dense);
  test::expect_contains(test::refusal([&] { shell.tangent(x.get(), dense); }),
                        "is not one that create_tangent() of this shell made");
  const MatPtr own = shell.create_tangent();
  const VecPtr too_long = create_vec(shell.vertex_count() + 1);
  test::expect_contains(test::refusal([&] { shell.tangent(too_long.get(), own.get()); }),
                        "a vector of");
}

}  // namespace
}  // namespace ductile::membrane
