#include "ductile/fluid/fluid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "fluid/inside.hpp"
#include "fluid/precisions.hpp"
#include "fluid/two_lattice.hpp"

namespace {

using namespace ductile::fluid;
using ductile::available;
using ductile::best_instruction_set;
using ductile::InstructionSet;
using ductile::test::force_of;
using ductile::test::nodes_of;
using ductile::test::patches;
using ductile::test::set_force;
using ductile::test::TwoLattice;
using ductile::test::velocity_of;

constexpr auto periodic = Boundary::periodic;
constexpr auto halfway = Boundary::halfway;
constexpr auto regularized = Boundary::regularized;

// A smooth state without symmetries.
NodeState wavy(const Options& o, int i, int j, int k) {
  const auto angle = [](int n, int size) { return 2 * M_PI * n / size; };
  const double x = angle(i, o.nodes[0]);
  const double y = angle(j, o.nodes[1]);
  const double z = angle(k, o.nodes[2]);
  NodeState s;
  s.density = 1 + 0.01 * std::sin(x + 2 * y) * std::cos(z);
  s.velocity = {0.02 * std::sin(y + 0.3), 0.03 * std::cos(z + x), -0.01 * std::sin(2 * x + z)};
  return s;
}

// What the node weighs in its momentum.
double weighing(const Options& o, const NodeState& s) {
  return o.equilibrium == Equilibrium::compressible ? s.density : 1;
}

constexpr std::array equilibria = {Equilibrium::compressible, Equilibrium::incompressible};

// Each precision with each equilibrium.
std::vector<std::pair<ductile::test::Precisions, Equilibrium>> methods() {
  std::vector<std::pair<ductile::test::Precisions, Equilibrium>> all;
  for (const ductile::test::Precisions& precision : ductile::test::precisions) {
    for (const Equilibrium equilibrium : equilibria) all.emplace_back(precision, equilibrium);
  }
  return all;
}

struct Field {
  std::vector<double> density;
  std::vector<double> velocity;
};
Field fields(Fluid& fluid) {
  const auto& n = fluid.options().nodes;
  const auto count = static_cast<std::size_t>(n[0] * n[1] * fluid.slab().size());
  Field field{std::vector<double>(count), std::vector<double>(3 * count)};
  fluid.fields(field.density, field.velocity);
  return field;
}

struct Case {
  const char* name;
  std::array<Boundary, 3> boundary;
  Collision collision;
  bool moving_walls;
  bool patches;
};

class InPlace
    : public testing::TestWithParam<std::tuple<Case, ductile::test::Precisions, Equilibrium>> {};

// The in-place step, with its walls, moving walls and boxes of local force, is the lattice
// Boltzmann equation: density and velocity agree with the two-lattice code, which is in double
// precision, to round-off, after odd and after even numbers of steps.
TEST_P(InPlace, StepIsTheLatticeBoltzmannEquation) {
  const Case& test = std::get<0>(GetParam());
  const ductile::test::Precisions& precision = std::get<1>(GetParam());
  const double round_off = precision.all_double() ? 1e-13 : 2e-7;
  Options o;
  precision.choose(o);
  o.nodes = {7, 6, 9};
  o.boundary = test.boundary;
  o.collision = test.collision;
  o.equilibrium = std::get<2>(GetParam());
  o.tau = 0.8;
  o.force = {1e-4, -2e-4, 3e-4};
  if (test.moving_walls) {
    o.wall_velocity[0] = {Eigen::Vector3d(0, 0.01, 0.02), Eigen::Vector3d(0, -0.03, 0.01)};
    if (o.boundary[1] != periodic) o.wall_velocity[1][1] = {0.02, 0, -0.03};
    o.wall_velocity[2] = {Eigen::Vector3d(0.02, 0.01, 0), Eigen::Vector3d(0, 0.02, 0)};
  }
  Fluid fluid(MPI_COMM_WORLD, o);
  fluid.initialise([&](int i, int j, int k) { return wavy(o, i, j, k); });

  TwoLattice reference(o);
  for (int x = 0; x < o.nodes[0]; ++x) {
    for (int y = 0; y < o.nodes[1]; ++y) {
      for (int z = 0; z < o.nodes[2]; ++z) {
        const NodeState s = wavy(o, x, y, z);
        for (int i = 0; i < d3q19::Q; ++i) {
          const auto c = d3q19::c(i);
          const Eigen::Vector3d e(c[0], c[1], c[2]);
          const double cu = e.dot(s.velocity);
          const double forcing = (3 * (e - s.velocity) + 9 * cu * e).dot(o.force);
          reference.f(i, x, y, z) =
              d3q19::w(i) *
              (s.density +
               weighing(o, s) * (3 * cu + 4.5 * cu * cu - 1.5 * s.velocity.squaredNorm()) -
               0.5 * forcing);
        }
      }
    }
  }

  const auto local = [&](int x, int y, int z) -> Eigen::Vector3d {
    if (!test.patches || x < 2 || x > 5 || y < 1 || y > 4 || z < 3 || z > 6) {
      return Eigen::Vector3d::Zero();
    }
    return 1e-4 * Eigen::Vector3d(x - y, z - 4, x + 0.5 * y);
  };
  if (test.patches) {
    const std::array<Box, 1> boxes = {Box{{{2, 6}, {1, 5}, {3, 7}}}};
    fluid.place_boxes(boxes);
  }
  for (int step = 1; step <= 7; ++step) {
    fluid.read_velocity();
    for (Patch& patch : patches(fluid)) {
      for (int i = 0; i < patch.size[0]; ++i) {
        for (int j = 0; j < patch.size[1]; ++j) {
          for (int k = 0; k < patch.size[2]; ++k) {
            const Eigen::Vector3d f =
                local(patch.begin[0] + i, patch.begin[1] + j, patch.begin[2] + k);
            for (std::size_t a = 0; a < 3; ++a) {
              set_force(patch, a, static_cast<std::size_t>(patch.at(i, j, k)),
                        f[static_cast<Eigen::Index>(a)]);
            }
          }
        }
      }
    }
    fluid.step();
    reference.step(
        [&](int x, int y, int z) -> Eigen::Vector3d { return o.force + local(x, y, z); });
    const Field field = fields(fluid);
    std::size_t n = 0;
    for (int x = 0; x < o.nodes[0]; ++x) {
      for (int y = 0; y < o.nodes[1]; ++y) {
        for (int z = 0; z < o.nodes[2]; ++z, ++n) {
          const auto [rho, u] = reference.state(x, y, z, o.force);
          ASSERT_NEAR(field.density[n], rho, round_off) << step << ' ' << x << ' ' << y << ' ' << z;
          for (std::size_t a = 0; a < 3; ++a) {
            ASSERT_NEAR(field.velocity[a * field.density.size() + n],
                        u[static_cast<Eigen::Index>(a)], round_off)
                << step << ' ' << x << ' ' << y << ' ' << z;
          }
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Walls, InPlace,
    testing::Combine(
        testing::Values(
            Case{"periodic", {periodic, periodic, periodic}, Collision::bgk, false, false},
            Case{"channel", {halfway, halfway, periodic}, Collision::bgk, false, true},
            Case{"slit", {halfway, periodic, periodic}, Collision::trt, true, true},
            Case{"across", {periodic, periodic, halfway}, Collision::bgk, false, true},
            Case{"closed", {halfway, halfway, halfway}, Collision::trt, true, true},
            Case{"plates", {regularized, periodic, periodic}, Collision::bgk, true, true},
            Case{"duct", {regularized, regularized, periodic}, Collision::trt, true, true},
            Case{"tank", {regularized, regularized, halfway}, Collision::bgk, true, true},
            Case{"mixed", {halfway, regularized, periodic}, Collision::bgk, true, true}),
        testing::ValuesIn(ductile::test::precisions), testing::ValuesIn(equilibria)),
    [](const auto& test) {
      return std::string(std::get<0>(test.param).name) + "_" + std::get<1>(test.param).name +
             (std::get<2>(test.param) == Equilibrium::compressible ? "" : "_incompressible");
    });

TEST(Fluid, KeepsMassAndGainsTheForceAsMomentum) {
  for (const auto& [precision, equilibrium] : methods()) {
    Options o;
    o.equilibrium = equilibrium;
    o.nodes = {8, 7, 12};
    o.tau = 0.7;
    o.force = {1e-5, 2e-5, -3e-5};
    precision.choose(o);
    Fluid fluid(MPI_COMM_WORLD, o);
    fluid.initialise([&](int i, int j, int k) { return wavy(o, i, j, k); });
    const Totals before = fluid.totals();
    constexpr int steps = 51;
    for (int n = 0; n < steps; ++n) fluid.step();
    const Totals after = fluid.totals();
    const double nodes = 8 * 7 * 12;
    // round-off of the storage, times a random walk over the steps
    const double eps = precision.all_double() ? 1e-15 : 1e-7;
    EXPECT_NEAR(after.mass, before.mass, nodes * eps);
    EXPECT_LT((after.momentum - before.momentum - steps * nodes * o.force).norm(), nodes * eps);
  }
}

TEST(Fluid, ClosedWallsKeepMass) {
  Options o;
  o.nodes = {8, 7, 12};
  o.boundary = {halfway, halfway, halfway};
  Fluid fluid(MPI_COMM_WORLD, o);
  fluid.initialise([&](int i, int j, int k) { return wavy(o, i, j, k); });
  const double before = fluid.totals().mass;
  for (int n = 0; n < 100; ++n) fluid.step();
  EXPECT_NEAR(fluid.totals().mass, before, 1e-12);
}

struct Vessel {
  const char* name;
  std::array<Boundary, 3> boundary;
  Mirror mirror = Mirror::none;
};

class OnNodes : public testing::TestWithParam<Vessel> {};

// No mass passes a wall on nodes, whatever the flow: unsteady, in all directions, compressible,
// with forces, along moving walls, at edges and where other walls and mirror planes are met.
TEST_P(OnNodes, NoMassPassesTheWalls) {
  for (const Collision collision : {Collision::bgk, Collision::trt}) {
    Options o;
    o.nodes = {7, 6, 9};
    o.boundary = GetParam().boundary;
    o.mirror = GetParam().mirror;
    const bool mirrored = o.mirror != Mirror::none;
    o.collision = collision;
    o.tau = 0.7;
    o.force = {1e-4, mirrored ? 0 : -2e-4, 3e-4};
    if (o.boundary[0] != periodic) {
      o.wall_velocity[0] = {Eigen::Vector3d(0, mirrored ? 0 : 0.02, 0.02),
                            Eigen::Vector3d(0, 0, -0.03)};
    }
    if (o.boundary[1] != periodic) o.wall_velocity[1][1] = {-0.03, 0, 0.01};
    if (o.boundary[2] != periodic) o.wall_velocity[2][0] = {0.01, 0, 0};
    Fluid fluid(MPI_COMM_WORLD, o);
    fluid.initialise([&](int i, int j, int k) {
      NodeState s = wavy(o, i, j, k);
      if (o.mirror == Mirror::on_node && j == 0) s.velocity.y() = 0;
      return s;
    });
    const double before = fluid.totals().mass;
    for (int n = 1; n <= 200; ++n) {
      fluid.step();
      ASSERT_NEAR(fluid.totals().mass, before, 2e-13) << "step " << n;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Walls, OnNodes,
    testing::Values(
        Vessel{"plates", {regularized, periodic, periodic}},
        Vessel{"duct", {regularized, regularized, periodic}},
        Vessel{"closed", {regularized, regularized, halfway}},
        Vessel{"mixed", {halfway, regularized, halfway}},
        Vessel{"mirror_between", {regularized, regularized, periodic}, Mirror::between_nodes},
        Vessel{"mirror_on_node", {regularized, regularized, periodic}, Mirror::on_node},
        Vessel{"mirror_closed", {regularized, halfway, halfway}, Mirror::on_node}),
    [](const auto& test) { return test.param.name; });

TEST(Fluid, VelocityInPatchesHoldsHalfOfTheForce) {
  for (const Equilibrium equilibrium : equilibria) {
    Options o;
    o.equilibrium = equilibrium;
    const double weighing = equilibrium == Equilibrium::compressible ? 1.02 : 1;
    o.nodes = {8, 8, 8};
    o.force = {0, 0, 2e-3};
    Fluid fluid(MPI_COMM_WORLD, o);
    fluid.initialise([](int, int, int) {
      NodeState s;
      s.density = 1.02;
      s.velocity = {0.01, 0.02, 0.03};
      return s;
    });
    const std::array<Box, 1> boxes = {Box{{{2, 6}, {2, 6}, {6, 10}}}};  // across the periodic end
    fluid.place_boxes(boxes);
    fluid.read_velocity();
    std::size_t nodes = 0;
    for (Patch& patch : patches(fluid)) {
      for (std::size_t a = 0; a < 3; ++a) {
        for (std::size_t n = 0; n < nodes_of(patch); ++n) set_force(patch, a, n, 0.04);
      }
    }
    fluid.update_velocity();
    for (const Patch& patch : patches(fluid)) {
      for (int i = 0; i < patch.size[0]; ++i) {
        for (int j = 0; j < patch.size[1]; ++j) {
          for (int k = 0; k < patch.size[2]; ++k, ++nodes) {
            const auto n = static_cast<std::size_t>(patch.at(i, j, k));
            EXPECT_NEAR(ductile::test::density_of(patch, n), weighing, 1e-15);
            EXPECT_NEAR(velocity_of(patch, 0, n), 0.01 + 0.02 / weighing, 1e-15);
            EXPECT_NEAR(velocity_of(patch, 2, n), 0.03 + 0.02 / weighing, 1e-15);
          }
        }
      }
    }
    EXPECT_EQ(nodes, 64U);
  }
}

// What a step leaves in the patches is what a body that asks beforehand is told, and no force.
TEST(Fluid, StepLeavesTheVelocityWithTheForceOfTheStepAndUsesTheForceUp) {
  for (const auto& [precision, equilibrium] : methods()) {
    Options o;
    o.equilibrium = equilibrium;
    o.nodes = {9, 8, 21};
    o.boundary = {halfway, regularized, periodic};
    o.force = {1e-4, -2e-4, 2e-3};
    precision.choose(o);
    Fluid fluid(MPI_COMM_WORLD, o);
    fluid.initialise([&](int i, int j, int k) { return wavy(o, i, j, k); });
    const std::array<Box, 1> boxes = {Box{{{2, 6}, {2, 6}, {12, 30}}}};  // across the periodic end
    fluid.place_boxes(boxes);
    for (int step = 0; step < 4; ++step) {
      fluid.read_velocity();
      for (Patch& patch : patches(fluid)) {
        for (std::size_t a = 0; a < 3; ++a) {
          for (std::size_t n = 0; n < nodes_of(patch); ++n) {
            set_force(patch, a, n, 1e-3 * std::sin(static_cast<double>(n) + step));
          }
        }
      }
      fluid.update_velocity();
      const double round_off = precision.all_single() ? 2e-8 : 1e-16;
      const std::vector<Patch> told = patches(fluid);
      fluid.step();
      for (std::size_t p = 0; p < told.size(); ++p) {
        const Patch& patch = patches(fluid)[p];
        for (std::size_t a = 0; a < 3; ++a) {
          for (std::size_t n = 0; n < nodes_of(patch); ++n) {
            ASSERT_NEAR(velocity_of(patch, a, n), velocity_of(told[p], a, n), round_off);
            ASSERT_EQ(force_of(patch, a, n), 0);
          }
        }
      }
    }
  }
}

// The kernel that a lesser machine would run gives the same bits.
TEST(InstructionSets, GiveTheSameBits) {
  for (const auto& [walls, mirror] :
       {std::pair(halfway, Mirror::none), std::pair(regularized, Mirror::none),
        std::pair(halfway, Mirror::on_node), std::pair(regularized, Mirror::between_nodes),
        std::pair(regularized, Mirror::on_node)}) {
    for (const auto& [precision, equilibrium] : methods()) {
      Options o;
      o.equilibrium = equilibrium;
      o.nodes = {6, 5, 79};  // vectors of sixteen and of everything less
      o.mirror = mirror;
      o.boundary = {walls, walls, periodic};
      o.collision = walls == halfway ? Collision::trt : Collision::bgk;
      o.tau = 0.8;
      o.force = {1e-4, mirror == Mirror::none ? -2e-4 : 0, 3e-4};
      precision.choose(o);
      std::vector<Field> results;
      std::vector<double> flows;
      std::vector<std::vector<double>> velocities;
      for (const InstructionSet set :
           {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
        if (!available(set)) continue;
        o.instruction_set = set;
        Fluid fluid(MPI_COMM_WORLD, o);
        fluid.initialise([&](int i, int j, int k) { return wavy(o, i, j, k); });
        const int low = mirror == Mirror::none ? 1 : -3;
        const std::array<Box, 1> boxes = {Box{{{1, 4}, {low, 4}, {3, 50}}}};
        fluid.place_boxes(boxes);
        std::vector<double> told;
        const auto tell = [&] {
          for (const Patch& patch : patches(fluid)) {
            for (std::size_t n = 0; n < nodes_of(patch); ++n) {
              for (std::size_t a = 0; a < 3; ++a) told.push_back(velocity_of(patch, a, n));
            }
          }
        };
        for (int step = 0; step < 5; ++step) {
          fluid.read_velocity();
          for (Patch& patch : patches(fluid)) {
            for (std::size_t n = 0; n < nodes_of(patch); ++n) {
              set_force(patch, 1, n, 1e-3 * std::sin(static_cast<double>(n) + step));
            }
          }
          fluid.update_velocity();
          tell();
          fluid.step();
          tell();
        }
        results.push_back(fields(fluid));
        velocities.push_back(told);
        flows.push_back(fluid.flow());
      }
      for (const double flow : flows) EXPECT_EQ(flow, flows.front());
      for (const auto& velocity : velocities) EXPECT_EQ(velocity, velocities.front());
      for (const Field& result : results) {
        EXPECT_EQ(result.density, results.front().density);
        EXPECT_EQ(result.velocity, results.front().velocity);
      }
    }
  }
}

TEST(InstructionSets, TheWidestOneIsChosenAndAForeignOneRefused) {
  Options o;
  o.nodes = {4, 4, 4};
  const Fluid fluid(MPI_COMM_WORLD, o);
  EXPECT_EQ(fluid.options().instruction_set, best_instruction_set());
  for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
    o.instruction_set = set;
    if (available(set)) {
      EXPECT_NO_THROW(Fluid(MPI_COMM_WORLD, o));
      EXPECT_GE(best_instruction_set(), set);
    } else {
      EXPECT_THROW(Fluid(MPI_COMM_WORLD, o), std::invalid_argument);
    }
  }
}

TEST(Fluid, SaysWhatIsWrongWithItsOptions) {
  const auto message = [](auto&& change) -> std::string {
    Options o;
    o.nodes = {8, 8, 8};
    change(o);
    try {
      const Fluid fluid(MPI_COMM_WORLD, o);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message([](Options& o) { o.tau = 0.5; }).find("tau = 0.5"), std::string::npos);
  EXPECT_NE(message([](Options& o) { o.tau = NAN; }).find("tau"), std::string::npos);
  EXPECT_NE(message([](Options& o) { o.nodes[1] = 1; }).find("along y"), std::string::npos);
  EXPECT_NE(message([](Options& o) { o.boundary[2] = regularized; }).find("half-way"),
            std::string::npos);
  EXPECT_NE(message([](Options& o) {
              o.collision = Collision::trt;
              o.magic = 0;
            }).find("magic"),
            std::string::npos);
  EXPECT_NE(message([](Options& o) {
              o.collision = Collision::trt;
              o.magic = INFINITY;
            }).find("magic"),
            std::string::npos);
  EXPECT_NE(message([](Options& o) { o.force = {0, 0, NAN}; }).find("force"), std::string::npos);
  EXPECT_NE(message([](Options& o) {
              o.wall_velocity[0][1] = {0.1, 0, 0};
            }).find("across x"),
            std::string::npos);
  EXPECT_NE(message([](Options& o) { o.arithmetic = Precision::single_precision; }).find("stored"),
            std::string::npos);
  EXPECT_NE(message([](Options& o) { o.lattice_velocity = NAN; }).find("moves along z"),
            std::string::npos);
  EXPECT_NE(message([](Options& o) {
              o.lattice_velocity = 0.1;
              o.boundary[2] = halfway;
            }).find("moves along z"),
            std::string::npos);
  EXPECT_EQ(message([](Options&) {}), "");

  Options closed;
  closed.nodes = {4, 4, 4};
  closed.boundary[2] = halfway;
  EXPECT_THROW(Fluid(MPI_COMM_SELF, closed).accelerate(1e-5), std::invalid_argument);
  closed.boundary[2] = periodic;
  EXPECT_THROW(Fluid(MPI_COMM_SELF, closed).accelerate(INFINITY), std::invalid_argument);
}

TEST(Fluid, RejectsABoxOutside) {
  Options o;
  o.nodes = {8, 8, 8};
  o.boundary = {regularized, halfway, periodic};
  Fluid fluid(MPI_COMM_WORLD, o);
  const auto place = [&](Box box) {
    const std::array<Box, 1> boxes = {box};
    fluid.place_boxes(boxes);
  };
  EXPECT_THROW(place({{{0, 4}, {2, 6}, {2, 6}}}), std::invalid_argument);
  EXPECT_THROW(place({{{1, 4}, {2, 9}, {2, 6}}}), std::invalid_argument);
  EXPECT_THROW(place({{{1, 4}, {2, 6}, {2, 11}}}), std::invalid_argument);
  EXPECT_NO_THROW(place({{{1, 7}, {0, 8}, {-2, 6}}}));
}

}  // namespace
