#include "ductile/surface/mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <numbers>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ductile/surface/biconcave.hpp"
#include "membrane/surface_support.hpp"

namespace ductile::surface {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

constexpr double sphere_area = 4 * pi;
constexpr double sphere_volume = 4 * pi / 3;

struct Table {
  int frequency;
  double area, volume;  // over the sphere's
  double min_edge, mean_edge, max_edge;
  double biconcave_area, biconcave_volume;
};

class MeshOfTheTable : public testing::TestWithParam<Table> {};
INSTANTIATE_TEST_SUITE_P(Mesh, MeshOfTheTable,
                         testing::Values(Table{8, .99523507, .99139384, .138283, .150730, .164647,
                                               12.5410646, 2.6920649},
                                         Table{16, .99880501, .99783917, .069183, .075499, .082604,
                                               12.6001799, 2.7095956},
                                         Table{32, .99970102, .99945921, .034597, .037766, .041337,
                                               12.6150517, 2.7140024}),
                         [](const auto& table) { return std::to_string(table.param.frequency); });

// Tolerances: the tables' digits.
TEST_P(MeshOfTheTable, IcosphereHasItsAreaVolumeAndEdges) {
  const Table& expected = GetParam();
  const Mesh mesh = icosphere(expected.frequency, 1);
  EXPECT_NEAR(area(mesh) / sphere_area, expected.area, 1e-8);
  EXPECT_NEAR(volume(mesh) / sphere_volume, expected.volume, 1e-8);
  double shortest = 1, longest = 0;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const double edge = (mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm();
      shortest = std::min(shortest, edge);
      longest = std::max(longest, edge);
    }
  }
  EXPECT_NEAR(shortest, expected.min_edge, 1e-6);
  EXPECT_NEAR(mean_edge(mesh), expected.mean_edge, 1e-6);
  EXPECT_NEAR(longest, expected.max_edge, 1e-6);
}

TEST_P(MeshOfTheTable, BiconcaveHasItsAreaAndVolume) {
  const Table& expected = GetParam();
  const Mesh mesh = Biconcave(1).mesh(expected.frequency);
  EXPECT_NEAR(area(mesh), expected.biconcave_area, 1e-7);
  EXPECT_NEAR(volume(mesh), expected.biconcave_volume, 1e-7);
}

TEST(Mesh, BiconcaveConvergesToItsExactAreaAndVolume) {
  // Richardson, order 2, from n = 16 and 32; what remains is of order 4.
  const Mesh coarse = Biconcave(1).mesh(16), fine = Biconcave(1).mesh(32);
  EXPECT_NEAR((4 * area(fine) - area(coarse)) / 3, 12.6200173, 1e-4);
  EXPECT_NEAR((4 * volume(fine) - volume(coarse)) / 3, 2.7154735, 1e-4);
}

TEST(Mesh, BiconcaveIsThickestOnItsRingAndThinAtItsCentre) {
  double thickest = 0, radius = 0, centre = 1, nearest = 1;
  for (const Vector3d& x : Biconcave(1).mesh(32).vertices) {
    const double r = std::hypot(x[0], x[1]);
    if (x[2] > thickest) {
      thickest = x[2];
      radius = r;
    }
    if (r < nearest) {
      nearest = r;
      centre = std::abs(x[2]);
    }
  }
  // The nearest vertex is half an edge (.02) off, where the profile is flat.
  EXPECT_NEAR(thickest, .393079, 1e-4);
  EXPECT_NEAR(radius, .84001, .02);
  EXPECT_NEAR(centre, .1242, 1e-3);
}

class AnyFrequency : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Icosphere, AnyFrequency,
                         testing::Values(1, 2, 3, 4, 5, 6, 7, 9, 10, 12, 20),
                         testing::PrintToStringParamName());

TEST_P(AnyFrequency, IsAClosedOrientedSphere) {
  const int n = GetParam();
  const double radius = 2.5;
  const Mesh mesh = icosphere(n, radius);
  ASSERT_EQ(static_cast<long long>(mesh.triangles.size()), triangle_count(n));
  ASSERT_EQ(static_cast<long long>(mesh.vertices.size()), vertex_count(n));
  for (const Vector3d& x : mesh.vertices) EXPECT_NEAR(x.norm(), radius, 1e-14);

  std::set<std::pair<int, int>> half_edges;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(half_edges.insert({t[k], t[(k + 1) % 3]}).second);
    const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    EXPECT_GT((b - a).cross(c - a).dot(a + b + c), 0) << "points inward";
  }
  for (const auto& [tail, head] : half_edges) EXPECT_TRUE(half_edges.contains({head, tail}));
  const auto euler = static_cast<int>(mesh.vertices.size()) -
                     static_cast<int>(half_edges.size() / 2) +
                     static_cast<int>(mesh.triangles.size());
  EXPECT_EQ(euler, 2);
}

TEST(Icosphere, ConvergesAtSecondOrderForAnyFrequency) {
  for (const auto& [coarse, fine] : {std::pair{6, 12}, {12, 24}, {7, 21}, {5, 15}, {10, 30}}) {
    const Mesh a = icosphere(coarse, 1), b = icosphere(fine, 1);
    const double ratio = std::log(static_cast<double>(fine) / coarse);
    const double area_order = std::log((sphere_area - area(a)) / (sphere_area - area(b))) / ratio;
    const double volume_order =
        std::log((sphere_volume - volume(a)) / (sphere_volume - volume(b))) / ratio;
    EXPECT_NEAR(area_order, 2, .02) << coarse << " to " << fine;
    EXPECT_NEAR(volume_order, 2, .02) << coarse << " to " << fine;
  }
}

// Without the mesh: of all frequencies up to 32 to the digits given, of larger ones closely enough
// to tell neighbours apart, however they are divided.
TEST(Mesh, MeanEdgeOfAnIcosphereIsKnownWithoutIt) {
  for (int n = 1; n <= 32; ++n)
    EXPECT_NEAR(icosphere_mean_edge(n, 7) / mean_edge(icosphere(n, 7)), 1, 1e-9) << n;
  for (const int n : {33, 34, 36, 40, 46, 47, 48, 56, 60, 64, 66, 68, 72})
    EXPECT_NEAR(icosphere_mean_edge(n, 7) / mean_edge(icosphere(n, 7)), 1, 2e-6) << n;
  // The mesh that this asks for would have 1.4e9 triangles.
  EXPECT_NEAR(frequency_for_edge(2048, 0.3), 1.206 * 2048 / 0.3, 30);
}

TEST(Mesh, FrequencyForEdgeGivesTheNearestMeanEdge) {
  for (const double edge : {.5, .68, .87, 1.2, 1.4, 3.}) {
    const double radius = 7.2;
    const double error =
        std::abs(mean_edge(icosphere(frequency_for_edge(radius, edge), radius)) - edge);
    for (int n = 2; n <= 20; ++n)
      EXPECT_LE(error, std::abs(mean_edge(icosphere(n, radius)) - edge)) << n << " for " << edge;
  }
  EXPECT_EQ(frequency_for_edge(1, 100), 2);
}

TEST(Mesh, VertexAreasSumToTheArea) {
  const Mesh mesh = Biconcave(1.5).mesh(6);
  double sum = 0;
  for (const double a : vertex_areas(mesh)) sum += a;
  EXPECT_NEAR(sum, area(mesh), 1e-13);
}

// Vertices' normals are those of the surface to the mesh's own error.
TEST(Mesh, OffsetGoesAlongTheNormals) {
  for (const std::string_view name : shape_names()) {
    const auto shape = make_shape(name, 8);
    double before = 0;
    for (const int n : {8, 16, 32}) {
      const Mesh inner = shape->mesh(n, -0.4);
      const Mesh outer = shape->mesh(n);
      std::vector<double> positions;
      for (const Eigen::Vector3d& x : inner.vertices)
        positions.insert(positions.end(), x.begin(), x.end());
      EXPECT_EQ(offset(positions, inner.triangles, 0), positions);
      const std::vector<double> moved = offset(positions, inner.triangles, 0.4);
      double apart = 0;
      for (std::size_t v = 0; v < outer.vertices.size(); ++v)
        apart = std::max(apart, (Eigen::Vector3d::Map(&moved[3 * v]) - outer.vertices[v]).norm());
      std::printf("%s, n = %d: %.4f\n", std::string(name).c_str(), n, apart);
      EXPECT_LT(apart, n == 8 ? 0.1 : 0.6 * before) << name << ' ' << n;
      before = apart;
    }
  }
}

TEST(Mesh, PlaceRotatesAndThenShifts) {
  test::Random random;
  const Eigen::Matrix3d rotation = random.rotation();
  const Vector3d centre(3, -4, 50);
  const Mesh before = Biconcave(1).mesh(5);
  Mesh mesh = before;
  place(mesh, rotation, centre);
  EXPECT_NEAR(volume(mesh), volume(before), 1e-12);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    EXPECT_LT((rotation.transpose() * (mesh.vertices[i] - centre) - before.vertices[i]).norm(),
              1e-13);
  }
}

TEST(Mesh, RefusesWhatMakesNoSphere) {
  using test::expect_contains;
  using test::refusal;
  expect_contains(refusal([] { icosphere(0, 1); }), "frequency 0");
  expect_contains(refusal([] { icosphere(20000, 1); }), "frequency 20000");
  expect_contains(refusal([] { icosphere(4, 0); }), "radius 0");
  expect_contains(refusal([] { Biconcave(-1); }), "radius -1");
  expect_contains(refusal([] { icosphere(4, std::nan("")); }), "radius");
  expect_contains(refusal([] { frequency_for_edge(7, 0); }), "edge 0");
}

}  // namespace
}  // namespace ductile::surface
