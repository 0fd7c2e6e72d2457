// All integrators, in a fluid of a few lines: a linear flow in which each vertex drifts with its
// own force. What holds for each, the order of each, and what implicit ones add.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "ductile/membrane/capsule.hpp"
#include "membrane/linear_fluid.hpp"
#include "membrane/own_integrator.hpp"
#include "membrane/support.hpp"

namespace ductile::membrane {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::LinearFluid;
using test::Points;

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double area_per_vertex = 4 * 3.14159265358979 * 25 / 252;
// As the lattice's: 0.19 per area for smooth forces, and a mobility of 0.006.
constexpr double drag = 0.19 / area_per_vertex;

Moduli moduli_of(double k_s) {
  return {.k_s = k_s, .k_a = 2 * k_s, .k_b = 2.87e-3 * 25 * k_s, .k_v = 1};
}

Matrix3d shear(double rate) {
  Matrix3d gradient = Matrix3d::Zero();
  gradient(0, 2) = rate;
  return gradient;
}

/// A sphere of radius 5 about (10, 11, 12), its integrator by name.
class Sphere {
 public:
  explicit Sphere(std::string_view integrator, const Moduli& moduli,
                  const IntegratorOptions& options = {}, double step = 1,
                  const Matrix3d& map = Matrix3d::Identity(), int frequency = 5)
      : mesh(icosphere(frequency, 5)),
        capsule(mesh, test::moved(mesh.vertices, map, centre), moduli,
                {.mobility = 1e-3 * step,
                 .viscosity = 1. / 6,
                 .integrator = make_integrator(integrator, options)}) {}
  static inline const Vector3d centre{10, 11, 12};
  Mesh mesh;
  Capsule capsule;
};

Vector3d total(std::span<const double> vectors) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < vectors.size(); k += 3) sum += Vector3d::Map(&vectors[k]);
  return sum;
}

/// Solid-body rotation that fits the velocities best, about the centre: for a sphere of vertices
/// with sum r r^T = (sum r^2/3) 1 it is 3 sum r x v/(2 sum r^2).
Vector3d rotation(const Capsule& capsule) {
  const Vector3d centre = capsule.shape().centroid;
  Vector3d moment = Vector3d::Zero();
  double square = 0;
  for (std::size_t k = 0; k < capsule.positions().size(); k += 3) {
    const Vector3d r = Vector3d::Map(&capsule.positions()[k]) - centre;
    moment += r.cross(Vector3d::Map(&capsule.velocities()[k]));
    square += r.squaredNorm();
  }
  return 1.5 * moment / square;
}

class EachIntegrator : public testing::TestWithParam<std::string_view> {
 protected:
  [[nodiscard]] bool implicit() const { return GetParam().ends_with("implicit"); }
};

std::string label(const testing::TestParamInfo<std::string_view>& info) {
  std::string name;
  for (const char c : info.param) name += c == '-' ? '_' : c;
  return name;
}
INSTANTIATE_TEST_SUITE_P(All, EachIntegrator, testing::ValuesIn(integrator_names()), label);

TEST_P(EachIntegrator, CarriesACapsuleAtRestWithAUniformFlow) {
  Sphere sphere(GetParam(), moduli_of(.5));
  const LinearFluid fluid{.flow = {.01, -.02, .05}, .drag = drag};
  for (int n = 0; n < 200; ++n) fluid.step(sphere.capsule);
  // Round-off of positions of size 20, step by step; implicit ones add what their solver may leave
  // of the force of that round-off.
  EXPECT_LT((sphere.capsule.shape().centroid - Sphere::centre - 200 * fluid.flow).norm(),
            200 * 100 * eps);
  EXPECT_LT(sphere.capsule.energies().total(), 100 * eps * .5 * area(sphere.mesh));
}

TEST_P(EachIntegrator, ExertsNoForceInTotal) {
  Sphere sphere(GetParam(), moduli_of(.05), {}, 1, Vector3d(1.1, .95, 1).asDiagonal());
  const LinearFluid fluid{.gradient = shear(.01), .centre = Sphere::centre, .drag = drag};
  for (int n = 0; n < 20; ++n) fluid.step(sphere.capsule);
  double norm = 0;
  for (const double f : sphere.capsule.forces()) norm += f * f;
  norm = std::sqrt(norm);
  ASSERT_GT(norm, 1e-3);
  // What the solver may leave, 1e-3 of the force in the norm over all vertices, could add up over
  // 252 of them.
  const double tolerance = implicit() ? 1e-3 * std::sqrt(252.) * norm : 1e4 * eps;
  EXPECT_LT(total(sphere.capsule.forces()).norm(), tolerance);
}

/// Positions after a time of 16, in steps of h.
std::vector<double> sheared(std::string_view integrator, double h) {
  IntegratorOptions options;
  Sphere sphere(integrator, moduli_of(.05), options, h);
  const LinearFluid fluid{
      .gradient = shear(.02), .centre = Sphere::centre, .drag = drag, .time_step = h};
  for (int n = 0; n < std::lround(16 / h); ++n) fluid.step(sphere.capsule);
  return {sphere.capsule.positions().begin(), sphere.capsule.positions().end()};
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double square = 0;
  for (std::size_t k = 0; k < a.size(); ++k) square += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(square / static_cast<double>(a.size()) * 3);
}

TEST_P(EachIntegrator, ConvergesAtItsOrder) {
  const double order = GetParam() == "adams-bashforth" ? 2 : 1;
  // So tightly that the step's error is what is seen.
  const test::PetscOptions tight{{"-membrane_snes_rtol", "1e-9"}, {"-membrane_ksp_rtol", "1e-9"}};
  const auto x1 = sheared(GetParam(), 1), x2 = sheared(GetParam(), .5),
             x4 = sheared(GetParam(), .25), x8 = sheared(GetParam(), .125);
  const double d1 = distance(x1, x2), d2 = distance(x2, x4), d4 = distance(x4, x8);
  std::printf("%s: differences %.3g, %.3g, %.3g\n", std::string(GetParam()).c_str(), d1, d2, d4);
  EXPECT_NEAR(std::log2(d2 / d4), order, .15);
  EXPECT_LT(d4, d2);
  EXPECT_LT(d2, d1);

  // All schemes go to one limit: their difference to the explicit one's falls at first order.
  const double apart2 = distance(x4, sheared("explicit-euler", .25));
  const double apart4 = distance(x8, sheared("explicit-euler", .125));
  if (GetParam() != "explicit-euler") {
    EXPECT_NEAR(std::log2(apart2 / apart4), 1, .15);
  }
}

TEST_P(EachIntegrator, StiffCapsuleTurnsAsARigidSphereWhereTheSchemeIsStable) {
  // Some 10^3 times what an explicit scheme bears: hardly any strain is left, and the sphere turns
  // with half of the vorticity (markers of equal drag on a sphere).
  const double rate = .004;
  Sphere sphere(GetParam(), moduli_of(1e4));
  const LinearFluid fluid{.gradient = shear(rate), .centre = Sphere::centre, .drag = drag};
  if (!implicit()) {
    const auto run = [&] {
      for (int n = 0; n < 200; ++n) fluid.step(sphere.capsule);
    };
    EXPECT_THROW(run(), VertexFailure);
    return;
  }
  for (int n = 0; n < 200; ++n) fluid.step(sphere.capsule);
  const Vector3d omega = rotation(sphere.capsule);
  // With 1e-3 of the force left to the solver.
  EXPECT_NEAR(omega.y(), rate / 2, 2e-3 * rate);
  EXPECT_LT(std::abs(omega.x()) + std::abs(omega.z()), 2e-3 * rate);
  // Linear elasticity: a tenth of the modulus is strained ten times as much.
  Sphere softer(GetParam(), moduli_of(1e3));
  for (int n = 0; n < 200; ++n) fluid.step(softer.capsule);
  const double strained = sphere.capsule.shape().taylor_deformation();
  EXPECT_LT(strained, 1e-4);
  EXPECT_NEAR(softer.capsule.shape().taylor_deformation() / strained, 10, .2);
  EXPECT_LT(std::abs(sphere.capsule.volume_error()), 1e-5);
  EXPECT_EQ(sphere.capsule.statistics().solves, 200 * 2);  // two rounds
}

class EachImplicit : public EachIntegrator {};
INSTANTIATE_TEST_SUITE_P(All, EachImplicit,
                         testing::Values(std::string_view("semi-implicit"),
                                         std::string_view("implicit")),
                         label);

TEST_P(EachImplicit, MovesWithTheFluidAndItsMobilityAloneAtThetaOneHalf) {
  for (const int substeps : {1, 3}) {
    for (const double theta : {.5, 1.}) {
      Sphere sphere(GetParam(), moduli_of(10), {.theta = theta, .substeps = substeps});
      const LinearFluid fluid{.gradient = shear(.01), .centre = Sphere::centre, .drag = drag};
      for (int n = 0; n < 5; ++n) fluid.step(sphere.capsule);
      const auto x =
          std::vector<double>(sphere.capsule.positions().begin(), sphere.capsule.positions().end());
      fluid.step(sphere.capsule);
      const std::vector<double> areas = vertex_areas(sphere.mesh);
      for (std::size_t i = 0; i < areas.size(); ++i) {
        const Vector3d f = Vector3d::Map(&sphere.capsule.forces()[3 * i]);
        const Vector3d expected = fluid.gradient * (Vector3d::Map(&x[3 * i]) - Sphere::centre) +
                                  (2 * theta * drag + .006 / areas[i]) * f;
        const Vector3d v = Vector3d::Map(&sphere.capsule.velocities()[3 * i]);
        ASSERT_LT((v - expected).norm(), 100 * eps) << "vertex " << i;
      }
      EXPECT_EQ(sphere.capsule.statistics().solves, 2 * 6 * substeps);
    }
  }
}

TEST_P(EachImplicit, SubstepsGoToTheirLimitAtFirstOrder) {
  const auto after = [](int substeps) {
    const test::PetscOptions tight{{"-membrane_snes_rtol", "1e-9"}, {"-membrane_ksp_rtol", "1e-9"}};
    Sphere sphere(GetParam(), moduli_of(1), {.substeps = substeps}, 1,
                  Vector3d(1.1, .95, 1).asDiagonal());
    const LinearFluid fluid{.drag = drag};
    for (int n = 0; n < 4; ++n) fluid.step(sphere.capsule);
    return std::vector<double>(sphere.capsule.positions().begin(),
                               sphere.capsule.positions().end());
  };
  const auto x4 = after(4), x8 = after(8), x16 = after(16), x32 = after(32);
  EXPECT_NEAR(std::log2(distance(x8, x16) / distance(x16, x32)), 1, .15);
  EXPECT_LT(distance(x8, x16), distance(x4, x8));
}

TEST(OwnIntegrator, OfTheDocumentationIsOfSecondOrderInAFluidAtRest) {
  const IntegratorFactory heun = make_integrator(scheme<Heun>("heun"));
  const Mesh mesh = icosphere(5, 5);
  const auto relaxed = [&](double h) {
    Capsule capsule(
        mesh, test::moved(mesh.vertices, Vector3d(1.1, .95, 1).asDiagonal(), Sphere::centre),
        moduli_of(.05), {.mobility = 1e-3 * h, .viscosity = 1. / 6, .integrator = heun});
    const LinearFluid fluid{.drag = drag, .time_step = h};
    for (int n = 0; n < std::lround(16 / h); ++n) fluid.step(capsule);
    return std::vector<double>(capsule.positions().begin(), capsule.positions().end());
  };
  const auto x1 = relaxed(1), x2 = relaxed(.5), x4 = relaxed(.25), x8 = relaxed(.125);
  EXPECT_NEAR(std::log2(distance(x2, x4) / distance(x4, x8)), 2, .15);
  EXPECT_LT(distance(x2, x4), distance(x1, x2));
}

TEST(Implicit, SolvesWhatItSaysItSolves) {
  // |F + dE/dx(x')| <= rtol |F| at the positions that the capsule ends up at.
  for (const double rtol : {1e-2, 1e-5}) {
    const test::PetscOptions options{{"-membrane_snes_rtol", std::to_string(rtol)}};
    Sphere sphere("implicit", moduli_of(100));
    const LinearFluid fluid{.gradient = shear(.01), .centre = Sphere::centre, .drag = drag};
    const VecPtr f = sphere.capsule.shell().create_vec();
    for (int n = 0; n < 20; ++n) {
      fluid.step(sphere.capsule);
      sphere.capsule.shell().force(sphere.capsule.state().positions.get(), f.get());
      petsc_check(VecAXPY(f.get(), -1, sphere.capsule.state().forces.get()));
      PetscReal left = 0, force = 0;
      petsc_check(VecNorm(f.get(), NORM_2, &left));
      petsc_check(VecNorm(sphere.capsule.state().forces.get(), NORM_2, &force));
      EXPECT_LE(left, rtol * force * (1 + 1e-3)) << "step " << n;
    }
  }
}

TEST(Implicit, JacobianPassesPetscsOwnTest) {
  // One Newton step, few vertices: PETSc takes a column at a time.
  const test::PetscOptions options{{"-membrane_snes_test_jacobian", ""},
                                   {"-membrane_snes_rtol", ".5"}};
  Sphere sphere("implicit", moduli_of(1), {.theta = .75}, 1, Vector3d(1.1, .95, 1).asDiagonal(), 2);
  testing::internal::CaptureStdout();
  const LinearFluid fluid{.gradient = shear(.01), .centre = Sphere::centre, .drag = drag};
  fluid.step(sphere.capsule);
  const std::string out = testing::internal::GetCapturedStdout();
  const std::string mark = "||J - Jfd||_F/||J||_F = ";
  const std::size_t at = out.find(mark);
  ASSERT_NE(at, std::string::npos) << out;
  // One-sided differences of step 1e-8.
  EXPECT_LT(std::stod(out.substr(at + mark.size())), 1e-6) << out;
}

TEST(Implicit, FailureNamesReasonIterationsAndResidualAndLeavesTheStateAlone) {
  std::vector<double> before;
  const Matrix3d stretch = Vector3d(1.02, .98, 1).asDiagonal();
  Sphere sphere("implicit", moduli_of(1e3), {}, 1, stretch);
  const LinearFluid fluid{.gradient = shear(.01), .centre = Sphere::centre, .drag = drag};
  before.assign(sphere.capsule.positions().begin(), sphere.capsule.positions().end());
  {
    const test::PetscOptions one{{"-membrane_snes_max_it", "1"}};
    Sphere hasty("implicit", moduli_of(1e3), {}, 1, stretch);
    try {
      fluid.step(hasty.capsule);
      FAIL() << "no SolveFailure";
    } catch (const SolveFailure& failure) {
      EXPECT_EQ(failure.reason(), "DIVERGED_MAX_IT");
      EXPECT_EQ(failure.newton_iterations(), 1);
      EXPECT_GT(failure.krylov_iterations(), 0);
      EXPECT_GT(failure.residual(), 0);
      test::expect_contains(failure.what(), "DIVERGED_MAX_IT after 1 Newton");
    }
    EXPECT_TRUE(std::equal(before.begin(), before.end(), hasty.capsule.positions().begin()));
  }
}

TEST(Implicit, GoesOnAfterAFailedStepAsIfNothingHadHappened) {
  // A velocity that is not finite fails the solve; the step is then taken again.
  const LinearFluid fluid{.gradient = shear(.01), .centre = Sphere::centre, .drag = drag};
  Sphere twin("implicit", moduli_of(100)), sphere("implicit", moduli_of(100));
  const auto equal = [](std::span<const double> a, std::span<const double> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  };
  for (int n = 0; n < 4; ++n) {
    fluid.step(twin.capsule);
    fluid.step(sphere.capsule);
  }
  std::vector<double> force(sphere.capsule.positions().size());
  const std::vector<double> broken(force.size(), std::nan(""));
  std::vector<double> increment(force.size());
  sphere.capsule.predict_force(force);
  const Response still = [](std::span<const double>, std::span<double> u) {
    std::fill(u.begin(), u.end(), 0.0);
  };
  EXPECT_THROW(sphere.capsule.correct_force(broken, still, increment), SolveFailure);
  EXPECT_TRUE(equal(sphere.capsule.positions(), twin.capsule.positions()));
  // The solver's tolerance: after the failure it may solve with a newer tangent.
  for (int n = 0; n < 4; ++n) {
    fluid.step(twin.capsule);
    fluid.step(sphere.capsule);
  }
  for (std::size_t k = 0; k < force.size(); ++k)
    EXPECT_NEAR(sphere.capsule.positions()[k], twin.capsule.positions()[k], 1e-6);
}

TEST(Implicit, StepCutsRepeatAStepWithMoreSubsteps) {
  const test::PetscOptions one{{"-membrane_snes_max_it", "1"},
                               {"-membrane_snes_rtol", "1e-4"},
                               {"-membrane_ksp_rtol", "1e-9"}};
  const LinearFluid fluid{.gradient = shear(.01), .centre = Sphere::centre, .drag = drag};
  const Matrix3d stretch = Vector3d(1.3, .8, 1).asDiagonal();
  Sphere whole("implicit", moduli_of(.3), {}, 1, stretch);
  EXPECT_THROW(fluid.step(whole.capsule), SolveFailure);
  Sphere cut("implicit", moduli_of(.3), {.step_cuts = 10}, 1, stretch);
  fluid.step(cut.capsule);
  const SolveStatistics statistics = cut.capsule.statistics();
  EXPECT_GT(statistics.step_cuts, 0);
  // What comes out is between what few and what very many substeps give: the solution at some h.
  const auto position = [&](int substeps) {
    const test::PetscOptions patient{{"-membrane_snes_max_it", "50"}};
    Sphere sphere("implicit", moduli_of(.3), {.substeps = substeps}, 1, stretch);
    fluid.step(sphere.capsule);
    return std::vector<double>(sphere.capsule.positions().begin(),
                               sphere.capsule.positions().end());
  };
  const std::vector<double> result(cut.capsule.positions().begin(), cut.capsule.positions().end());
  const auto coarse = position(1), fine = position(64);
  EXPECT_LT(distance(result, coarse) + distance(result, fine), 1.1 * distance(coarse, fine));
  EXPECT_GE(statistics.solves, 2);
}

TEST_P(EachIntegrator, MovesAsItsWeightsSay) {
  // v_n = sum_i w_i (u + eps F)_(n-i), and F the force of x^n: what its limit of stability is
  // derived from.
  const std::vector<double> weights = find_scheme(GetParam()).traits.weights;
  if (weights.empty()) {
    EXPECT_GT(find_scheme(GetParam()).traits.reach, 0);
    return;
  }
  Sphere sphere(GetParam(), moduli_of(.05), {}, 1, Vector3d(1.1, .95, 1).asDiagonal());
  Capsule& capsule = sphere.capsule;
  ASSERT_EQ(capsule.corrections(), 0);
  const std::vector<double> areas = vertex_areas(sphere.mesh);
  const VecPtr expected = capsule.shell().create_vec();
  test::Random random;
  std::vector<std::vector<double>> rates;  // latest last
  std::vector<double> force(3 * areas.size()), u(force.size());
  for (std::size_t n = 0; n < weights.size() + 3; ++n) {
    capsule.shell().force(capsule.state().positions.get(), expected.get());
    capsule.predict_force(force);
    const VecArray<const double> f(expected.get());
    EXPECT_TRUE(std::equal(force.begin(), force.end(), f.data()));
    rates.emplace_back();
    for (std::size_t k = 0; k < u.size(); ++k) {
      u[k] = random(.01);
      rates.back().push_back(u[k] + .006 / areas[k / 3] * force[k]);
    }
    capsule.advance(u);
    if (rates.size() < weights.size()) continue;
    for (std::size_t k = 0; k < u.size(); ++k) {
      double v = 0;
      for (std::size_t i = 0; i < weights.size(); ++i) v += weights[i] * rates.rbegin()[i][k];
      ASSERT_NEAR(capsule.velocities()[k], v, 10 * eps);
    }
  }
}

TEST(MakeIntegrator, ListsTheKnownNamesForAnUnknownOne) {
  const std::string text = test::refusal([] { make_integrator("explicit-eular"); });
  test::expect_contains(text, "'explicit-eular'");
  test::expect_contains(text, "known: explicit-euler, adams-bashforth, semi-implicit, implicit");
}

TEST(MakeIntegrator, RefusesOptionsOutOfBounds) {
  const auto refused = [](const IntegratorOptions& options) {
    return test::refusal([&] { make_integrator("implicit", options); });
  };
  test::expect_contains(refused({.theta = .4}), "theta = 0.4");
  test::expect_contains(refused({.theta = std::nan("")}), "theta = nan");
  test::expect_contains(refused({.substeps = 0}), "substeps = 0 must be at least 1");
  test::expect_contains(refused({.step_cuts = 30}), "step_cuts = 30");
  const test::PetscOptions lag{{"-membrane_tangent_lag", "0"}};
  test::expect_contains(test::refusal([] { Sphere("implicit", moduli_of(1)); }),
                        "-membrane_tangent_lag 0 must be at least 1");
}

}  // namespace
}  // namespace ductile::membrane
