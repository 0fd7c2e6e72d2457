// Shapes: the published cell, what holds for each, and each against its meshes.
#include "ductile/surface/shape.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

#include "ductile/surface/biconcave.hpp"
#include "ductile/surface/sphere.hpp"
#include "membrane/surface_support.hpp"

namespace ductile::surface {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double eps = std::numeric_limits<double>::epsilon();

/// The integral of |r|^2 1 - r r^T over the volume of a mesh: a sum over tetrahedra from the
/// origin, that of r r^T over one being det/120 (sum of x x^T + of its corners' sum s s^T).
Matrix3d inertia(const Mesh& mesh) {
  Matrix3d second = Matrix3d::Zero();
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vector3d &a = mesh.vertices[i], &b = mesh.vertices[j], &c = mesh.vertices[k];
    const Vector3d sum = a + b + c;
    second += a.dot(b.cross(c)) / 120 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  return second.trace() * Matrix3d::Identity() - second;
}

/// Normal of a mesh at each vertex, the sum of the triangles' around it.
test::Points normals(const Mesh& mesh) {
  test::Points sums(mesh.vertices.size(), Vector3d::Zero());
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vector3d& a = mesh.vertices[i];
    const Vector3d normal = (mesh.vertices[j] - a).cross(mesh.vertices[k] - a);
    for (const int vertex : {i, j, k}) sums[vertex] += normal;
  }
  for (Vector3d& sum : sums) sum.normalize();
  return sums;
}

class EachShape : public testing::TestWithParam<std::string_view> {
 protected:
  static constexpr double radius = 2.5;
  const std::shared_ptr<const Shape> shape_ = make_shape(GetParam(), radius);
};
INSTANTIATE_TEST_SUITE_P(All, EachShape, testing::ValuesIn(shape_names()),
                         [](const auto& shape) { return std::string(shape.param); });

TEST_P(EachShape, KnowsItsNameAndRadius) {
  EXPECT_EQ(shape_->name(), GetParam());
  EXPECT_EQ(shape_->radius(), radius);
}

TEST_P(EachShape, MeshesConvergeToVolumeAreaAndInertiaAtSecondOrder) {
  const Mesh coarse = shape_->mesh(24), fine = shape_->mesh(48);
  const auto expect = [](double exact, double on_coarse, double on_fine) {
    EXPECT_NEAR(std::log2((exact - on_coarse) / (exact - on_fine)), 2, .05);
    // Richardson; what remains is of fourth order.
    EXPECT_NEAR((4 * on_fine - on_coarse) / 3 / exact, 1, 3e-6);
  };
  expect(shape_->volume(), volume(coarse), volume(fine));
  expect(shape_->area(), area(coarse), area(fine));
  const Matrix3d exact = shape_->inertia(), on_coarse = inertia(coarse), on_fine = inertia(fine);
  for (int i = 0; i < 3; ++i) expect(exact(i, i), on_coarse(i, i), on_fine(i, i));
  EXPECT_LT((exact - Matrix3d(exact.diagonal().asDiagonal())).norm(), eps * exact.norm());
}

TEST_P(EachShape, ScalesWithItsRadius) {
  const auto unit = make_shape(GetParam(), 1);
  EXPECT_NEAR(shape_->volume() / (std::pow(radius, 3) * unit->volume()), 1, 10 * eps);
  EXPECT_NEAR(shape_->area() / (std::pow(radius, 2) * unit->area()), 1, 10 * eps);
  EXPECT_LT((shape_->inertia() - std::pow(radius, 5) * unit->inertia()).norm(),
            100 * eps * shape_->inertia().norm());
  EXPECT_NEAR(shape_->reach() / (radius * unit->reach()), 1, 10 * eps);
}

TEST_P(EachShape, MeshIsPointSymmetric) {
  const Mesh mesh = shape_->mesh(4);
  for (const Vector3d& x : mesh.vertices) {
    double nearest = radius;
    for (const Vector3d& y : mesh.vertices) nearest = std::min(nearest, (x + y).norm());
    EXPECT_LT(nearest, 100 * eps);
  }
}

TEST_P(EachShape, ContainsWhatIsInsideItsMesh) {
  const double step = 1e-6;
  const Mesh mesh = shape_->mesh(8), inside = shape_->mesh(8, -step),
             outside = shape_->mesh(8, step);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    EXPECT_TRUE(shape_->contains(inside.vertices[i])) << i;
    EXPECT_FALSE(shape_->contains(outside.vertices[i])) << i;
  }
  EXPECT_TRUE(shape_->contains(Vector3d::Zero()));
  EXPECT_FALSE(shape_->contains({0, 0, 2 * radius}));
  EXPECT_FALSE(shape_->contains({2 * radius, 0, 0}));
}

TEST_P(EachShape, OffsetIsAlongTheNormal) {
  const double offset = -.1 * radius;
  const auto error = [&](int frequency) {
    const Mesh mesh = shape_->mesh(frequency), moved = shape_->mesh(frequency, offset);
    EXPECT_EQ(moved.triangles, mesh.triangles);
    const test::Points normal = normals(mesh);
    double worst = 0;
    for (std::size_t i = 0; i < normal.size(); ++i) {
      const Vector3d step = moved.vertices[i] - mesh.vertices[i];
      EXPECT_NEAR(step.norm(), -offset, 10 * eps * radius);
      worst = std::max(worst, (step.normalized() + normal[i]).norm());
    }
    return worst;
  };
  // The mesh's normals are exact to first order at least.
  EXPECT_LT(error(16), .06);
  EXPECT_LT(error(64), .016);
}

TEST_P(EachShape, OffsetChangesVolumeByAreaAndCurvature) {
  // Steiner: V(h) + V(-h) - 2 V = 2 h^2 M, V(h) - V(-h) = 2 h A + (8 pi/3) h^3.
  const double h = .02 * radius;
  const auto difference = [&](int n) {
    return volume(shape_->mesh(n, h)) - volume(shape_->mesh(n, -h));
  };
  const double extrapolated = (4 * difference(64) - difference(32)) / 3;
  const double expected = 2 * h * shape_->area() + 8 * std::numbers::pi / 3 * h * h * h;
  EXPECT_NEAR(extrapolated / expected, 1, 1e-5);
}

TEST_P(EachShape, ReachAndExtentHoldTheCore) {
  test::Random random;
  EXPECT_LE(shape_->extent(Vector3d::UnitZ()), shape_->reach());
  double reach = 0;
  for (int n = 0; n < 200; ++n) {
    const Vector3d direction = random.vector().normalized();
    const double extent = shape_->extent(direction);
    EXPECT_NEAR(shape_->extent(-direction), extent, 10 * eps * radius);
    EXPECT_LE(extent, shape_->reach() * (1 + eps));
    for (const Vector3d& point : shape_->core().points)
      EXPECT_GE(extent, point.dot(direction) + shape_->core().radius);
    reach = std::max(reach, extent);
  }
  EXPECT_GT(reach, .99 * shape_->reach());
  // No vertex of a finer mesh sticks out by more than the core's mesh misses between its vertices.
  for (const Vector3d& x : shape_->mesh(40).vertices) EXPECT_LT(x.norm(), 1.003 * shape_->reach());
}

TEST(Sphere, IsTheIcosphereAndTheBall) {
  const Sphere sphere(7.3);
  for (const double offset : {0., -.5, .25}) {
    EXPECT_EQ(sphere.mesh(6, offset).vertices, icosphere(6, 7.3 + offset).vertices);
    EXPECT_EQ(sphere.mesh(6, offset).triangles, icosphere(6, 7.3 + offset).triangles);
  }
  EXPECT_EQ(sphere.reach(), 7.3);
  EXPECT_EQ(sphere.extent(Vector3d(1, 2, -2) / 3), 7.3);
  EXPECT_NEAR(sphere.inertia()(1, 1), .4 * sphere.volume() * 7.3 * 7.3, eps);
}

TEST(Biconcave, HasThePublishedVolumeAndArea) {
  const Biconcave cell(1);
  EXPECT_NEAR(cell.volume(), 2.7154735, 5e-8);
  EXPECT_NEAR(cell.area(), 12.6200173, 5e-8);
}

TEST(Biconcave, NormalsAreThoseOfEq18) {
  // On the axis and on the rim by symmetry; elsewhere, from slightly different points.
  const Biconcave cell(1);
  const Mesh mesh = cell.mesh(16), moved = cell.mesh(16, 1e-3);
  int on_rim = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3d& x = mesh.vertices[i];
    const Vector3d normal = (moved.vertices[i] - x) / 1e-3;
    if (x.z() == 0) {
      ++on_rim;
      EXPECT_LT((normal - x.normalized()).norm(), 1e-12);
    }
    const double rho = std::hypot(x.x(), x.y());
    if (std::abs(x.z()) < .05) continue;
    // z(rho) by eq. (18), and its slope by a central difference.
    const auto z = [](double r) {
      const double u = r * r / 1.44;
      return .6 * (.207 + 2 * u - 1.123 * u * u) * std::sqrt(1 - u);
    };
    const double slope = (z(rho + 1e-5) - z(rho - 1e-5)) / 2e-5;
    Vector3d expected(-slope * x.x() / rho, -slope * x.y() / rho, x.z() > 0 ? 1 : -1);
    if (rho == 0) expected.head<2>().setZero();
    EXPECT_LT((normal - expected.normalized()).norm(), 1e-6) << x.transpose();
  }
  EXPECT_GT(on_rim, 0);
}

TEST(Biconcave, RefusesAnOffsetThatFoldsIt) {
  const Biconcave cell(2);
  test::expect_contains(test::refusal([&] { static_cast<void>(cell.mesh(4, -.25)); }),
                        "offset -0.25");
  test::expect_contains(test::refusal([&] { static_cast<void>(cell.mesh(4, 1.3)); }), "offset 1.3");
  // Just before it folds every triangle still faces outward: the volume grows with the offset.
  for (const double offset : {-.24, 1.2}) {
    const Mesh mesh = cell.mesh(32, offset), more = cell.mesh(32, offset + 1e-6);
    EXPECT_GT(volume(more), volume(mesh));
    const test::Points normal = normals(mesh);
    for (std::size_t i = 0; i < normal.size(); ++i)
      EXPECT_GT(normal[i].dot(more.vertices[i] - mesh.vertices[i]), .8e-6) << i;
  }
}

TEST(MakeShape, ListsTheKnownNamesForAnUnknownOne) {
  const std::string text = test::refusal([] { static_cast<void>(make_shape("cube", 1)); });
  test::expect_contains(text, "'cube'");
  test::expect_contains(text, "known: sphere, biconcave");
}

TEST(MakeShape, RefusesARadiusThatIsNotPositive) {
  for (const std::string_view name : shape_names()) {
    test::expect_contains(test::refusal([&] { static_cast<void>(make_shape(name, -1)); }),
                          "radius -1");
    test::expect_contains(test::refusal([&] { static_cast<void>(make_shape(name, std::nan(""))); }),
                          "radius");
  }
}

TEST(Mesh, EdgeOfTheIcosphereIsAboutWhatIsSaid) {
  for (const auto& [n, error] : {std::pair{2, .038}, {3, .02}, {8, .0023}, {32, .0002}})
    EXPECT_NEAR(icosphere_edge(7, n) / mean_edge(icosphere(n, 7)), 1, error) << n;
}

}  // namespace
}  // namespace ductile::surface
