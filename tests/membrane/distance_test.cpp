// The distance of two surfaces: spheres, where it is known, and what holds of any.
#include "ductile/surface/distance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "ductile/surface/mesh.hpp"
#include "ductile/surface/shape.hpp"
#include "membrane/surface_support.hpp"

namespace ductile::surface {
namespace {

using Eigen::Vector3d;

constexpr double infinity = std::numeric_limits<double>::infinity();
const Vector3d nowhere = Vector3d::Zero();

struct Placed {
  std::vector<double> positions;
  std::vector<std::array<int, 3>> triangles;

  Placed(Mesh mesh, const Eigen::Matrix3d& rotation, const Vector3d& centre)
      : triangles(mesh.triangles) {
    place(mesh, rotation, centre);
    for (const Vector3d& x : mesh.vertices) positions.insert(positions.end(), x.begin(), x.end());
  }
  [[nodiscard]] SurfaceView view() const { return {positions, triangles}; }
};

// A mesh with edges e lies within a sphere by at most e^2/(6 R), in the middle of a triangle.
TEST(Distance, OfSpheresIsThatOfTheirCentresLessBothRadii) {
  test::Random random;
  constexpr double a = 4, b = 3, edge = 1.2;
  const Mesh large = icosphere(frequency_for_edge(a, edge), a);
  const Mesh small = icosphere(frequency_for_edge(b, edge), b);
  for (int n = 0; n < 40; ++n) {
    const Vector3d direction = random.vector().normalized();
    const double gap = 1.5 * (n + 1) / 40.0;
    const Placed at_home(large, random.rotation(), {5, 6, 7});
    const Placed away(small, random.rotation(), Vector3d(5, 6, 7) + (a + b + gap) * direction);
    const double found = distance(at_home.view(), away.view(), nowhere, 2);
    EXPECT_GE(found, gap - 1e-12);
    EXPECT_LE(found, gap + 2 * edge * edge / (6 * b));
    EXPECT_EQ(distance(at_home.view(), away.view(), nowhere, 0.99 * gap), infinity);
    EXPECT_EQ(distance(away.view(), at_home.view(), nowhere, 2), found);
  }
}

TEST(Distance, IsZeroFromTheFirstCutToTheLast) {
  test::Random random;
  const Mesh mesh = icosphere(3, 4);
  const double within = 0.45;  // edges of 1.6: so deep the triangles lie below their sphere
  for (int n = 0; n <= 40; ++n) {
    const double apart = 2 * (4 - within) * (n + 1) / 41.0;
    const Placed a(mesh, random.rotation(), nowhere);
    const Placed b(mesh, random.rotation(), apart * random.vector().normalized());
    EXPECT_EQ(distance(a.view(), b.view(), nowhere, 0.5), 0) << apart;
  }
  // One inside of the other: no cut.
  const Placed inner(icosphere(3, 2), random.rotation(), nowhere);
  const double found =
      distance(Placed(mesh, random.rotation(), nowhere).view(), inner.view(), nowhere, 3);
  EXPECT_GT(found, 2 - within);
  EXPECT_LT(found, 2);
}

// With a reach that holds everything, each vertex is compared with each triangle.
TEST(Distance, DoesNotDependOnReachAndGoesAlongWithShiftAndRotation) {
  test::Random random;
  const Mesh cell = make_shape("biconcave", 4)->mesh(5);
  int near = 0;
  for (int n = 0; n < 24; ++n) {
    const Eigen::Matrix3d first = random.rotation();
    const Eigen::Matrix3d second = random.rotation();
    const Vector3d apart = (8.5 + 2 * random()) * random.vector().normalized();
    const Placed a(cell, first, nowhere);
    const Placed b(cell, second, apart);
    const double found = distance(a.view(), b.view(), nowhere, 2);
    const double brute = distance(a.view(), b.view(), nowhere, 1000);
    EXPECT_EQ(found, brute < 2 ? brute : infinity);
    if (found > 0 && found < 2) ++near;
    const Placed b_elsewhere(cell, second, apart - Vector3d(3, -20, 40));
    const double shifted = distance(a.view(), b_elsewhere.view(), {3, -20, 40}, 1000);
    EXPECT_NEAR(shifted, brute, 1e-12);
    const Eigen::Matrix3d turn = random.rotation();
    const Placed a_turned(cell, turn * first, nowhere);
    const Placed b_turned(cell, turn * second, turn * apart);
    EXPECT_NEAR(distance(a_turned.view(), b_turned.view(), nowhere, 1000), brute, 1e-12);
  }
  EXPECT_GE(near, 3);
}

TEST(Distance, RefusesNoReach) {
  const Placed a(icosphere(2, 1), Eigen::Matrix3d::Identity(), nowhere);
  EXPECT_THROW(distance(a.view(), a.view(), nowhere, 0), std::invalid_argument);
}

}  // namespace
}  // namespace ductile::surface
