#include "scenario/plan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "ductile/suspension/felt_surface.hpp"
#include "input_support.hpp"

namespace ductile::drivers {
namespace {

using suspension::half_width;
using suspension::Plan;
using suspension::poiseuille_coefficient;

Case given(const std::vector<Override>& overrides = {}) {
  return parse_case(pair_text, "case.toml", overrides);
}

Plan plan(const std::vector<Override>& overrides = {}) {
  return given(overrides).plan;
}

const membrane::Moduli& moduli(const Plan& plan, std::size_t body) {
  return plan.bodies.at(body).capsule()->moduli;
}

// Exact series, eq. (1); the reference has eight digits.
TEST(Plan, PoiseuilleCoefficientsAreThoseOfTheSeries) {
  EXPECT_NEAR(poiseuille_coefficient(1, true), 0.29468541, 5e-9);
  EXPECT_NEAR(poiseuille_coefficient(2, true), 0.45548733, 5e-9);
  // The duct turned by a quarter: the length of reference is the other half-width.
  EXPECT_NEAR(poiseuille_coefficient(0.5, true), 0.45548733 / 4, 5e-9);
  EXPECT_EQ(poiseuille_coefficient(1, false), 0.5);
}

// With rho = nu = W = 1, Re = 10 is U_max = 5 and alpha = 16.96725; k_s = La/a.
TEST(Plan, ThePapersParametersComeOutAtAnyResolution) {
  for (const char* nodes : {"24", "36", "75", "90"}) {
    for (const char* tau : {"0.6", "1.0"}) {
      for (const char* walls : {"halfway", "regularized"}) {
        const Plan s = plan({set("channel.nodes", nodes), set("fluid.tau", tau),
                             set("channel.walls", walls), set("membrane.retraction", "0.0")});
        const double W = s.units.half_width();
        const double nu = s.units.viscosity();
        const double alpha = s.fluid.force.z();
        EXPECT_NEAR(s.u_max * W / nu, 5, 1e-12);
        EXPECT_NEAR(alpha * W * W * W / (nu * nu), 16.96725, 5e-6);
        EXPECT_NEAR(alpha * 0.29468541 * W * W / nu / s.u_max, 1, 5e-8);
        const double unit = nu * nu / W;  // of k_s, rho nu^2/W
        const double a = 0.4 * W;
        ASSERT_EQ(s.bodies.size(), 2U);
        EXPECT_NEAR(s.bodies[0].shape->radius(), a, 1e-12);
        EXPECT_NEAR(moduli(s, 0).k_s / unit, 25, 1e-11);
        EXPECT_NEAR(moduli(s, 1).k_s / unit, 250, 1e-10);
        for (std::size_t b = 0; b < 2; ++b) {
          const membrane::Moduli& k = moduli(s, b);
          EXPECT_NEAR(k.k_a / k.k_s, 2, 1e-14);
          EXPECT_NEAR(k.k_b / (k.k_s * a * a), 2.87e-3, 1e-16);
          EXPECT_DOUBLE_EQ(s.bodies[b].energy_unit(), k.k_s * a * a);
        }
      }
    }
  }
}

// physics of the paper's own run: k_v = 75000 is 1.03 in lattice units at 2W = 90, tau = 1, and 9.3
// at 2W = 30.
TEST(Plan, VolumeModulusIsThePapersWhereTheLatticeBearsIt) {
  const Plan fine = plan({set("channel.nodes", "90")});
  EXPECT_EQ(given({set("channel.nodes", "90")}).scenario.membrane.volume_modulus, 75000);
  EXPECT_NEAR(moduli(fine, 0).k_v, 1.0288, 1e-4);
  const Plan coarse = plan({set("channel.nodes", "30"), set("membrane.volume_modulus", "75000")});
  EXPECT_NEAR(moduli(coarse, 0).k_v, 9.2593, 1e-4);
}

TEST(Plan, DefaultVolumeModulusIsAtMostOneAndAHalfLatticeUnits) {
  for (const char* nodes : {"20", "24", "36", "48", "60", "90"}) {
    for (const char* tau : {"0.55", "0.8", "1.0"}) {
      const Scenario s = given({set("channel.nodes", nodes), set("fluid.tau", tau)}).scenario;
      const Plan lattice = planned(s).plan;
      EXPECT_LE(s.membrane.volume_modulus, 75000);
      EXPECT_LE(moduli(lattice, 0).k_v, 1.5 * (1 + 1e-12));
      if (s.membrane.volume_modulus < 75000) {
        EXPECT_GE(moduli(lattice, 0).k_v, 1.48);
      }
    }
  }
}

TEST(Plan, HalfWidthIsWhatTheWallsMakeOfTheNodes) {
  EXPECT_EQ(half_width(36, fluid::Boundary::halfway), 18);
  EXPECT_EQ(half_width(37, fluid::Boundary::regularized), 18);
  const Plan halfway = plan();
  EXPECT_EQ(halfway.fluid.nodes, (std::array<int, 3>{36, 36, 216}));
  const Plan on_nodes = plan({set("channel.nodes", "37"), set("channel.walls", "regularized"),
                              set("channel.half_width_y", "2")});
  EXPECT_EQ(on_nodes.fluid.nodes, (std::array<int, 3>{37, 73, 216}));
  EXPECT_EQ(on_nodes.half_width_y(), 36);
  const Plan plates = plan({set("channel.nodes", "37"), set("channel.walls", "regularized"),
                            set("channel.side_walls", "false")});
  EXPECT_EQ(plates.fluid.nodes, (std::array<int, 3>{37, 36, 216}));
}

// Walls at -1/2 and N - 1/2, or at 0 and N - 1; z = 0 in the middle of the period.
TEST(Plan, WallsLieWhereTheBoundaryConditionPutsThem) {
  const Plan halfway = plan();
  EXPECT_EQ(halfway.units.lattice_position({-1, 1, 0}), Eigen::Vector3d(-0.5, 35.5, 108));
  const Plan on_nodes = plan({set("channel.nodes", "37"), set("channel.walls", "regularized")});
  EXPECT_EQ(on_nodes.units.lattice_position({-1, 1, 6}), Eigen::Vector3d(0, 36, 216));
  const Eigen::Vector3d point(0.3, -0.2, 7.5);
  EXPECT_LT((halfway.units.position(halfway.units.lattice_position(point)) - point).norm(), 1e-14);
  EXPECT_LT((halfway.bodies[1].centre - Eigen::Vector3d(13.9, 17.5, 99)).norm(), 1e-12);
}

// Half of a channel has the plane y = 0 half-way below its first nodes, or on them, and the wall
// where the whole channel has it.
TEST(Plan, HalfOfASymmetricChannelIsItsUpperHalf) {
  const Override half = set("channel.symmetry", "y");
  for (const char* walls : {"halfway", "regularized"}) {
    for (const char* nodes : {"36", "37"}) {
      const std::vector<Override> channel = {set("channel.nodes", nodes),
                                             set("channel.walls", walls)};
      const Plan whole = plan(channel);
      const Plan s = plan({channel[0], channel[1], half});
      const bool even = whole.fluid.nodes[1] % 2 == 0;
      EXPECT_EQ(s.fluid.mirror, even ? fluid::Mirror::between_nodes : fluid::Mirror::on_node);
      EXPECT_EQ(s.fluid.nodes,
                (std::array<int, 3>{whole.fluid.nodes[0], even ? 18 : 19, whole.fluid.nodes[2]}));
      EXPECT_EQ(s.units.half_width(), whole.units.half_width());
      EXPECT_EQ(s.half_width_y(), whole.half_width_y());
      EXPECT_EQ(s.fluid.force.z(), whole.fluid.force.z());

      const Eigen::Vector3d down(0, whole.fluid.nodes[1] - s.fluid.nodes[1], 0);
      for (const Eigen::Vector3d& point :
           {Eigen::Vector3d(-1, 1, 0), Eigen::Vector3d(0.3, -0.2, 7.5)}) {
        EXPECT_LT(
            (s.units.lattice_position(point) + down - whole.units.lattice_position(point)).norm(),
            1e-12);
        EXPECT_LT((s.units.position(s.units.lattice_position(point)) - point).norm(), 1e-14);
      }
    }
  }
}

TEST(Plan, LengthsAreRoundedToWholeNodesAndReynoldsStaysTrue) {
  const Plan s = plan({set("channel.length", "7.3"), set("channel.half_width_y", "1.51")});
  EXPECT_EQ(s.fluid.nodes, (std::array<int, 3>{36, 54, 131}));
  // The force fits the channel as it is, 1 : 1.5.
  EXPECT_DOUBLE_EQ(
      s.fluid.force.z() * poiseuille_coefficient(1.5, true) * 18 * 18 / s.units.viscosity(),
      s.u_max);
}

TEST(Plan, TimesAreInStepsOfTheViscousTime) {
  const Plan s = plan();
  EXPECT_DOUBLE_EQ(s.units.steps_per_time(), 18.0 * 18 * 6);
  EXPECT_EQ(given().schedule.end, 60 * 1944);
  EXPECT_EQ(given().schedule.rows, 97.2);
  // Rows at the steps nearest to 97.2, 194.4, 291.6, 388.8, 486.
  std::vector<std::int64_t> rows;
  for (std::int64_t step = 0; step < 500; ++step) {
    if (Schedule::due(step, 97.2)) rows.push_back(step);
  }
  EXPECT_EQ(rows, (std::vector<std::int64_t>{0, 97, 194, 292, 389, 486}));
  EXPECT_TRUE(Schedule::due(7, 0.3));
  EXPECT_FALSE(Schedule::due(0, 0));
  EXPECT_EQ(given().schedule.surfaces, 972);
  EXPECT_EQ(given().schedule.fields, 0);
  EXPECT_EQ(s.units.lattice_steps(0.05), 97);
  EXPECT_EQ(s.units.lattice_steps(1e-9), 1);
  EXPECT_EQ(s.units.lattice_steps(0), 0);
  EXPECT_DOUBLE_EQ(s.units.time(972), 0.5);
}

// Slip and films are of spheres whose place nobody has said, as dense as the fluid or denser.
TEST(Plan, RigidSpheresSlipUnlessTheyAreGivenTheirPlace) {
  const auto of = [](const std::vector<Override>& overrides) {
    constexpr const char* text =
        "[[body]]\nname = \"particle\"\nkind = \"rigid\"\nradius = 0.4\nx = 0.2\n";
    return *parse_case(text, "case.toml", overrides).plan.bodies.at(0).rigid();
  };
  const suspension::RigidPlan usual = of({});
  EXPECT_GT(usual.slip, 0.01);
  EXPECT_EQ(usual.roughness, rigid::usual_roughness);
  EXPECT_EQ(of({set("rigid.roughness", "0.01")}).roughness, 0.01);
  EXPECT_EQ(of({set("rigid.slip", "\"felt\"")}).slip, usual.slip);
  EXPECT_EQ(of({set("rigid.slip", "0.0")}).slip, 0);
  EXPECT_GT(of({set("rigid.slip", "0.0")}).retraction, usual.retraction);
  EXPECT_EQ(of({set("rigid.retraction", "0.0")}).slip, 0);
  EXPECT_EQ(of({set("rigid.interior", "\"solid\"")}).slip, 0);
  EXPECT_EQ(of({set("body.particle.density_ratio", "0.9")}).slip, 0);
  EXPECT_EQ(of({set("body.particle.density_ratio", "2.0")}).slip, usual.slip);
}

TEST(Plan, EveryKeyOfABodyReachesIt) {
  constexpr const char* text = R"(
channel.start = "rest"
[membrane]
law = "neo-hookean"
area_ratio = 3
mobility = 0.002
retraction = 0.25
integrator = "implicit"
theta = 0.75
substeps = 3
step_cuts = 2
frequency = 7
[rigid]
iterations = 4
memory = 0.5
retraction = 0.35
slip = 0.05
roughness = 0.002
interior = "fluid"
edge = 2.0
[[body]]
name = "soft"
laplace = 100
[[body]]
name = "hard"
kind = "rigid"
density_ratio = 1.5
z = 2
)";
  const Plan s = parse_case(text, "case.toml", {}).plan;
  EXPECT_EQ(s.start, suspension::Start::rest);
  const suspension::CapsulePlan& soft = *s.bodies.at(0).capsule();
  EXPECT_EQ(soft.moduli.law, membrane::StrainLaw::neo_hookean);
  EXPECT_NEAR(soft.moduli.k_a, 3 * soft.moduli.k_s, 1e-12 * soft.moduli.k_s);
  EXPECT_EQ(soft.mobility, 0.002);
  EXPECT_EQ(soft.retraction, 0.25);
  EXPECT_EQ(soft.integrator.name, "implicit");
  EXPECT_EQ(soft.integrator_options.theta, 0.75);
  EXPECT_EQ(soft.integrator_options.substeps, 3);
  EXPECT_EQ(soft.integrator_options.step_cuts, 2);
  EXPECT_EQ(s.bodies[0].frequency, 7);
  const suspension::RigidPlan& hard = *s.bodies.at(1).rigid();
  EXPECT_EQ(hard.density_ratio, 1.5);
  EXPECT_EQ(hard.corrections, 4);
  EXPECT_EQ(hard.memory, 0.5);
  EXPECT_EQ(hard.retraction, 0.35);
  EXPECT_EQ(hard.slip, 0.05);
  EXPECT_EQ(hard.roughness, 0.002);
  EXPECT_EQ(hard.interior, suspension::Interior::fluid);
  // Its own edge, not the membranes' frequency.
  EXPECT_NEAR(surface::icosphere_edge(s.bodies[1].shape->radius(), s.bodies[1].frequency), 2, 0.3);
}

// Unless they are given their place, surfaces are felt where they are, with moduli to match.
TEST(Plan, CapsulesLieInsideOfTheirSurface) {
  const Plan s = plan({});
  for (std::size_t b = 0; b < 2; ++b) {
    const suspension::BodyPlan& body = s.bodies[b];
    const suspension::CapsulePlan& capsule = *body.capsule();
    EXPECT_EQ(capsule.retraction, suspension::felt_retraction(*body.shape, s.fluid));
    const double nominal =
        plan({set("membrane.retraction", "0.0")}).bodies[b].capsule()->moduli.k_s;
    const double factor =
        suspension::felt_modulus_factor(*body.shape, capsule.retraction, capsule.moduli, s.fluid);
    EXPECT_NEAR(capsule.moduli.k_s, factor * nominal, 1e-12 * nominal);
    EXPECT_NEAR(capsule.moduli.k_a, 2 * capsule.moduli.k_s, 1e-12 * nominal);
    const double r = body.shape->radius() - capsule.retraction;
    EXPECT_NEAR(capsule.moduli.k_b, 2.87e-3 * capsule.moduli.k_s * r * r, 1e-12 * nominal);
  }
}

TEST(Plan, PlanesAndGravityAreInUnitsOfViscosity) {
  const Plan s = plan({set("channel.side_walls", "false"), set("channel.wall_velocity", "[-2, 3]"),
                       set("channel.gravity", "[0, 0, -7]"), set("channel.reynolds", "0"),
                       set("fluid.frame", "\"walls\"")});
  EXPECT_DOUBLE_EQ(s.wall_velocity()[0] * s.units.half_width() / s.units.viscosity(), -2);
  EXPECT_DOUBLE_EQ(s.wall_velocity()[1] * s.units.half_width() / s.units.viscosity(), 3);
  EXPECT_DOUBLE_EQ(s.units.velocity(Eigen::Vector3d(0, 0, s.wall_velocity()[1])).z(), 3);
  EXPECT_DOUBLE_EQ(s.gravity.z() * std::pow(s.units.half_width(), 3) /
                       (s.units.viscosity() * s.units.viscosity()),
                   -7);
  EXPECT_EQ(s.fluid.force.z(), 0);
  EXPECT_DOUBLE_EQ(s.mach(), std::sqrt(3.0) * s.wall_velocity()[1]);
}

TEST(Plan, TheCellsAxisTurnsAsTheRotationSays) {
  const Plan s =
      plan({set("body.lag.rotation_axis", "[0, 2, 0]"), set("body.lag.rotation_angle", "90")});
  const Eigen::Vector3d turned = s.bodies[1].rotation * Eigen::Vector3d::UnitZ();
  EXPECT_LT((turned - Eigen::Vector3d::UnitX()).norm(), 1e-15);
  EXPECT_EQ(s.bodies[0].rotation, Eigen::Matrix3d::Identity());
  // Of any length, also where its square is no number.
  for (const char* axis : {"[0, 1e200, 0]", "[0, 1e-200, 0]"}) {
    const Plan extreme =
        plan({set("body.lag.rotation_axis", axis), set("body.lag.rotation_angle", "90")});
    EXPECT_LT((extreme.bodies[1].rotation - s.bodies[1].rotation).norm(), 1e-15) << axis;
  }
}

TEST(Plan, MeshesAreAsFineAsTheEdgeDemandsOrAsTheFrequencySays) {
  const Plan s = plan({set("channel.nodes", "90"), set("body.lag.frequency", "32")});
  EXPECT_NEAR(surface::icosphere_edge(s.bodies[0].shape->radius(), s.bodies[0].frequency), 1.2,
              0.04);
  EXPECT_EQ(s.bodies[1].frequency, 32);
}

}  // namespace
}  // namespace ductile::drivers
