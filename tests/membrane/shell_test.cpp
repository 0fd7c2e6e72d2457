// The shell's force as the gradient of its energy, its symmetries, its shape, and what it refuses.
#include "ductile/membrane/shell.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ductile/surface/biconcave.hpp"
#include "membrane/support.hpp"

namespace ductile::membrane {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Points;

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr Moduli all_terms{.k_s = 1, .k_a = 2, .k_b = .05, .k_v = 3};

struct Case {
  const char* name;
  Moduli moduli;
  ShellOptions options;
};
class EachTerm : public testing::TestWithParam<Case> {
 protected:
  const Mesh reference_ = surface::Biconcave(1).mesh(4);
  const Shell shell_{reference_, GetParam().moduli, GetParam().options};
  test::Random random_;
  const Points x_ = test::perturbed(reference_.vertices, .05 * mean_edge(reference_), random_);
};
// What a lesser machine would run gives the same bits.
TEST_P(EachTerm, ForceIsTheSameWithEachInstructionSet) {
  for (const auto set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!available(set)) continue;
    ShellOptions options = GetParam().options;
    options.instruction_set = set;
    const Shell shell(reference_, GetParam().moduli, options);
    EXPECT_EQ(test::forces(shell, x_), test::forces(shell_, x_)) << name(set);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Shell, EachTerm,
    testing::Values(Case{"Skalak", {.k_s = 1, .k_a = 2}, {}},
                    Case{"NeoHookean", {.law = StrainLaw::neo_hookean, .k_s = 1}, {}},
                    Case{"Bending", {.k_b = 1}, {}},
                    Case{"BendingFromFlat", {.k_b = 1}, {.flat_reference_angles = true}},
                    Case{"Volume", {.k_v = 1}, {}}, Case{"All", all_terms, {}}),
    [](const auto& term) { return term.param.name; });

TEST_P(EachTerm, ForceIsMinusTheGradientOfTheEnergy) {
  const Points force = test::forces(shell_, x_);
  double largest = 0, error = 0;
  // Central differences of order 4: h^4 and eps/h are far below the tolerance.
  const double h = 1e-3 * mean_edge(reference_);
  for (std::size_t i = 0; i < x_.size(); ++i) {
    for (int d = 0; d < 3; ++d) {
      const auto energy = [&](double shift) {
        Points x = x_;
        x[i][d] += shift;
        return test::energies(shell_, x).total();
      };
      const double gradient =
          (8 * (energy(h) - energy(-h)) - (energy(2 * h) - energy(-2 * h))) / (12 * h);
      error = std::max(error, std::abs(force[i][d] + gradient));
      largest = std::max(largest, std::abs(force[i][d]));
    }
  }
  EXPECT_GT(largest, 1e-4);
  EXPECT_LT(error, 1e-7 * largest);
}

TEST_P(EachTerm, ForceAndTorqueVanishInTotal) {
  const Points force = test::forces(shell_, x_);
  Vector3d total = Vector3d::Zero(), torque = Vector3d::Zero();
  double size = 0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    total += force[i];
    torque += x_[i].cross(force[i]);
    size += force[i].norm() * std::max(1., x_[i].norm());
  }
  EXPECT_LT(total.norm(), 100 * eps * size);
  EXPECT_LT(torque.norm(), 100 * eps * size);
}

TEST_P(EachTerm, TurnsWithTheFrame) {
  const Matrix3d rotation = random_.rotation();
  const Vector3d shift(3, -2, 40);
  const Points x = test::moved(x_, rotation, shift);
  const double energy = test::energies(shell_, x_).total();
  // The shift costs the positions eps |shift|, over an edge of .3.
  const double tolerance = 100 * eps * shift.norm() / mean_edge(reference_);
  EXPECT_NEAR(test::energies(shell_, x).total(), energy, tolerance * energy);
  const Points before = test::forces(shell_, x_), after = test::forces(shell_, x);
  double largest = 0;
  for (const Vector3d& f : before) largest = std::max(largest, f.norm());
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_LT((after[i] - rotation * before[i]).norm(), tolerance * (1 + largest));
}

TEST(Shell, RigidMotionCausesNoForce) {
  const Mesh mesh = surface::Biconcave(1).mesh(8);
  test::Random random;
  for (const StrainLaw law : {StrainLaw::skalak, StrainLaw::neo_hookean}) {
    Moduli moduli = all_terms;
    moduli.law = law;
    const Shell shell(mesh, moduli);
    const Vector3d shift(3, -2, 40);
    const Points x = test::moved(mesh.vertices, random.rotation(), shift);
    // Moduli of order 1 times a strain of eps |shift| over an edge.
    const double tolerance = 100 * eps * shift.norm() / mean_edge(mesh);
    for (const Vector3d& f : test::forces(shell, x)) EXPECT_LT(f.norm(), tolerance);
    EXPECT_NEAR(test::energies(shell, x).total(), 0, tolerance);
  }
}

TEST(Shell, ForceIsTheSameToTheLastBitWheneverRepeated) {
  const Mesh mesh = icosphere(5, 4);
  test::Random random;
  const Points x = test::perturbed(mesh.vertices, .1, random),
               y = test::perturbed(mesh.vertices, .2, random);
  const Shell shell(mesh, all_terms), twin(mesh, all_terms);
  const Points first = test::forces(shell, x);
  test::forces(shell, y);
  EXPECT_EQ(test::forces(shell, x), first);
  EXPECT_EQ(test::forces(twin, x), first);
}

TEST(Shell, VolumeEnergyIsThatOfEquation11) {
  const Mesh mesh = icosphere(6, 2);
  const Shell shell(mesh, {.k_v = 3});
  EXPECT_NEAR(shell.reference_volume(), volume(mesh), 1e-12);
  Mesh larger = mesh;
  place(larger, 1.1 * Matrix3d::Identity(), {5, 6, 7});
  const double change = volume(mesh) * (std::pow(1.1, 3) - 1);
  EXPECT_NEAR(test::energies(shell, larger.vertices).volume,
              3. / 2 * change * change / volume(mesh), 1e-11);
}

TEST(Shape, OfAnEllipsoidHasItsAxes) {
  Mesh mesh = icosphere(16, 1);
  const Shell shell(mesh, all_terms);
  test::Random random;
  const Matrix3d rotation = random.rotation();
  const Vector3d centre(10, 20, -300);
  place(mesh, rotation * Vector3d(1.3, .9, 1.1).asDiagonal(), centre);
  const Shape shape = shell.shape(test::to_vec(mesh.vertices).get());
  EXPECT_NEAR(shape.area, area(mesh), 1e-11);
  EXPECT_NEAR(shape.volume, 1.3 * .9 * 1.1 * shell.reference_volume(), 1e-11);
  EXPECT_LT((shape.centroid - centre).norm(), 1e-11);
  // The mesh lies inside the ellipsoid by 0.1% of its axes, in proportion to each.
  const Vector3d axes = shape.semi_axes();
  EXPECT_LT((axes - Vector3d(1.3, 1.1, .9)).norm(), .002);
  EXPECT_NEAR(axes[0] / axes[2], 1.3 / .9, 1e-11);
  EXPECT_NEAR(axes[1] / axes[2], 1.1 / .9, 1e-11);
  EXPECT_NEAR(shape.taylor_deformation(), (1.3 - .9) / (1.3 + .9), 1e-11);
}

class Refusal : public testing::Test {
 protected:
  Mesh mesh_ = icosphere(2, 1);
  Moduli moduli_ = all_terms;
  ShellOptions options_;
  void expect(const std::string& part) {
    test::expect_contains(test::refusal([this] { const Shell shell(mesh_, moduli_, options_); }),
                          part);
  }
};

TEST_F(Refusal, NamesANegativeModulus) {
  moduli_.k_a = -1;
  expect("k_a = -1.0");
}
TEST_F(Refusal, NamesAModulusThatIsNoNumber) {
  moduli_.k_b = std::nan("");
  expect("modulus k_b");
}
TEST_F(Refusal, NamesTheEdgeOfAHole) {
  const auto [a, b, c] = mesh_.triangles.back();
  mesh_.triangles.pop_back();
  const std::string text = test::refusal([this] { const Shell shell(mesh_, moduli_, options_); });
  test::expect_contains(text, "not closed");
  const auto edge = [](int from, int to) {
    return "from vertex " + std::to_string(from) + " to " + std::to_string(to) + " of";
  };
  EXPECT_TRUE(text.find(edge(b, a)) != std::string::npos ||
              text.find(edge(c, b)) != std::string::npos ||
              text.find(edge(a, c)) != std::string::npos)
      << text;
}
TEST_F(Refusal, NamesAFlippedTriangle) {
  std::swap(mesh_.triangles[7][0], mesh_.triangles[7][1]);
  expect("flipped");
  expect(" 7 ");
}
TEST_F(Refusal, OfAMeshInsideOut) {
  for (auto& triangle : mesh_.triangles) std::swap(triangle[0], triangle[1]);
  expect("counter-clockwise seen from outside");
}
TEST_F(Refusal, NamesADegenerateTriangle) {
  const auto& [a, b, c] = mesh_.triangles[5];
  mesh_.vertices[a] = (mesh_.vertices[b] + mesh_.vertices[c]) / 2;
  expect("triangle 5 ");
  expect("degenerate");
}
TEST_F(Refusal, NamesAVertexThatIsNotThere) {
  mesh_.triangles[3][1] = 1000;
  expect("triangle 3 ");
}
TEST_F(Refusal, NamesAVertexWithoutTriangles) {
  mesh_.vertices.emplace_back(0, 0, 0);
  expect("vertex 42 belongs to no triangle");
}
TEST_F(Refusal, OfAMeshWithoutTriangles) {
  mesh_.triangles.clear();
  expect("no triangles");
}
TEST_F(Refusal, OfAnOpenSheetWithAVolume) {
  mesh_.triangles.pop_back();
  options_.open_sheet = true;
  expect("open sheet encloses no volume");
}
TEST_F(Refusal, OfAVectorOfAnotherSize) {
  const Shell shell(mesh_, moduli_);
  const VecPtr wrong = create_vec(41);
  test::expect_contains(
      test::refusal([&] { static_cast<void>(shell.shape(std::vector<double>(3))); }),
      "3 numbers where");
  test::expect_contains(test::refusal([&] { static_cast<void>(shell.energies(wrong.get())); }),
                        "123 numbers");
}

TEST(Petsc, ErrorCodesBecomeExceptions) {
  PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);
  const VecPtr small = create_vec(1), large = create_vec(2);
  EXPECT_NO_THROW(petsc_check(VecCopy(small.get(), small.get())));
  EXPECT_THROW(petsc_check(VecCopy(small.get(), large.get())), PetscFailure);
  PetscPopErrorHandler();
}

}  // namespace
}  // namespace ductile::membrane
