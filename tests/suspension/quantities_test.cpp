// What a row says of bodies and of the flow, against what is known.
#include <gtest/gtest.h>
#include <petscsys.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "ductile/fluid/duct.hpp"
#include "ductile/suspension/suspension.hpp"
#include "suspension/plans.hpp"

namespace ductile::suspension {
namespace {

using fluid::Boundary;
using fluid::Mirror;
using test::body;
using test::capsule;
using test::channel;

constexpr double degree = std::numbers::pi / 180;

Eigen::Vector3d omega(const BodySample& body) {
  return {body["omega_x"], body["omega_y"], body["omega_z"]};
}
Eigen::Vector3d force(const BodySample& body) {
  return {body["force_x"], body["force_y"], body["force_z"]};
}
Eigen::Vector3d torque(const BodySample& body) {
  return {body["torque_x"], body["torque_y"], body["torque_z"]};
}
Eigen::Quaterniond orientation(const BodySample& body) {
  return {body["qw"], body["qx"], body["qy"], body["qz"]};
}

TEST(DistancesAhead, AreToTheNextBodyInAChannelThatRepeats) {
  using List = std::vector<double>;
  EXPECT_EQ(distances_ahead(List{0, 1, -1.5}, 6), (List{1, 3.5, 1.5}));
  // However many channels further on, or back.
  EXPECT_EQ(distances_ahead(List{12, -17, 40.5}, 6), (List{1, 3.5, 1.5}));
  // The later one in the list is ahead of one at the same place.
  EXPECT_EQ(distances_ahead(List{2, 1, 8, 1}, 6), (List{0, 0, 5, 1}));
  EXPECT_EQ(distances_ahead(List{1, 1, 1}, 6), (List{0, 0, 6}));
}

TEST(DistancesAhead, GoAroundTheChannelOnce) {
  Plan plan = channel({16, 16, 80});
  const double length = plan.units.length(plan.length());
  std::vector<double> z;
  for (int b = 0; b < 7; ++b) {
    z.push_back(0.5 * length * std::sin(5.0 * b) + length * (b % 3 - 1));
    plan.bodies.push_back(body(plan, std::string(1, static_cast<char>('a' + b)), "sphere",
                               {0.4 * std::cos(3.0 * b), 0.4 * std::sin(3.0 * b), z.back()}, 0.2));
    plan.bodies.back().kind = RigidPlan{};
  }
  Suspension suspension(plan, PETSC_COMM_SELF);
  const std::vector<double> ahead = suspension.sample().ahead;
  ASSERT_EQ(ahead.size(), z.size());
  EXPECT_NEAR(std::accumulate(ahead.begin(), ahead.end(), 0.0), length, 1e-12);
  for (std::size_t b = 0; b < z.size(); ++b) {
    double least = length;
    for (std::size_t c = 0; c < z.size(); ++c) {
      const double on = std::fmod(z[c] - z[b] + 10 * length, length);
      if (c != b) least = std::min(least, on);
    }
    EXPECT_NEAR(ahead[b], least, 1e-12) << b;
  }
  plan.bodies.resize(2);
  EXPECT_TRUE(Suspension(plan, PETSC_COMM_SELF).sample().ahead.empty());
}

// The mean of r x u over a sphere is that of a rigid turn with curl u/2 of its centre wherever
// curl u is harmonic, as in a developed flow: what a body starts with, at any size.
TEST(Rotation, StartsAsHalfTheVorticityAtTheCentreOfASphere) {
  Plan plan = channel({28, 36, 48});
  plan.bodies = {body(plan, "soft", "sphere", {0.4, 0.1, -0.8}),
                 body(plan, "hard", "sphere", {-0.5, 0.4, 0.8}, 0.4)};
  plan.bodies[0].kind = capsule(plan, membrane::find_scheme("explicit-euler"), 10);
  plan.bodies[1].kind = RigidPlan{};
  Suspension suspension(plan, PETSC_COMM_SELF);
  const Sample start = suspension.sample();
  const InitialFlow flow(plan);
  for (std::size_t b = 0; b < 2; ++b) {
    const Eigen::Vector3d at = plan.bodies[b].centre;
    const Eigen::Matrix3d gradient = flow.at(at.x(), at.y()).gradient;
    const Eigen::Vector3d expected =
        plan.units.angular_velocity({gradient(1, 2) / 2, -gradient(0, 2) / 2, 0});
    EXPECT_LT((omega(start.bodies[b]) - expected).norm(), 1e-5 * expected.norm())
        << omega(start.bodies[b]).transpose() << "; " << expected.transpose();
  }
  EXPECT_EQ(orientation(start.bodies[1]).coeffs(), Eigen::Vector4d(0, 0, 0, 1));
  EXPECT_EQ(force(start.bodies[1]), Eigen::Vector3d::Zero());
  EXPECT_EQ(torque(start.bodies[1]), Eigen::Vector3d::Zero());
}

// Whose axis z the disc's is. Turned about y by alpha it lies with its longest axis at alpha - 90;
// out of the plane by beta its tilt is beta, and nothing else.
TEST(Direction, IsThatOfADisc) {
  Plan plan = channel({32, 32, 40});
  plan.start = Start::rest;
  for (const double alpha : {-120.0, -90.0, -30.0, 0.0, 20.0, 90.0, 150.0}) {
    for (const double beta : {-70.0, 0.0, 25.0}) {
      plan.bodies = {body(plan, "cell", "biconcave", {0, 0.05, 0}, 0.5)};
      plan.bodies[0].rotation = (Eigen::AngleAxisd(alpha * degree, Eigen::Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(beta * degree, Eigen::Vector3d::UnitX()))
                                    .toRotationMatrix();
      plan.bodies[0].kind = capsule(plan, membrane::find_scheme("explicit-euler"), 10);
      const BodySample cell = Suspension(plan, PETSC_COMM_SELF).sample().bodies.at(0);
      double expected = alpha - 90;
      while (expected <= -90) expected += 180;
      while (expected > 90) expected -= 180;
      // By an angle of 180 degrees at -90 and 90.
      const double off = std::remainder(cell["inclination"] - expected, 180);
      EXPECT_NEAR(off, 0, 1e-9) << alpha << ' ' << beta;
      EXPECT_GT(cell["inclination"], -90);
      EXPECT_LE(cell["inclination"], 90);
      EXPECT_NEAR(cell["tilt"], std::abs(beta), 1e-9) << alpha << ' ' << beta;
    }
  }
}

// None has a longest axis.
TEST(Direction, IsZeroOfASphere) {
  Plan plan = channel({32, 32, 40});
  plan.bodies = {body(plan, "ball", "sphere", {0.1, 0.05, 0.02}, 0.5)};
  plan.bodies[0].rotation =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  plan.bodies[0].kind = capsule(plan, membrane::find_scheme("explicit-euler"), 10);
  const BodySample ball = Suspension(plan, PETSC_COMM_SELF).sample().bodies.at(0);
  EXPECT_EQ(ball["inclination"], 0);
  EXPECT_EQ(ball["tilt"], 0);
}

// The marker is in front, and in the plane as near as a mesh has one.
TEST(Phase, StartsInFront) {
  Plan plan = channel({32, 32, 40});
  for (const char* shape : {"sphere", "biconcave"}) {
    for (const double alpha : {0.0, 40.0, 90.0}) {
      plan.bodies = {body(plan, "cell", shape, {0.1, 0.05, 0.02}, 0.5)};
      const Eigen::AngleAxisd turn(alpha * degree, Eigen::Vector3d::UnitY());
      plan.bodies[0].rotation = turn.toRotationMatrix();
      plan.bodies[0].kind = capsule(plan, membrane::find_scheme("explicit-euler"), 10);
      const std::unique_ptr<Body> made = make_body(plan, 0);
      const Observation seen = made->observe();
      const Eigen::Vector3d arm = seen.marker - seen.centroid;
      EXPECT_LT(std::abs(arm.y()), 0.7) << shape << ' ' << alpha;  // edges are 1.2
      double furthest = 0;
      const std::vector<double> x = made->positions();
      for (std::size_t n = 0; n < x.size(); n += 3)
        furthest = std::max(furthest, x[n + 2] - seen.centroid.z());
      EXPECT_GT(arm.z(), furthest - 0.3) << shape << ' ' << alpha;
      EXPECT_NEAR(suspension::sample(seen)["phase"], std::atan2(arm.x(), arm.z()) / degree, 1e-9);
    }
  }
}

// A membrane inside of its surface: what is told is the surface's, but for the membrane's energy
// and the change of its volume.
TEST(Retraction, LeavesTheSurfaceWhereItIs) {
  Plan plan = channel({32, 32, 40});
  for (const char* shape : {"sphere", "biconcave"}) {
    std::array<BodySample, 2> seen;
    std::array<std::vector<double>, 2> surface;
    for (const std::size_t inside : {0, 1}) {
      plan.bodies = {body(plan, "cell", shape, {0.1, 0.05, 0.02}, 0.5)};
      plan.bodies[0].rotation = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitY());
      CapsulePlan kind = capsule(plan, membrane::find_scheme("explicit-euler"), 10);
      kind.retraction = inside == 0 ? 0 : 0.4;
      plan.bodies[0].kind = kind;
      const std::unique_ptr<Body> made = make_body(plan, 0);
      seen[inside] = suspension::sample(made->observe());
      surface[inside] = made->positions();
    }
    double apart = 0;
    for (std::size_t n = 0; n < surface[0].size(); ++n)
      apart = std::max(apart, std::abs(surface[0][n] - surface[1][n]));
    EXPECT_LT(apart, 0.05) << shape;  // lattice spacings
    EXPECT_GT(apart, 0) << shape;
    EXPECT_LT((seen[0].position() - seen[1].position()).norm(), 1e-12) << shape;
    EXPECT_NEAR(seen[0]["deformation"], seen[1]["deformation"], 0.003) << shape;
    if (std::string_view(shape) == "biconcave") {
      EXPECT_NEAR(seen[0]["inclination"], seen[1]["inclination"], 0.01);
    }
    EXPECT_NEAR(seen[1]["volume_error"], 0, 1e-12) << shape;
    EXPECT_NEAR(seen[1]["strain_energy"], 0, 1e-12) << shape;
  }
}

// Of the developed flow in the square duct, 0.14057701 alpha W^2/eta times 4 W^2: error of second
// order in dx, of what is read at t = 0 and of what the lattice makes of it.
class DuctFlowRate : public testing::TestWithParam<std::tuple<Boundary, double>> {};

TEST_P(DuctFlowRate, IsTheSeriesToSecondOrder) {
  const auto [walls, tau] = GetParam();
  std::array<double, 2> at_start{};
  std::array<double, 2> steady{};
  for (const int r : {0, 1}) {
    const int n = (12 << r) + (walls == Boundary::regularized ? 1 : 0);
    Plan plan = channel({n, n, 2});
    plan.fluid.boundary[0] = plan.fluid.boundary[1] = walls;
    plan.fluid.tau = tau;
    plan.units = Plan::channel_units(plan.fluid);
    plan.drive(10);
    Suspension suspension(plan, PETSC_COMM_SELF);
    const fluid::DuctFlow duct({1, 1}, 5 / poiseuille_coefficient(1, true), 1);
    const double expected = 4 * duct.mean();
    at_start[r] = suspension.sample().flow_rate / expected - 1;
    while (suspension.time() < 1.5) suspension.step();
    steady[r] = suspension.sample().flow_rate / expected - 1;
  }
  std::printf("at t = 0 %.3f%%, %.3f%%; steady %.3f%%, %.3f%%\n", 100 * at_start[0],
              100 * at_start[1], 100 * steady[0], 100 * steady[1]);
  for (const auto& error : {at_start, steady}) {
    EXPECT_LT(std::abs(error[0]), 0.04);
    EXPECT_NEAR(std::log2(error[0] / error[1]), 2, 0.2);
  }
}
INSTANTIATE_TEST_SUITE_P(All, DuctFlowRate,
                         testing::Combine(testing::Values(Boundary::halfway, Boundary::regularized),
                                          testing::Values(0.7, 1.0)));

// Linear and quadratic flows between plates: the linear one is summed exactly.
TEST(FlowRate, IsOfThePlatesThatMove) {
  for (const Boundary walls : {Boundary::halfway, Boundary::regularized}) {
    Plan plan = channel({12, 8, 5});
    plan.fluid.boundary = {walls, Boundary::periodic, Boundary::periodic};
    plan.fluid.wall_velocity[0] = {Eigen::Vector3d(0, 0, -0.01), Eigen::Vector3d(0, 0, 0.03)};
    plan.units = Plan::channel_units(plan.fluid);
    plan.drive(0);
    Suspension suspension(plan, PETSC_COMM_SELF);
    const double area = 2 * plan.units.length(8);
    const double expected = plan.units.velocity(0.01) * area;
    EXPECT_NEAR(suspension.sample().flow_rate, expected, 1e-6 * expected);
    for (int n = 0; n < 200; ++n) suspension.step();
    EXPECT_NEAR(suspension.sample().flow_rate, expected, 1e-4 * expected);
  }
}

// What a mirror plane leaves out is counted, and a body inside is no hole.
TEST(FlowRate, IsOfTheWholeChannel) {
  for (const auto& [nodes, mirror, walls] : std::vector<std::tuple<int, Mirror, Boundary>>{
           {16, Mirror::between_nodes, Boundary::halfway},
           {17, Mirror::on_node, Boundary::halfway},
           {17, Mirror::on_node, Boundary::regularized}}) {
    std::array<double, 2> rate{};
    for (const bool half : {false, true}) {
      Plan plan = channel({nodes, half ? (nodes + 1) / 2 : nodes, 24});
      plan.fluid.boundary[0] = plan.fluid.boundary[1] = walls;
      if (half) plan.fluid.mirror = mirror;
      plan.units = Plan::channel_units(plan.fluid);
      plan.drive(10);
      plan.bodies = {body(plan, "hard", "sphere", {0.2, 0, 0}, 0.4)};
      plan.bodies[0].kind = RigidPlan{};
      Suspension suspension(plan, PETSC_COMM_SELF);
      for (int n = 0; n < 50; ++n) suspension.step();
      rate[half ? 1 : 0] = suspension.sample().flow_rate;
    }
    EXPECT_NEAR(rate[1], rate[0], 1e-9 * rate[0]) << nodes;
    EXPECT_GT(rate[0], 8) << nodes;
  }
}

Eigen::Vector3d momentum(Suspension& suspension) {
  const FluidState fluid = suspension.fields();
  const std::size_t count = fluid.density.size();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t n = 0; n < count; ++n) {
    for (std::size_t a = 0; a < 3; ++a)
      sum[static_cast<Eigen::Index>(a)] += fluid.density[n] * fluid.velocity[a * count + n];
  }
  return suspension.plan().units.lattice_velocity(1) * sum;
}

// In a box without walls all of the fluid, that inside the body too, gains in a step what drives it
// and what the body gives, sum F = M_f (U - U_prev) - force; and the body moves by Newton's and
// Euler's laws with the force and the torque of the same row. All to round-off.
TEST(Force, IsWhatTheFluidLosesAndWhatMovesTheBody) {
  for (const auto& [ratio, memory, interior] : std::vector<std::tuple<double, double, Interior>>{
           {1, 0, Interior::fluid}, {3, 0.9, Interior::solid}, {0.6, 0, Interior::fluid}}) {
    Plan plan;
    plan.fluid.nodes = {24, 26, 28};
    plan.fluid.tau = 0.8;
    plan.fluid.force = {1e-6, -2e-6, 4e-6};
    plan.start = Start::rest;
    plan.gravity = {1e-5, 0, -3e-5};
    plan.units = Plan::channel_units(plan.fluid);
    plan.bodies = {body(plan, "hard", "sphere", {0.1, 0.03, 0.02}, 0.5)};
    plan.bodies[0].kind = RigidPlan{ratio, 5, memory, 0.5, interior};
    Suspension suspension(plan, PETSC_COMM_SELF);
    const Units& units = plan.units;
    const double volume = plan.bodies[0].shape->volume();
    const double inertia = plan.bodies[0].shape->inertia()(0, 0);
    Eigen::Vector3d before = momentum(suspension);
    BodySample body_before = suspension.sample().bodies.at(0);
    for (int n = 0; n < 30; ++n) {
      suspension.step();
      const Eigen::Vector3d now = momentum(suspension);
      const BodySample body_now = suspension.sample().bodies.at(0);
      const Eigen::Vector3d gained =
          units.lattice_velocity(1) * (body_now.velocity() - body_before.velocity());
      const Eigen::Vector3d F = force(body_now) / units.force(1);
      const Eigen::Vector3d expected =
          static_cast<double>(plan.node_count()) * plan.fluid.force + volume * gained - F;
      ASSERT_LT((now - before - expected).norm(), 1e-11) << ratio << ' ' << n;
      ASSERT_LT((ratio * volume * gained - (F + (ratio - 1) * volume * plan.gravity)).norm(), 1e-13)
          << ratio << ' ' << n;
      const Eigen::Vector3d spun =
          (omega(body_now) - omega(body_before)) / units.angular_velocity({1, 0, 0}).x();
      ASSERT_LT((ratio * inertia * spun - torque(body_now) / units.torque(1)).norm(), 1e-12)
          << ratio << ' ' << n;
      before = now;
      body_before = body_now;
    }
    EXPECT_GT(force(body_before).norm() / units.force(1), 1e-3) << ratio;
  }
}

}  // namespace
}  // namespace ductile::suspension
