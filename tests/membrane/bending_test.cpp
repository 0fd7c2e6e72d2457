// The bending energy against exact solutions.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "membrane/support.hpp"

namespace ductile::membrane {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;
using std::numbers::sqrt3;
using test::Points;

constexpr Moduli bending{.k_b = 1};

TEST(Bending, SphereThatIsFlatAtRestHasTheTabulatedEnergy) {
  for (const auto& [frequency, energy] : {std::pair{16, 13.0104}, {32, 13.0230}}) {
    const Mesh sphere = icosphere(frequency, 3);
    const Shell shell(sphere, bending, {.flat_reference_angles = true});
    EXPECT_NEAR(test::energies(shell, sphere.vertices).bending, energy, 1e-4);
  }
}

// n x n cells of the equilateral lattice of edge 1, turned by `angle`.
Mesh lattice(int n, double angle) {
  Mesh mesh;
  const Eigen::Rotation2Dd turn(angle);
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const Eigen::Vector2d x = turn * Eigen::Vector2d(i + .5 * j, sqrt3 / 2 * j);
      mesh.vertices.emplace_back(x[0], x[1], 0);
    }
  }
  const auto id = [n](int i, int j) { return i * (n + 1) + j; };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i, j + 1)});
      mesh.triangles.push_back({id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return mesh;
}

Points rolled(Points points, double radius) {
  for (Vector3d& x : points) {
    const double angle = x[0] / radius;
    x = {radius * std::sin(angle), x[1], radius * std::cos(angle)};
  }
  return points;
}

// Helfrich's energy density of a cylinder is kappa/(2 R^2) with kappa = 1.5 k_b, which is what
// eq. (10) means. The rim's missing hinges are in proportion to n: E(2n) - 2 E(n) is without.
TEST(Bending, RolledSheetHasTheEnergyOfACylinderAtAnyLatticeAngle) {
  const double radius = 20;  // in edges; the rest is of order 1/radius^2
  for (int step = 0; step < 12; ++step) {
    const double angle = pi / 3 * step / 12;
    double energy = 0, surface = 0;
    for (const auto& [n, weight] : {std::pair{20, 1}, {10, -2}}) {
      const Mesh sheet = lattice(n, angle);
      const Shell shell(sheet, bending, {.open_sheet = true});
      energy += weight * test::energies(shell, rolled(sheet.vertices, radius)).bending;
      surface += weight * area(sheet);
    }
    const double expected = 1.5 / (2 * radius * radius);
    EXPECT_NEAR(energy / surface, expected, .005 * expected) << "lattice angle " << angle;
  }
}

// Two triangles that share an edge, folded by `angle` out of the plane, down being positive.
Points folded(double angle) {
  return {{0, 0, 0}, {1, 0, 0}, {.3, .8, 0}, {.6, -.9 * std::cos(angle), -.9 * std::sin(angle)}};
}

TEST(Bending, FoldCostsOneMinusCosineOfItsSignedAngleFromRest) {
  for (const double rest : {-2., -.4, 0., .3, 1.2, 2.5}) {
    const Mesh mesh{folded(rest), {{0, 1, 2}, {1, 0, 3}}};
    const Shell shell(mesh, bending, {.open_sheet = true});
    for (const double angle : {-3., -1.7, -.3, 0., .4, 1.5, 2.9}) {
      EXPECT_NEAR(test::energies(shell, folded(angle)).bending,
                  sqrt3 * (1 - std::cos(angle - rest)), 1e-13);
      // The wing's torque about the edge.
      const Points f = test::forces(shell, folded(angle));
      const Vector3d down(0, std::sin(angle), -std::cos(angle));
      EXPECT_NEAR(f[3].dot(down) * .9, -sqrt3 * std::sin(angle - rest), 1e-13);
    }
  }
}

}  // namespace
}  // namespace ductile::membrane
