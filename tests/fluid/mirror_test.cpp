// Half of a symmetric fluid on a mirror plane is the whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <variant>

#include "ductile/fluid/fluid.hpp"
#include "fluid/inside.hpp"
#include "fluid/precisions.hpp"

namespace {

using namespace ductile::fluid;
using ductile::test::density_of;
using ductile::test::force_of;
using ductile::test::momentum_of;
using ductile::test::nodes_of;
using ductile::test::patches;
using ductile::test::set_force;
using ductile::test::velocity_of;

constexpr int nx = 7;
constexpr int nz = 13;

// A fluid in whole and in half, and where row 0 of the half is in the whole.
struct Pair {
  Options whole;
  Options half;
  int first_row = 0;
};

Pair pair_of(Mirror mirror, Boundary walls_x, Boundary walls_y, Boundary ends) {
  Options o;
  const int rows = 6;
  const int whole_rows = mirror == Mirror::between_nodes ? 2 * rows : 2 * rows - 1;
  o.nodes = {nx, whole_rows, nz};
  o.boundary = {walls_x, walls_y, ends};
  o.tau = 0.8;
  o.force = {1e-4, 0, 3e-4};
  o.wall_velocity[0] = {Eigen::Vector3d(0, 0, 0.02), Eigen::Vector3d(0, 0, -0.01)};
  if (ends == Boundary::halfway) o.wall_velocity[2][1] = {0.01, 0, 0};
  Options half = o;
  half.nodes[1] = rows;
  half.mirror = mirror;
  return {o, half, whole_rows - rows};
}

// Symmetric about eta = 0, to the last bit.
NodeState state_at(int i, double eta, int k) {
  NodeState s;
  s.density = 1 + 0.01 * std::sin(1.1 * i - 1.9 * k) * std::cos(0.7 * eta);
  s.velocity = {0.02 * std::cos(0.9 * eta) * std::sin(0.5 * k), 0.01 * std::sin(eta) * i,
                0.03 * std::sin(i + std::cos(eta))};
  return s;
}
Eigen::Vector3d force_at(int i, double eta, int k, int step) {
  return 1e-3 *
         Eigen::Vector3d(std::cos(eta) * i, std::sin(0.8 * eta) * k, std::cos(0.5 * eta) + step);
}

double eta_of(const Options& o, int y) {
  const double plane = o.mirror == Mirror::none            ? 0.5 * (o.nodes[1] - 1)
                       : o.mirror == Mirror::between_nodes ? -0.5
                                                           : 0;
  return y - plane;
}

// The half is given half of the force, on both sides: each is the other's image, and adds it. Along
// y on the plane nothing is left of it.
void force(Fluid& fluid, int step) {
  const bool mirrored = fluid.options().mirror != Mirror::none;
  for (Patch& patch : patches(fluid)) {
    for (int i = 0; i < patch.size[0]; ++i) {
      for (int j = 0; j < patch.size[1]; ++j) {
        for (int k = 0; k < patch.size[2]; ++k) {
          const double eta = eta_of(fluid.options(), patch.begin[1] + j);
          Eigen::Vector3d f = force_at(patch.begin[0] + i, eta, patch.begin[2] + k, step);
          if (mirrored) f *= 0.5;
          if (mirrored && eta == 0) f.y() = 7;
          for (std::size_t a = 0; a < 3; ++a) {
            set_force(patch, a, static_cast<std::size_t>(patch.at(i, j, k)),
                      f[static_cast<Eigen::Index>(a)]);
          }
        }
      }
    }
  }
}

void expect_same_patches(Fluid& half, Fluid& whole, int first_row, double round_off,
                         const char* when) {
  ASSERT_EQ(patches(half).size(), patches(whole).size());
  for (std::size_t p = 0; p < patches(half).size(); ++p) {
    const Patch& a = patches(half)[p];
    const Patch& b = patches(whole)[p];
    ASSERT_EQ(a.size, b.size);
    ASSERT_EQ(a.begin[1] + first_row, b.begin[1]);
    for (std::size_t n = 0; n < nodes_of(a); ++n) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_NEAR(velocity_of(a, axis, n), velocity_of(b, axis, n), round_off)
            << when << ' ' << axis;
      }
    }
    // Of a density in single precision the last digit is worth more than the populations'
    // round-off.
    const bool single = std::holds_alternative<LocalFields<float>>(a.local);
    const double last_digit = single ? std::numeric_limits<float>::epsilon() : 0;
    const double of_density = round_off > 0 ? std::max(round_off, last_digit) : 0;
    // Below the plane there is neither density nor momentum: the velocity's image is made of
    // itself.
    for (int i = 0; i < a.size[0]; ++i) {
      for (int j = std::max(0, -a.begin[1]); j < a.size[1]; ++j) {
        for (int k = 0; k < a.size[2]; ++k) {
          const auto n = static_cast<std::size_t>(a.at(i, j, k));
          ASSERT_NEAR(density_of(a, n), density_of(b, n), of_density) << when;
          for (std::size_t axis = 0; axis < 3; ++axis) {
            ASSERT_NEAR(momentum_of(a, axis, n), momentum_of(b, axis, n), round_off)
                << when << ' ' << axis;
          }
        }
      }
    }
  }
}

class HalfAndWhole
    : public testing::TestWithParam<
          std::tuple<Mirror, Boundary, Boundary, Boundary, Collision, ductile::test::Precisions>> {
};

// To the last bit, unless there are regularized walls: their rule adds up populations one by one.
TEST_P(HalfAndWhole, AreTheSame) {
  const auto [mirror, walls_x, walls_y, ends, collision, precision] = GetParam();
  Pair p = pair_of(mirror, walls_x, walls_y, ends);
  p.whole.collision = p.half.collision = collision;
  for (Options* options : {&p.whole, &p.half}) precision.choose(*options);
  const double unequal_sums = precision.all_double() ? 1e-13 : 1e-8;
  const bool on_nodes = walls_x == Boundary::regularized || walls_y == Boundary::regularized;
  const double round_off = on_nodes ? unequal_sums : 0;
  Fluid whole(MPI_COMM_SELF, p.whole);
  Fluid half(MPI_COMM_SELF, p.half);
  for (Fluid* fluid : {&whole, &half}) {
    fluid->initialise(
        [&](int i, int j, int k) { return state_at(i, eta_of(fluid->options(), j), k); });
  }
  // Across the plane, and over the periodic end.
  const bool wraps = ends == Boundary::periodic;
  const int low = half.options().mirror == Mirror::between_nodes ? -4 : -3;
  const std::array<Box, 1> across = {Box{{{1, 5}, {low, 4}, {wraps ? -4 : 2, 8}}}};
  std::array<Box, 1> moved = across;
  moved[0][1] = {low + p.first_row, 4 + p.first_row};
  half.place_boxes(across);
  whole.place_boxes(moved);

  const auto rows = static_cast<std::size_t>(p.half.nodes[1]);
  const auto whole_rows = static_cast<std::size_t>(p.whole.nodes[1]);
  for (int step = 0; step < 7; ++step) {
    for (Fluid* fluid : {&whole, &half}) {
      fluid->read_velocity();
      force(*fluid, step);
      fluid->update_velocity();
    }
    expect_same_patches(half, whole, p.first_row, round_off, "as told");
    for (Fluid* fluid : {&whole, &half}) {
      force(*fluid, step);
      fluid->step();
    }
    expect_same_patches(half, whole, p.first_row, round_off, "as left");
    for (const Patch& patch : patches(half)) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t n = 0; n < nodes_of(patch); ++n) ASSERT_EQ(force_of(patch, axis, n), 0);
      }
    }

    std::vector<double> rho(nx * rows * nz);
    std::vector<double> u(3 * rho.size());
    half.fields(rho, u);
    std::vector<double> rho_whole(nx * whole_rows * nz);
    std::vector<double> u_whole(3 * rho_whole.size());
    whole.fields(rho_whole, u_whole);
    for (std::size_t i = 0; i < nx; ++i) {
      for (std::size_t j = 0; j < rows; ++j) {
        for (std::size_t k = 0; k < nz; ++k) {
          const std::size_t n = (i * rows + j) * nz + k;
          const std::size_t m =
              (i * whole_rows + j + static_cast<std::size_t>(p.first_row)) * nz + k;
          ASSERT_NEAR(rho[n], rho_whole[m], round_off) << step << ' ' << i << ' ' << j << ' ' << k;
          for (std::size_t a = 0; a < 3; ++a) {
            ASSERT_NEAR(u[a * rho.size() + n], u_whole[a * rho_whole.size() + m], round_off)
                << step << ' ' << a << ' ' << i << ' ' << j << ' ' << k;
          }
        }
      }
    }
    const double sum_round_off = 1e-12 + static_cast<double>(rho_whole.size()) * round_off;
    const Totals t = half.totals();
    const Totals t_whole = whole.totals();
    EXPECT_NEAR(2 * t.mass, t_whole.mass, sum_round_off);
    EXPECT_NEAR(2 * t.momentum.x(), t_whole.momentum.x(), sum_round_off);
    EXPECT_NEAR(2 * t.momentum.z(), t_whole.momentum.z(), sum_round_off);
    EXPECT_NEAR(2 * half.flow(), whole.flow(), sum_round_off);
  }
}

INSTANTIATE_TEST_SUITE_P(All, HalfAndWhole,
                         testing::Combine(testing::Values(Mirror::between_nodes, Mirror::on_node),
                                          testing::Values(Boundary::periodic, Boundary::halfway,
                                                          Boundary::regularized),
                                          testing::Values(Boundary::halfway, Boundary::regularized),
                                          testing::Values(Boundary::periodic, Boundary::halfway),
                                          testing::Values(Collision::bgk, Collision::trt),
                                          testing::ValuesIn(ductile::test::precisions)));

TEST(Mirror, BodiesMayActUpToTheImageOfTheWall) {
  for (const Mirror mirror : {Mirror::between_nodes, Mirror::on_node}) {
    for (const Boundary walls : {Boundary::halfway, Boundary::regularized}) {
      const Pair p = pair_of(mirror, walls, walls, Boundary::periodic);
      const Fluid whole(MPI_COMM_SELF, p.whole);
      Fluid half(MPI_COMM_SELF, p.half);
      EXPECT_EQ(half.domain()[1].begin + p.first_row, whole.domain()[1].begin);
      EXPECT_EQ(half.domain()[1].end + p.first_row, whole.domain()[1].end);
      const Box all = half.domain();
      Box lower = all;
      lower[1].end = 1;
      EXPECT_EQ(half.box_around(lower)[1], all[1]);
      const std::array<Box, 1> boxes = {lower};
      half.place_boxes(boxes);
      ASSERT_EQ(patches(half).size(), 1U);
      EXPECT_EQ(patches(half)[0].begin[1], all[1].begin);
      EXPECT_EQ(patches(half)[0].size[1], all[1].size());
    }
  }
}

TEST(Mirror, RefusesWhatIsNotSymmetric) {
  const auto message = [](auto&& change) -> std::string {
    Options o =
        pair_of(Mirror::on_node, Boundary::halfway, Boundary::halfway, Boundary::halfway).half;
    change(o);
    try {
      const Fluid fluid(MPI_COMM_SELF, o);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message([](Options&) {}), "");
  EXPECT_NE(message([](Options& o) { o.boundary[1] = Boundary::periodic; }).find("needs a wall"),
            std::string::npos);
  EXPECT_NE(message([](Options& o) {
              o.wall_velocity[1][0] = {0, 0, 0.1};
            }).find("no velocity"),
            std::string::npos);
  EXPECT_NE(message([](Options& o) {
              o.wall_velocity[0][0] = {0, 0.1, 0};
            }).find("along y"),
            std::string::npos);
  EXPECT_NE(message([](Options& o) { o.force.y() = 1e-4; }).find("force along y"),
            std::string::npos);
}

}  // namespace
