#include "ductile/fluid/points.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include "ductile/fluid/delta.hpp"
#include "fluid/inside.hpp"
#include "fluid/precisions.hpp"
#include "support/random_numbers.hpp"

namespace {

using namespace ductile::fluid;
using ductile::available;
using ductile::best_instruction_set;
using ductile::InstructionSet;
using ductile::test::force_of;
using ductile::test::nodes_of;
using ductile::test::patches;
using ductile::test::Precisions;
using ductile::test::precisions;
using ductile::test::set_velocity;
using ductile::test::velocity_of;
using ductile::testing_support::random_numbers;

// A fluid with one box: all of it.
Fluid boxed(const std::array<int, 3>& nodes, Boundary z, const Precisions& precision,
            InstructionSet set = best_instruction_set()) {
  Options o;
  precision.choose(o);
  o.nodes = nodes;
  o.boundary = {Boundary::halfway, Boundary::halfway, z};
  o.instruction_set = set;
  Fluid fluid(MPI_COMM_SELF, o);
  const std::array<Box, 1> boxes = {fluid.domain()};
  fluid.place_boxes(boxes);
  return fluid;
}

// Relative, of one number, in the precision of the boxes.
double round_off(const Precisions& precision) {
  return precision.all_single() ? 3e-7 : 2e-16;
}

void for_nodes(const Patch& patch,
               const std::function<void(std::size_t, const Eigen::Vector3d&)>& f) {
  for (int i = 0; i < patch.size[0]; ++i) {
    for (int j = 0; j < patch.size[1]; ++j) {
      for (int k = 0; k < patch.size[2]; ++k) {
        f(static_cast<std::size_t>(patch.at(i, j, k)),
          {static_cast<double>(patch.begin[0] + i), static_cast<double>(patch.begin[1] + j),
           static_cast<double>(patch.begin[2] + k)});
      }
    }
  }
}

// Of points that are all whole.
std::vector<double> velocities(const Points& points) {
  std::vector<double> velocity(3 * points.size(), NAN);
  points.velocities(velocity, {});
  return velocity;
}

std::vector<std::pair<InstructionSet, Precisions>> sets_and_precisions() {
  std::vector<std::pair<InstructionSet, Precisions>> all;
  for (const auto& precision : precisions) {
    for (const auto set :
         {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
      if (available(set)) all.emplace_back(set, precision);
    }
  }
  return all;
}

// A point's nodes and weights are those of weights(), whichever instructions compute them.
TEST(Points, MeetTheNodesWithTheWeightsOfTheDeltaFunction) {
  std::vector<double> coordinates = random_numbers(30, 2.0, 9.0, 21);
  for (const double special : {3.0, 4.5, 7.25, std::nextafter(4.0, 0.0), std::nextafter(4.0, 9.0)})
    coordinates.push_back(special);
  for (const auto& [set, precision] : sets_and_precisions()) {
    const double relative = precision.all_single() ? round_off(precision) : 0;
    const double smallest = precision.all_single() ? 1e-37 : 0;  // below it floats lose digits
    for (std::size_t n = 0; n + 2 < coordinates.size(); ++n) {
      Fluid fluid = boxed({12, 12, 12}, Boundary::halfway, precision, set);
      Points point(fluid, 0);
      const std::span x = std::span(coordinates).subspan(n, 3);
      point.locate(x);
      point.add_force(std::vector<double>{0, 1, 0});
      std::size_t reached = 0;
      const Patch& patch = patches(fluid).at(0);
      for_nodes(patch, [&](std::size_t node, const Eigen::Vector3d& at) {
        double phi[3] = {};
        for (int axis = 0; axis < 3; ++axis) {
          const Weights w = weights(x[static_cast<std::size_t>(axis)]);
          const int k = static_cast<int>(at[axis]) - w.base;
          if (k >= 0 && k < 4) phi[axis] = w.phi[static_cast<std::size_t>(k)];
        }
        const double expected = phi[0] * phi[1] * phi[2];
        EXPECT_NEAR(force_of(patch, 1, node), expected, std::abs(expected) * relative + smallest);
        if (force_of(patch, 1, node) != 0) ++reached;
      });
      EXPECT_GE(reached, 27U);
    }
  }
}

class ImmersedBoundary : public testing::TestWithParam<Precisions> {};
INSTANTIATE_TEST_SUITE_P(InEach, ImmersedBoundary, testing::ValuesIn(precisions),
                         [](const auto& test) { return test.param.name; });

// F . (J u) = (J^T F) . u, with and without a periodic z in which stencils meet both ends.
TEST_P(ImmersedBoundary, SpreadIsAdjointOfInterpolate) {
  for (const Boundary z : {Boundary::halfway, Boundary::periodic}) {
    Fluid fluid = boxed({10, 10, 12}, z, GetParam());
    constexpr std::size_t count = 200;
    std::vector<double> x = random_numbers(3 * count, 1.0, 8.0, 2);
    if (z == Boundary::periodic) {
      for (std::size_t m = 0; m < count; ++m) x[3 * m + 2] = 6 * x[3 * m + 2] - 20;
    }
    const std::vector<double> force = random_numbers(3 * count, -1, 1, 3);
    Patch& patch = patches(fluid).at(0);
    const std::vector<double> u = random_numbers(3 * nodes_of(patch), -1, 1, 4);
    for_nodes(patch, [&](std::size_t n, const Eigen::Vector3d&) {
      for (std::size_t a = 0; a < 3; ++a) set_velocity(patch, a, n, u[3 * n + a]);
    });
    Points points(fluid, 0);
    points.locate(x);
    points.add_force(force);
    const std::vector<double> velocity = velocities(points);
    double points_side = 0;
    double size = 0;
    for (std::size_t n = 0; n < 3 * count; ++n) {
      points_side += force[n] * velocity[n];
      size += std::abs(force[n] * velocity[n]);
    }
    double nodes_side = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      double spread = 0;
      for_nodes(patch, [&](std::size_t n, const Eigen::Vector3d&) {
        nodes_side += force_of(patch, a, n) * velocity_of(patch, a, n);
        spread += force_of(patch, a, n);
      });
      double total = 0;
      for (std::size_t m = 0; m < count; ++m) total += force[3 * m + a];
      // Of 200 forces up to 1 each.
      EXPECT_NEAR(spread, total, 200 * round_off(GetParam()));
    }
    EXPECT_NEAR(points_side, nodes_side, round_off(GetParam()) * size);
  }
}

// What a lesser machine would run gives the same bits.
TEST_P(ImmersedBoundary, IsTheSameWithEachInstructionSet) {
  constexpr std::size_t count = 100;
  const std::vector<double> x = random_numbers(3 * count, 1.0, 8.0, 12);
  const std::vector<double> force = random_numbers(3 * count, -1, 1, 13);
  // Where z is periodic some points reach over the end, to both ends of the patch.
  for (const auto& [z, shift] : {std::pair(Boundary::halfway, 0.0), {Boundary::periodic, 5.0}}) {
    std::vector<double> at = x;
    for (std::size_t m = 0; m < count; ++m) at[3 * m + 2] += shift;
    std::vector<double> expected_force;
    std::vector<double> expected_velocity;
    for (const auto set :
         {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
      if (!available(set)) continue;
      Fluid fluid = boxed({10, 10, 12}, z, GetParam(), set);
      Points points(fluid, 0);
      points.locate(at);
      points.add_force(force);
      Patch& patch = patches(fluid).at(0);
      std::vector<double> spread;
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t n = 0; n < nodes_of(patch); ++n) {
          spread.push_back(force_of(patch, a, n));
          set_velocity(patch, a, n, spread.back());
        }
      }
      const std::vector<double> velocity = velocities(points);
      if (set == InstructionSet::baseline) {
        expected_force = spread;
        expected_velocity = velocity;
      }
      EXPECT_EQ(spread, expected_force);
      EXPECT_EQ(velocity, expected_velocity);
    }
  }
}

// sum over nodes of (X - x) x f vanishes: spreading keeps the torque about the point.
TEST_P(ImmersedBoundary, SpreadKeepsForceAndTorque) {
  Fluid fluid = boxed({6, 6, 6}, Boundary::halfway, GetParam());
  const std::vector<double> x = {2.3, 2.71, 2.05};
  const std::vector<double> force = {1, -2, 0.5};
  Points points(fluid, 0);
  points.locate(x);
  points.add_force(force);
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
  const Patch& patch = patches(fluid).at(0);
  for_nodes(patch, [&](std::size_t n, const Eigen::Vector3d& node) {
    const Eigen::Vector3d r = node - Eigen::Vector3d::Map(x.data());
    torque += r.cross(
        Eigen::Vector3d(force_of(patch, 0, n), force_of(patch, 1, n), force_of(patch, 2, n)));
  });
  EXPECT_LT(torque.norm(), 50 * round_off(GetParam()));
}

TEST_P(ImmersedBoundary, InterpolationIsExactForLinearFields) {
  Fluid fluid = boxed({8, 8, 8}, Boundary::halfway, GetParam());
  Patch& patch = patches(fluid).at(0);
  for_nodes(patch, [&](std::size_t n, const Eigen::Vector3d& node) {
    set_velocity(patch, 1, n, 1 + 2 * node.x() - node.y() + 0.5 * node.z());
  });
  const std::vector<double> x = {3.14, 2.72, 4.67};
  Points points(fluid, 0);
  points.locate(x);
  const double u = 1 + 2 * x[0] - x[1] + 0.5 * x[2];
  EXPECT_NEAR(velocities(points)[1], u, 100 * round_off(GetParam()));
}

// Forces that balance, the same in every step: what rounding leaves of them would pile up.
TEST_P(ImmersedBoundary, ForcesThatBalanceGiveNoMomentum) {
  Options o;
  GetParam().choose(o);
  o.nodes = {16, 16, 16};
  Fluid fluid(MPI_COMM_SELF, o);
  const std::array<Box, 1> boxes = {Box{{{2, 14}, {2, 14}, {2, 14}}}};
  fluid.place_boxes(boxes);
  constexpr std::size_t count = 300;
  constexpr int steps = 1000;
  const std::vector<double> x = random_numbers(3 * count, 4.0, 11.0, 31);
  std::vector<double> force = random_numbers(3 * count, -1e-5, 1e-5, 32);
  double sum_of_sizes = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    double total = 0;
    for (std::size_t m = 0; m < count; ++m) total += force[3 * m + a];
    for (std::size_t m = 0; m < count; ++m) {
      force[3 * m + a] -= total / count;
      sum_of_sizes += std::abs(force[3 * m + a]);
    }
  }
  Points points(fluid, 0);
  points.locate(x);
  for (int step = 0; step < steps; ++step) {
    points.add_force(force);
    fluid.step();
  }
  const double share = GetParam().all_double() ? 2e-16 : (GetParam().all_single() ? 5e-9 : 2e-10);
  EXPECT_LT(fluid.totals().momentum.norm(), share * steps * sum_of_sizes);
}

// Without looking inside: the fluid gains the points' force as momentum, and tells its velocity
// with half of the force of the step in.
TEST(Points, ForceActsAndVelocityIsToldThroughTheInterfaceAlone) {
  Options o;
  o.nodes = {12, 12, 12};
  Fluid fluid(MPI_COMM_SELF, o);
  const std::vector<double> x = {5.3, 6.7, 4.1};
  const std::vector<double> force = {1e-3, -2e-3, 5e-4};
  const std::array<Box, 1> boxes = {fluid.box_around({{{4, 8}, {5, 9}, {3, 7}}})};
  fluid.place_boxes(boxes);
  Points points(fluid, 0);
  points.locate(x);
  EXPECT_TRUE(points.whole(0));
  points.add_force(force);
  fluid.step();
  const std::vector<double> u = velocities(points);
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(u[a], 0.5 * std::pow(3.0 / 8.0, 3) * force[a], 1e-17);
    EXPECT_NEAR(fluid.totals().momentum[static_cast<Eigen::Index>(a)], force[a], 1e-16);
  }
}

// What was added before belongs to the state before.
TEST(Points, ForceIsDroppedWhereTheFluidStartsAgain) {
  Options o;
  o.nodes = {12, 12, 12};
  Fluid fluid(MPI_COMM_SELF, o);
  const std::array<Box, 1> boxes = {Box{{{2, 10}, {2, 10}, {2, 10}}}};
  fluid.place_boxes(boxes);
  Points points(fluid, 0);
  points.locate(std::vector<double>{5, 6, 5});
  points.add_force(std::vector<double>{1e-3, 0, 0});
  fluid.initialise([](int, int, int) { return NodeState{}; });
  fluid.step();
  EXPECT_TRUE(fluid.totals().momentum.isZero(0));
}

// Boxes that overlap are one to the fluid: what acts in one is felt in the other.
TEST(Points, OfBoxesThatOverlapFeelEachOther) {
  Options o;
  o.nodes = {16, 16, 24};
  Fluid fluid(MPI_COMM_SELF, o);
  // The first and the last meet across the periodic end, and the last overlaps the second.
  const std::array<Box, 3> boxes = {Box{{{2, 8}, {2, 8}, {-4, 4}}},
                                    Box{{{6, 12}, {6, 12}, {10, 18}}},
                                    Box{{{2, 8}, {2, 8}, {16, 22}}}};
  fluid.place_boxes(boxes);
  Points pushed(fluid, 0);
  Points watched(fluid, 2);
  pushed.locate(std::vector<double>{4.5, 4.5, -2.5});
  watched.locate(std::vector<double>{4.5, 4.5, 19.5});
  pushed.add_force(std::vector<double>{0, 0, 1e-3});
  fluid.step();
  EXPECT_GT(velocities(watched)[2], 0);
}

TEST(Boxes, HoldTheReachWithRoomToMoveAndKeepToTheDomain) {
  Options o;
  o.nodes = {20, 20, 50};
  o.boundary = {Boundary::regularized, Boundary::halfway, Boundary::periodic};
  Fluid fluid(MPI_COMM_SELF, o);
  const Box inside = fluid.box_around({{{5, 12}, {6, 12}, {-3, 6}}});
  EXPECT_EQ(inside, (Box{{{4, 13}, {5, 13}, {-5, 8}}}));
  const Box at_walls = fluid.box_around({{{1, 19}, {0, 20}, {0, 47}}});
  EXPECT_EQ(at_walls, (Box{{{1, 19}, {0, 20}, {-2, 48}}}));  // no longer than the channel
  for (const Box& box : {inside, at_walls}) {
    const std::array<Box, 1> boxes = {box};
    EXPECT_NO_THROW(fluid.place_boxes(boxes));
  }
}

}  // namespace
