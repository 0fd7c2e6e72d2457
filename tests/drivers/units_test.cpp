#include "units.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "errors.hpp"
#include "input_support.hpp"

namespace ductile::drivers {
namespace {

Scenario scenario(const std::vector<Override>& overrides = {}) {
  return parse_scenario(pair_text, "case.toml", overrides);
}

// Exact series, eq. (1); the reference has eight digits.
TEST(Units, PoiseuilleCoefficientsAreThoseOfTheSeries) {
  EXPECT_NEAR(poiseuille_coefficient(1, true), 0.29468541, 5e-9);
  EXPECT_NEAR(poiseuille_coefficient(2, true), 0.45548733, 5e-9);
  // The duct turned by a quarter: the length of reference is the other half-width.
  EXPECT_NEAR(poiseuille_coefficient(0.5, true), 0.45548733 / 4, 5e-9);
  EXPECT_EQ(poiseuille_coefficient(1, false), 0.5);
}

// With rho = nu = W = 1, Re = 10 is U_max = 5 and alpha = 16.96725; k_s = La/a.
TEST(Units, ThePapersParametersComeOutAtAnyResolution) {
  for (const char* nodes : {"24", "36", "75", "90"}) {
    for (const char* tau : {"0.6", "1.0"}) {
      for (const char* walls : {"halfway", "regularized"}) {
        const LatticeSetup s = lattice_setup(scenario(
            {set("channel.nodes", nodes), set("fluid.tau", tau), set("channel.walls", walls)}));
        const double W = s.half_width;
        EXPECT_NEAR(s.u_max * W / s.nu, 5, 1e-12);
        EXPECT_NEAR(s.alpha * W * W * W / (s.nu * s.nu), 16.96725, 5e-6);
        EXPECT_NEAR(s.alpha * 0.29468541 * W * W / s.nu / s.u_max, 1, 5e-8);
        const double unit = s.nu * s.nu / W;  // of k_s, rho nu^2/W
        const double a = 0.4 * W;
        ASSERT_EQ(s.bodies.size(), 2U);
        EXPECT_NEAR(s.bodies[0].radius, a, 1e-12);
        EXPECT_NEAR(s.bodies[0].moduli.k_s / unit, 25, 1e-11);
        EXPECT_NEAR(s.bodies[1].moduli.k_s / unit, 250, 1e-10);
        for (const BodySetup& body : s.bodies) {
          EXPECT_NEAR(body.moduli.k_a / body.moduli.k_s, 2, 1e-14);
          EXPECT_NEAR(body.moduli.k_b / (body.moduli.k_s * a * a), 2.87e-3, 1e-16);
        }
      }
    }
  }
}

// physics of the paper's own run: k_v = 75000 is 1.03 in lattice units at 2W = 90, tau = 1, and 9.3
// at 2W = 30.
TEST(Units, VolumeModulusIsThePapersWhereTheLatticeBearsIt) {
  const LatticeSetup fine = lattice_setup(scenario({set("channel.nodes", "90")}));
  EXPECT_EQ(scenario({set("channel.nodes", "90")}).membrane.volume_modulus, 75000);
  EXPECT_NEAR(fine.bodies[0].moduli.k_v, 1.0288, 1e-4);
  const LatticeSetup coarse = lattice_setup(
      scenario({set("channel.nodes", "30"), set("membrane.volume_modulus", "75000")}));
  EXPECT_NEAR(coarse.bodies[0].moduli.k_v, 9.2593, 1e-4);
}

TEST(Units, DefaultVolumeModulusIsAtMostOneAndAHalfLatticeUnits) {
  for (const char* nodes : {"20", "24", "36", "48", "60", "90"}) {
    for (const char* tau : {"0.55", "0.8", "1.0"}) {
      const Scenario s = scenario({set("channel.nodes", nodes), set("fluid.tau", tau)});
      const LatticeSetup lattice = lattice_setup(s);
      EXPECT_LE(s.membrane.volume_modulus, 75000);
      EXPECT_LE(lattice.bodies[0].moduli.k_v, 1.5 * (1 + 1e-12));
      if (s.membrane.volume_modulus < 75000) {
        EXPECT_GE(lattice.bodies[0].moduli.k_v, 1.48);
      }
    }
  }
}

TEST(Units, HalfWidthIsWhatTheWallsMakeOfTheNodes) {
  EXPECT_EQ(half_width(36, fluid::Boundary::halfway), 18);
  EXPECT_EQ(half_width(37, fluid::Boundary::regularized), 18);
  const LatticeSetup halfway = lattice_setup(scenario());
  EXPECT_EQ(halfway.nodes, (std::array<int, 3>{36, 36, 216}));
  const LatticeSetup on_nodes =
      lattice_setup(scenario({set("channel.nodes", "37"), set("channel.walls", "regularized"),
                              set("channel.half_width_y", "2")}));
  EXPECT_EQ(on_nodes.nodes, (std::array<int, 3>{37, 73, 216}));
  EXPECT_EQ(on_nodes.half_width_y, 36);
  const LatticeSetup plates =
      lattice_setup(scenario({set("channel.nodes", "37"), set("channel.walls", "regularized"),
                              set("channel.side_walls", "false")}));
  EXPECT_EQ(plates.nodes, (std::array<int, 3>{37, 36, 216}));
}

// Walls at -1/2 and N - 1/2, or at 0 and N - 1; z = 0 in the middle of the period.
TEST(Units, WallsLieWhereTheBoundaryConditionPutsThem) {
  const LatticeSetup halfway = lattice_setup(scenario());
  EXPECT_EQ(halfway.to_lattice({-1, 1, 0}), Eigen::Vector3d(-0.5, 35.5, 108));
  const LatticeSetup on_nodes =
      lattice_setup(scenario({set("channel.nodes", "37"), set("channel.walls", "regularized")}));
  EXPECT_EQ(on_nodes.to_lattice({-1, 1, 6}), Eigen::Vector3d(0, 36, 216));
  const Eigen::Vector3d point(0.3, -0.2, 7.5);
  EXPECT_LT((halfway.position(halfway.to_lattice(point)) - point).norm(), 1e-14);
  EXPECT_LT((halfway.bodies[1].centre - Eigen::Vector3d(13.9, 17.5, 99)).norm(), 1e-12);
}

// Half of a channel has the plane y = 0 half-way below its first nodes, or on them, and the wall
// where the whole channel has it.
TEST(Units, HalfOfASymmetricChannelIsItsUpperHalf) {
  const Override half = set("channel.symmetry", "y");
  for (const char* walls : {"halfway", "regularized"}) {
    for (const char* nodes : {"36", "37"}) {
      const std::vector<Override> channel = {set("channel.nodes", nodes),
                                             set("channel.walls", walls)};
      const LatticeSetup whole = lattice_setup(scenario(channel));
      const LatticeSetup s = lattice_setup(scenario({channel[0], channel[1], half}));
      const bool even = whole.nodes[1] % 2 == 0;
      EXPECT_EQ(s.mirror, even ? fluid::Mirror::between_nodes : fluid::Mirror::on_node);
      EXPECT_EQ(s.nodes, (std::array<int, 3>{whole.nodes[0], even ? 18 : 19, whole.nodes[2]}));
      EXPECT_EQ(s.half_width, whole.half_width);
      EXPECT_EQ(s.half_width_y, whole.half_width_y);
      EXPECT_EQ(s.alpha, whole.alpha);
      EXPECT_EQ(s.total_steps, whole.total_steps);
      const Eigen::Vector3d down(0, whole.nodes[1] - s.nodes[1], 0);
      for (const Eigen::Vector3d& point :
           {Eigen::Vector3d(-1, 1, 0), Eigen::Vector3d(0.3, -0.2, 7.5)}) {
        EXPECT_LT((s.to_lattice(point) + down - whole.to_lattice(point)).norm(), 1e-12);
        EXPECT_LT((s.position(s.to_lattice(point)) - point).norm(), 1e-14);
      }
    }
  }
}

TEST(Units, LengthsAreRoundedToWholeNodesAndReynoldsStaysTrue) {
  const LatticeSetup s =
      lattice_setup(scenario({set("channel.length", "7.3"), set("channel.half_width_y", "1.51")}));
  EXPECT_EQ(s.nodes, (std::array<int, 3>{36, 54, 131}));
  // The force fits the channel as it is, 1 : 1.5.
  EXPECT_DOUBLE_EQ(s.alpha * poiseuille_coefficient(1.5, true) * 18 * 18 / s.nu, s.u_max);
}

TEST(Units, TimesAreInStepsOfTheViscousTime) {
  const LatticeSetup s = lattice_setup(scenario());
  EXPECT_DOUBLE_EQ(s.steps_per_time, 18.0 * 18 * 6);
  EXPECT_EQ(s.total_steps, 60 * 1944);
  EXPECT_EQ(s.steps(0.05), 97);
  EXPECT_EQ(s.steps(1e-9), 1);
  EXPECT_EQ(s.steps(0), 0);
  EXPECT_DOUBLE_EQ(s.time(972), 0.5);
}

TEST(Units, PlanesAndGravityAreInUnitsOfViscosity) {
  const LatticeSetup s = lattice_setup(
      scenario({set("channel.side_walls", "false"), set("channel.wall_velocity", "[-2, 3]"),
                set("channel.gravity", "[0, 0, -7]"), set("channel.reynolds", "0")}));
  EXPECT_DOUBLE_EQ(s.wall_velocity[0] * s.half_width / s.nu, -2);
  EXPECT_DOUBLE_EQ(s.wall_velocity[1] * s.half_width / s.nu, 3);
  EXPECT_DOUBLE_EQ(s.velocity({0, 0, s.wall_velocity[1]}).z(), 3);
  EXPECT_DOUBLE_EQ(s.gravity.z() * std::pow(s.half_width, 3) / (s.nu * s.nu), -7);
  EXPECT_EQ(s.alpha, 0);
  EXPECT_DOUBLE_EQ(s.mach(), std::sqrt(3.0) * s.wall_velocity[1]);
}

TEST(Units, TheCellsAxisTurnsAsTheRotationSays) {
  const LatticeSetup s = lattice_setup(
      scenario({set("body.lag.rotation_axis", "[0, 2, 0]"), set("body.lag.rotation_angle", "90")}));
  const Eigen::Vector3d turned = s.bodies[1].rotation * Eigen::Vector3d::UnitZ();
  EXPECT_LT((turned - Eigen::Vector3d::UnitX()).norm(), 1e-15);
  EXPECT_EQ(s.bodies[0].rotation, Eigen::Matrix3d::Identity());
}

// 1.2085 a/n is the mean edge of the icosphere of frequency n.
TEST(Units, MeshesAreAsFineAsTheEdgeDemandsOrAsTheFrequencySays) {
  const LatticeSetup s =
      lattice_setup(scenario({set("channel.nodes", "90"), set("body.lag.frequency", "32")}));
  EXPECT_NEAR(1.2085 * s.bodies[0].radius / s.bodies[0].frequency, 1.2, 0.04);
  EXPECT_EQ(s.bodies[1].frequency, 32);
}

}  // namespace
}  // namespace ductile::drivers
