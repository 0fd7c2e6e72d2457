// The same bits on any number of ranks: each rank also computes the whole fluid on its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "ductile/fluid/fluid.hpp"
#include "ductile/fluid/mpi.hpp"
#include "ductile/fluid/points.hpp"
#include "fluid/inside.hpp"
#include "fluid/precisions.hpp"

namespace {

using namespace ductile::fluid;
using ductile::test::patches;
using ductile::test::set_force;

// The integral of u_z over the volume, of a whole fluid's velocity field.
double flow_of(const Options& o, const std::vector<double>& u) {
  const auto weight = [&](std::size_t axis, int node) {
    if (axis == 1 && node == 0 && o.mirror != Mirror::none)
      return o.mirror == Mirror::on_node ? 0.5 : 1.0;
    const bool at_end = node == 0 || node == o.nodes[axis] - 1;
    return at_end && o.boundary[axis] == Boundary::regularized ? 0.5 : 1.0;
  };
  double sum = 0;
  std::size_t n = 2 * u.size() / 3;
  for (int i = 0; i < o.nodes[0]; ++i) {
    for (int j = 0; j < o.nodes[1]; ++j) {
      for (int k = 0; k < o.nodes[2]; ++k) sum += weight(0, i) * weight(1, j) * u[n++];
    }
  }
  return sum;
}

class Ranks : public testing::TestWithParam<
                  std::tuple<Boundary, Boundary, ductile::test::Precisions, Mirror>> {};

TEST_P(Ranks, FieldsAndTotalsAreTheSameToTheLastBit) {
  Options o;
  o.nodes = {9, 8, 13};
  o.boundary = {std::get<0>(GetParam()), std::get<0>(GetParam()), std::get<1>(GetParam())};
  std::get<2>(GetParam()).choose(o);
  o.mirror = std::get<3>(GetParam());
  const bool mirrored = o.mirror != Mirror::none;
  o.tau = 0.9;
  o.force = {0, 0, 1e-4};
  if (o.boundary[2] == Boundary::halfway) o.wall_velocity[2][1] = {0.01, mirrored ? 0 : 0.02, 0};
  if (o.boundary[0] != Boundary::periodic) o.wall_velocity[0][0] = {0, 0, 0.02};
  Fluid cut(MPI_COMM_WORLD, o);
  Fluid whole(MPI_COMM_SELF, o);
  const auto state = [](int i, int j, int k) {
    NodeState s;
    s.density = 1 + 0.01 * std::sin(1.1 * i + 0.7 * j - 1.9 * k);
    s.velocity = {0.02 * std::sin(0.9 * j + k), 0.01 * std::cos(i - 0.4 * k), 0.03 * std::sin(i)};
    return s;
  };
  const Range y = {mirrored ? -4 : 1, 5};
  const std::array<Box, 2> boxes = {Box{{{2, 6}, y, {-3, 4}}}, Box{{{2, 6}, y, {6, 9}}}};
  const bool wraps = o.boundary[2] == Boundary::periodic;
  for (Fluid* fluid : {&cut, &whole}) {
    fluid->initialise(state);
    fluid->place_boxes(std::span(boxes).subspan(wraps ? 0 : 1));
  }
  for (int step = 0; step < 5; ++step) {
    for (Fluid* fluid : {&cut, &whole}) {
      fluid->read_velocity();
      for (Patch& patch : patches(*fluid)) {
        for (int i = 0; i < patch.size[0]; ++i) {
          for (int j = 0; j < patch.size[1]; ++j) {
            for (int k = 0; k < patch.size[2]; ++k) {
              set_force(patch, 1, static_cast<std::size_t>(patch.at(i, j, k)),
                        1e-4 * (i - 2 * j) * (patch.begin[2] + k));
            }
          }
        }
      }
      fluid->step();
    }
    const auto columns =
        static_cast<std::size_t>(o.nodes[0]) * static_cast<std::size_t>(o.nodes[1]);
    const auto planes = static_cast<std::size_t>(o.nodes[2]);
    const auto own = static_cast<std::size_t>(cut.slab().size());
    std::vector<double> rho_cut(columns * own);
    std::vector<double> u_cut(3 * columns * own);
    cut.fields(rho_cut, u_cut);
    std::vector<double> rho(columns * planes);
    std::vector<double> u(3 * columns * planes);
    whole.fields(rho, u);
    for (std::size_t column = 0; column < columns; ++column) {
      for (std::size_t k = 0; k < own; ++k) {
        const std::size_t at = column * planes + static_cast<std::size_t>(cut.slab().begin) + k;
        ASSERT_EQ(rho_cut[column * own + k], rho[at]) << step;
        for (std::size_t a = 0; a < 3; ++a) {
          ASSERT_EQ(u_cut[a * rho_cut.size() + column * own + k], u[a * rho.size() + at]) << step;
        }
      }
    }
    const Totals a = cut.totals();
    const Totals b = whole.totals();
    EXPECT_EQ(a.mass, b.mass);
    EXPECT_EQ(a.momentum, b.momentum);
    EXPECT_EQ(cut.flow(), whole.flow());
    EXPECT_NEAR(whole.flow(), flow_of(o, u), 1e-15 * static_cast<double>(rho.size()));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, Ranks,
    testing::Combine(testing::Values(Boundary::periodic, Boundary::halfway, Boundary::regularized),
                     testing::Values(Boundary::periodic, Boundary::halfway),
                     testing::ValuesIn(ductile::test::precisions), testing::Values(Mirror::none)));
INSTANTIATE_TEST_SUITE_P(Mirrored, Ranks,
                         testing::Combine(testing::Values(Boundary::halfway, Boundary::regularized),
                                          testing::Values(Boundary::periodic, Boundary::halfway),
                                          testing::ValuesIn(ductile::test::precisions),
                                          testing::Values(Mirror::between_nodes, Mirror::on_node)));

// Each rank tells of each point what its own planes give, and nothing else: its velocity, where it
// has them all. Together they tell what one rank with the whole fluid does. What reached() says of
// a rank is what that rank finds.
TEST_P(Ranks, PointsAreToldTheSamePlaneByPlane) {
  Options o;
  o.nodes = {12, 12, 24};
  o.boundary = {std::get<0>(GetParam()), std::get<0>(GetParam()), std::get<1>(GetParam())};
  std::get<2>(GetParam()).choose(o);
  o.mirror = std::get<3>(GetParam());
  const bool wraps = o.boundary[2] == Boundary::periodic;
  constexpr std::size_t count = 60;
  std::vector<double> x;
  std::vector<double> force;
  for (std::size_t m = 0; m < count; ++m) {
    const auto a = static_cast<double>(m);
    x.insert(x.end(), {5.5 + 2.3 * std::sin(a), 5.5 + 2.3 * std::cos(3 * a),
                       wraps ? 12 + 11 * std::sin(5 * a) - 24 : 11.5 + 9 * std::sin(5 * a)});
    force.insert(force.end(), {1e-3 * std::cos(a), 1e-3 * std::sin(2 * a), 1e-3});
  }
  const Box reach = {{{2, 10}, {2, 10}, {wraps ? -24 : 1, wraps ? 0 : 23}}};
  Fluid cut(MPI_COMM_WORLD, o);
  Fluid whole(MPI_COMM_SELF, o);
  const std::array<Box, 1> boxes = {whole.box_around(reach)};
  std::vector<double> expected(3 * count);
  // Of each point its velocity, where a rank has it whole, how many do, and the four terms.
  constexpr std::size_t numbers = 16;
  std::vector<double> told(numbers * count);
  std::vector<int> reached;
  std::vector<std::size_t> split;
  const Communicator world(MPI_COMM_WORLD);
  cut.reached(world.rank(), x, reached, split);
  EXPECT_TRUE(cut.touches(world.rank(), boxes[0]));
  for (Fluid* fluid : {&cut, &whole}) {
    fluid->place_boxes(boxes);
    Points points(*fluid, 0);
    for (int step = 0; step < 3; ++step) {
      points.locate(x);
      points.add_force(force);
      fluid->step();
    }
    if (fluid == &whole) {
      EXPECT_EQ(points.split(), 0U);
      points.velocities(expected, {});
      continue;
    }
    std::vector<double> velocity(3 * count, 0.0);
    std::vector<double> partial(12 * points.split());
    points.velocities(velocity, partial);
    std::size_t next = 0;
    std::size_t next_split = 0;
    const double* terms = partial.data();
    for (std::size_t m = 0; m < count; ++m) {
      const bool here = next < reached.size() && reached[next] == static_cast<int>(m);
      const bool in_part = here && next_split < split.size() && split[next_split] == next;
      EXPECT_EQ(points.whole(m), here && !in_part);
      if (here) ++next;
      if (in_part) ++next_split;
      double* to = &told[numbers * m];
      std::copy_n(&velocity[3 * m], 3, to);
      to[3] = points.whole(m) ? 1 : 0;
      if (!points.whole(m)) {
        EXPECT_EQ(here, std::any_of(terms, terms + 12, [](double p) { return p != 0; }));
        std::copy_n(terms, 12, to + 4);
        terms += 12;
      }
    }
    EXPECT_EQ(next, reached.size());
    EXPECT_EQ(next_split, split.size());
  }
  // All but one of the terms are zero.
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, told.data(), static_cast<int>(told.size()), MPI_DOUBLE,
                          MPI_SUM, world.get()),
            "MPI_Allreduce");
  for (std::size_t m = 0; m < count; ++m) {
    const double* of = &told[numbers * m];
    EXPECT_LE(of[3], 1);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_EQ(of[3] == 1 ? of[a] : sum_of_planes(of + 4 + 4 * a), expected[3 * m + a]);
    }
  }
}

TEST(Slabs, ShareThePlanesEvenly) {
  Options o;
  o.nodes = {2, 2, 13};
  const Fluid fluid(MPI_COMM_WORLD, o);
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  int next = 0;
  for (int r = 0; r < ranks; ++r) {
    EXPECT_EQ(fluid.slab(r).begin, next);
    EXPECT_LE(std::abs(fluid.slab(r).size() - 13 / ranks), 1);
    next = fluid.slab(r).end;
  }
  EXPECT_EQ(next, 13);
}

// What a rank sends in a step are the five populations a column that cross each end of its slab,
// whatever the number of ranks.
TEST(Ranks, SendOnlyThePopulationsThatCross) {
  for (const ductile::test::Precisions& precision : ductile::test::precisions) {
    Options o;
    o.nodes = {9, 8, 16};
    precision.choose(o);
    Fluid fluid(MPI_COMM_WORLD, o);
    int ranks = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    constexpr int steps = 3;
    for (int n = 0; n < steps; ++n) fluid.step();
    const std::int64_t size = precision.all_double() ? 8 : 4;
    EXPECT_EQ(fluid.bytes_sent(), ranks == 1 ? 0 : steps * 2 * 5 * 9 * 8 * size);
  }
}

// Populations, what surrounds them in memory, and messages.
TEST(Ranks, MemoryIsLittleMoreThanThePopulations) {
  Options o;
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  o.nodes = {36, 36, 108 * ranks};
  const Fluid fluid(MPI_COMM_WORLD, o);
  const double populations = 19.0 * 8 * 36 * 36 * fluid.slab().size();
  EXPECT_GE(static_cast<double>(fluid.memory()), populations);
  EXPECT_LE(static_cast<double>(fluid.memory()), 1.15 * populations);
}

}  // namespace
