// Shells at rest under given forces, against exact solutions.
#include "ductile/membrane/equilibrium.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "ductile/surface/biconcave.hpp"
#include "membrane/support.hpp"

namespace ductile::membrane {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using test::Points;

Points points_of(Vec vec) {
  const VecArray<const double> x(vec);
  Points points(x.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = Vector3d::Map(&x[3 * i]);
  return points;
}

struct Solution {
  Points points;
  Equilibrium found;
};
Solution solve(const Shell& shell, const Points& force, const Points& start,
               const EquilibriumOptions& options = {}) {
  const VecPtr f = test::to_vec(force), x = test::to_vec(start);
  const Equilibrium found = find_equilibrium(shell, f.get(), x.get(), options);
  return {points_of(x.get()), found};
}

double norm(const Points& points) {
  double sum = 0;
  for (const Vector3d& p : points) sum += p.squaredNorm();
  return std::sqrt(sum);
}

// The largest change of distance between neighbours: 0 of a rigid motion.
double distortion(const Mesh& mesh, const Points& points) {
  double largest = 0;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      largest = std::max(largest, std::abs((points[a] - points[b]).norm() -
                                           (mesh.vertices[a] - mesh.vertices[b]).norm()));
    }
  }
  return largest;
}

Mesh sheet(int n) {
  Mesh mesh;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) mesh.vertices.emplace_back(i + .3 * j, .9 * j, 0);
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int v = (n + 1) * i + j;
      mesh.triangles.push_back({v, v + n + 1, v + 1});
      mesh.triangles.push_back({v + n + 1, v + n + 2, v + 1});
    }
  }
  return mesh;
}

// The rim carries the exact tractions of a uniaxial stretch: from the sheet at rest, where nothing
// but the drag resists motion out of the plane, its affine map must come back. Of Skalak's law l2^2
// = (1 + C l1^2)/(1 + C l1^4), of the neo-Hookean l2^2 = 1/l1.
TEST(Equilibrium, SheetUnderUniaxialTensionStretchesAsTheLawSays) {
  const Mesh mesh = sheet(6);
  for (const auto& [law, c, l1] : {std::tuple{StrainLaw::skalak, 2., 1.5},
                                   {StrainLaw::skalak, 50., 1.2},
                                   {StrainLaw::neo_hookean, 0., 1.5}}) {
    const double l2 = law == StrainLaw::skalak
                          ? std::sqrt((1 + c * l1 * l1) / (1 + c * std::pow(l1, 4)))
                          : 1 / std::sqrt(l1);
    const Shell shell(mesh, {.law = law, .k_s = 1, .k_a = c}, {.open_sheet = true});
    Mesh stretched = mesh;
    stretched.vertices = test::moved(mesh.vertices, Vector3d(l1, l2, 1).asDiagonal(), {0, 0, 0});
    Points force = test::forces(shell, stretched.vertices);
    for (Vector3d& f : force) {
      EXPECT_NEAR(f[1], 0, 1e-13 * (1 + c));
      f = {-f[0], 0, 0};
    }
    const Solution solution = solve(shell, force, mesh.vertices);
    EXPECT_LT(distortion(stretched, solution.points), 1e-8) << l1;
    EXPECT_EQ(solution.found.unstable_modes, 0);
  }
}

// Fixed forces p V'(x) l^2 hold a sphere at the stretch l, where p a/k_s = (2/3)[(l^2 - 1)/l + C l
// (l^4 - 1)]. The error is the mesh's.
TEST(Equilibrium, SphereUnderPressureInflatesToTheExactRadiusAtOrderTwo) {
  const double l = 1.1, pressure = .8079527;
  std::vector<double> errors;
  for (const int frequency : {3, 6}) {
    const Mesh sphere = icosphere(frequency, 1);
    const Shell shell(sphere, {.k_s = 1, .k_a = 2});
    const VecPtr gradient = shell.create_vec();
    shell.volume_stiffness(test::to_vec(sphere.vertices).get(), gradient.get());
    Points force = points_of(gradient.get());
    for (Vector3d& f : force) f *= pressure * l * l;
    const Solution solution = solve(shell, force, sphere.vertices);
    Mesh inflated = sphere;
    inflated.vertices = solution.points;
    errors.push_back(std::abs(std::cbrt(volume(inflated) / volume(sphere)) / l - 1));
    EXPECT_EQ(solution.found.unstable_modes, 0);
  }
  EXPECT_LT(errors[1], 1e-3);
  EXPECT_GT(std::log2(errors[0] / errors[1]), 1.8);
}

TEST(Equilibrium, PerturbedCellReturnsToItsReferenceShape) {
  const Mesh mesh = surface::Biconcave(3).mesh(3);
  const Shell shell(mesh, {.k_s = 1, .k_a = 5, .k_b = .1, .k_v = 2});
  test::Random random;
  const Points start =
      test::moved(test::perturbed(mesh.vertices, .15, random), random.rotation(), {5, -3, 2});
  const Solution solution = solve(shell, Points(start.size(), Vector3d::Zero()), start);
  EXPECT_GT(distortion(mesh, start), .1);
  EXPECT_LT(distortion(mesh, solution.points), 1e-7);
  EXPECT_LT(test::energies(shell, solution.points).total(), 1e-14);
  EXPECT_EQ(solution.found.unstable_modes, 0);
}

// Forces of `size` on the poles, outwards if positive.
Points pulled(const Points& vertices, double size) {
  Points force(vertices.size(), Vector3d::Zero());
  std::size_t north = 0, south = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i][2] > vertices[north][2]) north = i;
    if (vertices[i][2] < vertices[south][2]) south = i;
  }
  force[north] = size * (vertices[north] - vertices[south]).normalized();
  force[south] = -force[north];
  return force;
}

TEST(Equilibrium, HoldsTheForcesAndTheLowerEnergy) {
  const Mesh sphere = icosphere(4, 3);
  const Shell shell(sphere, {.k_s = 1, .k_a = 2, .k_b = .1, .k_v = 2});
  const Points force = pulled(sphere.vertices, 1);
  const Solution solution = solve(shell, force, sphere.vertices);
  Points rest = test::forces(shell, solution.points);
  double work = 0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    rest[i] += force[i];
    work += force[i].dot(solution.points[i] - sphere.vertices[i]);
  }
  EXPECT_LE(norm(rest), 1e-9 * norm(force));
  EXPECT_NEAR(norm(rest), solution.found.residual, 1e-12);
  EXPECT_GT(work, 1);
  EXPECT_LT(test::energies(shell, solution.points).total(), work);
  EXPECT_EQ(solution.found.unstable_modes, 0);
  EXPECT_GT(solution.found.newton_iterations, 0);
  // Turned in space it is the same.
  const Matrix3d turn = test::Random().rotation();
  const Solution turned = solve(shell, test::moved(force, turn, {0, 0, 0}),
                                test::moved(sphere.vertices, turn, {1, 2, 3}));
  const Points expected = test::moved(solution.points, turn, {1, 2, 3});
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_LT((turned.points[i] - expected[i]).norm(), 1e-6);
}

// Fixed forces that push inwards would rather turn the shell over, about either axis across.
TEST(Equilibrium, CountsTheWaysInWhichAShellWouldTurnOver) {
  const Mesh sphere = icosphere(3, 3);
  const Shell shell(sphere, {.k_s = 1, .k_a = 2, .k_b = .1, .k_v = 2});
  EXPECT_EQ(solve(shell, pulled(sphere.vertices, -.05), sphere.vertices).found.unstable_modes, 2);
  EXPECT_EQ(solve(shell, pulled(sphere.vertices, .05), sphere.vertices).found.unstable_modes, 0);
}

int negative_eigenvalues(const MatrixXd& matrix) {
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  // Motions that cost nothing have 0 to round-off.
  return static_cast<int>((values.array() < -1e-10 * matrix.norm()).count());
}

// Compressed from all sides, with almost all of it borne by the volume, a shell is unstable in many
// ways; but its radius is held, and by the volume's dense part alone.
TEST(Equilibrium, CountsTheNegativeEigenvaluesOfTheWholeTangent) {
  const Mesh sphere = icosphere(3, 3);
  const Shell shell(sphere, {.k_s = .01, .k_a = .02, .k_b = .01, .k_v = 2});
  const VecPtr gradient = shell.create_vec();
  shell.volume_stiffness(test::to_vec(sphere.vertices).get(), gradient.get());
  Points force = points_of(gradient.get());
  for (Vector3d& f : force) f *= -.1;
  const Solution solution = solve(shell, force, sphere.vertices);
  const int whole = negative_eigenvalues(test::whole_tangent(shell, solution.points));
  EXPECT_EQ(solution.found.unstable_modes, whole);
  EXPECT_EQ(negative_eigenvalues(test::sparse_tangent(shell, solution.points)), whole + 1);
  EXPECT_GT(whole, 3);
}

TEST(Equilibrium, ShellAtRestNeedsNoStep) {
  const Mesh mesh = surface::Biconcave(3).mesh(3);
  const Shell shell(mesh, {.k_s = 1, .k_a = 2, .k_b = .1, .k_v = 2});
  const Solution solution =
      solve(shell, Points(mesh.vertices.size(), Vector3d::Zero()), mesh.vertices);
  EXPECT_EQ(solution.found.steps, 0);
  EXPECT_EQ(solution.found.unstable_modes, 0);
}

TEST(EquilibriumFailure, TellsWhatTheSearchCameTo) {
  const Mesh sphere = icosphere(3, 3);
  const Shell shell(sphere, {.k_s = 1, .k_a = 2, .k_b = .1, .k_v = 2});
  const VecPtr f = test::to_vec(pulled(sphere.vertices, 1)), x = test::to_vec(sphere.vertices);
  try {
    find_equilibrium(shell, f.get(), x.get(), {.max_steps = 2});
    FAIL() << "converged in two steps";
  } catch (const EquilibriumFailure& failure) {
    EXPECT_EQ(failure.reason(), EquilibriumFailure::Reason::max_steps);
    EXPECT_GT(failure.newton_iterations(), 1);
    Points rest = test::forces(shell, points_of(x.get()));
    const Points force = points_of(f.get());
    for (std::size_t i = 0; i < rest.size(); ++i) rest[i] += force[i];
    EXPECT_NEAR(failure.residual(), norm(rest), 1e-12);
    EXPECT_LT(failure.residual(), norm(force));
    test::expect_contains(failure.what(), "max_steps used up; residual force ");
  }
  // It goes on from there.
  EXPECT_LT(find_equilibrium(shell, f.get(), x.get()).residual, 2e-9);
}

TEST(EquilibriumFailure, OptionsOfPetscAreObeyed) {
  const Mesh sphere = icosphere(3, 3);
  const Shell shell(sphere, {.k_s = 1, .k_a = 2, .k_b = .1, .k_v = 2});
  petsc_check(PetscOptionsSetValue(nullptr, "-membrane_static_snes_max_it", "0"));
  try {
    solve(shell, pulled(sphere.vertices, 1), sphere.vertices);
    ADD_FAILURE() << "converged without an iteration";
  } catch (const EquilibriumFailure& failure) {
    EXPECT_EQ(failure.reason(), EquilibriumFailure::Reason::no_descent);
    EXPECT_EQ(failure.latest(), SNES_DIVERGED_MAX_IT);
    EXPECT_EQ(failure.newton_iterations(), 0);
    test::expect_contains(failure.what(), "no step lowers the energy");
  }
  petsc_check(PetscOptionsClearValue(nullptr, "-membrane_static_snes_max_it"));
}

TEST(EquilibriumRefusal, NamesWhatIsWrong) {
  const Mesh sphere = icosphere(2, 3);
  const Shell shell(sphere, {.k_s = 1, .k_a = 2});
  const Points none(sphere.vertices.size(), Vector3d::Zero());
  Points lone = none;
  lone[3] = {1, 0, 0};
  test::expect_contains(test::refusal([&] { solve(shell, lone, sphere.vertices); }),
                        "the forces are not balanced: their sum is 1 in total, against 1");
  Points couple = none;
  couple[0] = sphere.vertices[0].unitOrthogonal();
  for (std::size_t i = 0; i < none.size(); ++i) {
    if ((sphere.vertices[i] + sphere.vertices[0]).norm() < 1e-9) couple[i] = -couple[0];
  }
  test::expect_contains(test::refusal([&] { solve(shell, couple, sphere.vertices); }),
                        "the forces are not balanced: their torque is 6 in total, against 6");
  Points unknown = none;
  unknown[0][0] = std::nan("");
  test::expect_contains(test::refusal([&] { solve(shell, unknown, sphere.vertices); }),
                        "not balanced");
  test::expect_contains(test::refusal([&] { solve(shell, Points(3), sphere.vertices); }),
                        "a vector of 9 numbers for 42 vertices");
  Points collapsed = sphere.vertices;
  const auto& triangle = sphere.triangles[0];
  collapsed[triangle[0]] = (collapsed[triangle[1]] + collapsed[triangle[2]]) / 2;
  collapsed[triangle[1]] = collapsed[triangle[0]];
  const Shell bending(sphere, {.k_b = 1});
  test::expect_contains(test::refusal([&] { solve(bending, none, collapsed); }), "has collapsed");
  const Shell limp(sphere, {.k_v = 1});
  test::expect_contains(test::refusal([&] { solve(limp, none, sphere.vertices); }),
                        "resists no deformation");
  test::expect_contains(
      test::refusal([&] { solve(shell, none, sphere.vertices, {.tolerance = 0}); }),
      "tolerance = 0 must be positive");
  test::expect_contains(
      test::refusal([&] { solve(shell, none, sphere.vertices, {.max_steps = 0}); }),
      "max_steps = 0 must be at least 1");
}

}  // namespace
}  // namespace ductile::membrane
