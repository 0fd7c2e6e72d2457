// The coupled system by itself: put together from a plan, sampled, saved and loaded.
#include "ductile/suspension/suspension.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "ductile/fluid/duct.hpp"
#include "membrane/own_integrator.hpp"
#include "suspension/plans.hpp"

namespace ductile::suspension {
namespace {

using test::body;
using test::capsule;
using test::channel;

/// Every kind of body and of integrator, in near contact and across the periodic end.
Plan everything(fluid::Precision precision) {
  Plan plan = channel({20, 20, 58});
  plan.fluid.storage = plan.fluid.arithmetic = precision;
  plan.gravity = {0, 0, 1e-5};
  const auto add = [&plan](BodyPlan body, auto kind) {
    body.kind = std::move(kind);
    plan.bodies.push_back(std::move(body));
  };
  add(body(plan, "soft", "sphere", {0.3, 0, 1.9}),
      capsule(plan, membrane::find_scheme("explicit-euler"), 10));
  // Large enough for an inner shell.
  add(body(plan, "hard", "sphere", {-0.35, 0, 1.5}, 0.4),
      RigidPlan{2, 2, 0.9, 0.3, Interior::solid});
  add(body(plan, "cell", "biconcave", {0.1, -0.1, 0.2}),
      capsule(plan, membrane::find_scheme("implicit"), 1000));
  add(body(plan, "second", "sphere", {-0.3, 0.2, -0.9}),
      capsule(plan, membrane::find_scheme("adams-bashforth"), 20));
  CapsulePlan damped = capsule(plan, membrane::find_scheme("semi-implicit"), 2000);
  damped.integrator_options.theta = 1;
  damped.integrator_options.substeps = 2;
  add(body(plan, "damped", "sphere", {0.35, 0.1, -1.0}), damped);
  add(body(plan, "own", "sphere", {0, -0.3, -1.8}),
      capsule(plan, membrane::scheme<membrane::Heun>("heun"), 10));
  // Two with a film between them, across the end.
  const RigidPlan slipping{1, 2, 0.9, 0.7, Interior::fluid, 0.03};
  add(body(plan, "left", "sphere", {-0.3, 0.1, 2.85}), slipping);
  add(body(plan, "right", "sphere", {0.31, 0.1, -2.9}), slipping);
  plan.ride(0.8 * plan.u_max);
  plan.follow = true;
  return plan;
}

// In the order of their places along the channel, wherever in the plan they are and in whichever
// image, as many on each rank as on the next; one that is alone in the middle of the ranks.
TEST(Suspension, BodiesBelongToRanksNearThem) {
  Plan plan = channel({20, 20, 80});
  const auto owners_of = [&plan](const std::vector<double>& places, int ranks) {
    plan.bodies.clear();
    for (const double z : places)
      plan.bodies.push_back(body(plan, std::to_string(z), "sphere", {0, 0, z}));
    return owners(plan, ranks);
  };
  using Owners = std::vector<int>;
  EXPECT_EQ(owners_of({0.6, -0.6}, 1), (Owners{0, 0}));
  EXPECT_EQ(owners_of({0.6, -0.6}, 2), (Owners{1, 0}));
  EXPECT_EQ(owners_of({-0.6, 0.6}, 2), (Owners{0, 1}));
  EXPECT_EQ(owners_of({4.6, -4.6}, 2), (Owners{0, 1}));  // -3.4 and 3.4: the channel is 8 long
  EXPECT_EQ(owners_of({-3, 3, -1, 1}, 4), (Owners{0, 3, 1, 2}));
  EXPECT_EQ(owners_of({-3, 3, -1, 1}, 2), (Owners{0, 1, 0, 1}));
  EXPECT_EQ(owners_of({-1, 1, 0}, 2), (Owners{0, 1, 1}));
  EXPECT_EQ(owners_of({-3.5}, 3), Owners{1});
  EXPECT_EQ(owners_of({-2, 2}, 8), (Owners{2, 6}));
  EXPECT_EQ(owners_of({}, 2), Owners{});
}

// Spheres, where gaps are known but for what a mesh lies within its sphere: e^2/(6 R), and once
// more where another mesh is across.
void check_gaps(const std::variant<CapsulePlan, RigidPlan>& kind) {
  Plan plan = channel({24, 24, 48});
  const double a = plan.units.lattice_length(0.3);
  const double within = 1.2 * 1.2 / (6 * a);
  const auto add = [&](const std::string& name, const Eigen::Vector3d& lattice_shift) {
    BodyPlan sphere = body(plan, name, "sphere", {0, 0, 0});
    sphere.centre += lattice_shift;
    sphere.kind = kind;
    plan.bodies.push_back(std::move(sphere));
  };
  add("middle", {0, 0, 0});
  add("near", {0, 0, 2 * a + 1});          // 1 from the middle
  add("image", {0, 0, 48 - 2 * a - 1.5});  // 1.5 from the middle's image
  add("wall", {-12 + a + 1.8, 0, 24});     // 1.8 from the wall at x = -1
  add("corner", {12 - a - 1.9, 12 - a - 1.7, 24});
  Suspension suspension(plan, PETSC_COMM_WORLD);
  const std::vector<Gap> gaps = suspension.gaps(kernel_reach);
  if (suspension.rank() != 0) {
    EXPECT_TRUE(gaps.empty());
    return;
  }
  using To = Gap::To;
  const std::vector<Gap> expected = {{To::body, 0, 1, 1, 0},
                                     {To::body, 0, 2, 1.5, 0},
                                     {To::wall, 3, 0, 1.8, -1},
                                     {To::wall, 4, 0, 1.9, 1},
                                     {To::wall, 4, 1, 1.7, 1}};
  ASSERT_EQ(gaps.size(), expected.size());
  for (std::size_t n = 0; n < gaps.size(); ++n) {
    EXPECT_TRUE(gaps[n].between_same(expected[n])) << n;
    EXPECT_GE(gaps[n].distance, expected[n].distance - 1e-9) << n;
    EXPECT_LE(gaps[n].distance, expected[n].distance + 2 * within) << n;
  }
}

// Markers inside of the surface make no difference.
TEST(Gaps, AreThoseOfRigidSpheresAndWalls) {
  check_gaps(RigidPlan{1, 5, 0, 0.4});
}
TEST(Gaps, AreThoseOfCapsulesAndWalls) {
  CapsulePlan kind;
  kind.moduli.k_s = 0.01;
  kind.retraction = 0.4;
  check_gaps(kind);
}

TEST(Gaps, ABodyMayBeNearItsOwnImage) {
  Plan plan = channel({24, 24, 15});
  plan.bodies = {body(plan, "only", "sphere", {0, 0, 0})};
  plan.bodies[0].shape = surface::make_shape("sphere", 7);
  plan.bodies[0].kind = RigidPlan{};
  Suspension suspension(plan, PETSC_COMM_WORLD);
  const std::vector<Gap> gaps = suspension.gaps(kernel_reach);
  if (suspension.rank() != 0) return;
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_TRUE(gaps[0].between_same({Gap::To::image, 0, 0, 1, 0}));
  EXPECT_NEAR(gaps[0].distance, 1, 0.3);  // edges of 2.8: within the sphere by up to 0.19
}

using Store = std::map<std::string, std::vector<double>, std::less<>>;

Store saved(Suspension& suspension) {
  Store store;
  suspension.save([&](std::string_view name, std::span<const double> numbers) {
    const bool is_new = store.emplace(name, std::vector(numbers.begin(), numbers.end())).second;
    EXPECT_TRUE(is_new) << name << " is there twice";
  });
  return store;
}

void load(Suspension& suspension, const Store& store) {
  std::set<std::string> read;
  suspension.load([&](std::string_view name, std::span<double> numbers) {
    const auto& kept = store.at(std::string(name));
    ASSERT_EQ(kept.size(), numbers.size()) << name;
    std::ranges::copy(kept, numbers.begin());
    read.emplace(name);
  });
  EXPECT_EQ(read.size(), store.size()) << "something was saved that nobody reads";
}

/// All that is seen from outside, on rank 0.
struct View {
  std::vector<double> numbers;
  explicit View(Suspension& suspension) {
    const Sample sample = suspension.sample();
    numbers.push_back(sample.time);
    numbers.push_back(sample.flow_rate);
    append(sample.ahead);
    for (const BodySample& body : sample.bodies) append(body.values);
    for (const SurfaceState& surface : suspension.surfaces()) {
      append(surface.position);
      append(surface.velocity);
      append(surface.force);
    }
    const FluidState fluid = suspension.fields();
    append(fluid.density);
    append(fluid.velocity);
    for (const membrane::SolveStatistics& spent : suspension.solvers()) {
      for (const std::int64_t n : {spent.solves, spent.newton_iterations, spent.krylov_iterations,
                                   spent.tangents, spent.step_cuts})
        numbers.push_back(static_cast<double>(n));
    }
  }
  void append(const std::vector<double>& more) {
    numbers.insert(numbers.end(), more.begin(), more.end());
  }
};

// Odd and even numbers of steps, before and after a kept tangent is renewed, at the very start.
TEST(Suspension, GoesOnFromASavedStateAsIfNothingHadBeen) {
  for (const auto precision :
       {fluid::Precision::double_precision, fluid::Precision::single_precision}) {
    const Plan plan = everything(precision);
    Suspension straight(plan, PETSC_COMM_WORLD);
    for (const int before : {0, 1, 2, 25}) {
      while (straight.steps() < before) straight.step();
      Suspension resumed(plan, PETSC_COMM_WORLD);
      if (before == 2) {
        // What a suspension did before it is loaded leaves no trace.
        for (int n = 0; n < 3; ++n) resumed.step();
      }
      const Store state = saved(straight);
      load(resumed, state);
      EXPECT_EQ(saved(resumed), state) << before;
      EXPECT_EQ(View(resumed).numbers, View(straight).numbers) << before;
      for (int n = 0; n < 5; ++n) resumed.step();
      Suspension other(plan, PETSC_COMM_WORLD);
      load(other, state);
      for (int n = 0; n < 5; ++n) other.step();
      const std::int64_t end = before + 5;
      Suspension reference(plan, PETSC_COMM_WORLD);
      while (reference.steps() < end) reference.step();
      const View expected(reference);
      EXPECT_EQ(View(resumed).numbers, expected.numbers) << before;
      EXPECT_EQ(View(other).numbers, expected.numbers) << before;
      EXPECT_EQ(saved(resumed), saved(reference)) << before;
    }
  }
}

// Half of a symmetric channel with walls on nodes; and plates that move past each other.
TEST(Suspension, GoesOnFromASavedStateInOtherChannels) {
  Plan half = channel({21, 11, 30});
  half.fluid.boundary[0] = half.fluid.boundary[1] = fluid::Boundary::regularized;
  half.fluid.mirror = fluid::Mirror::on_node;
  half.fluid.collision = fluid::Collision::trt;
  Plan plates = channel({20, 20, 30});
  plates.fluid.boundary[1] = fluid::Boundary::periodic;
  plates.fluid.wall_velocity[0] = {Eigen::Vector3d(0, 0, -0.02), Eigen::Vector3d(0, 0, 0.02)};
  for (Plan* plan : {&half, &plates}) {
    plan->units = Plan::channel_units(plan->fluid);
    plan->drive(plan == &half ? 10 : 0);
    plan->bodies = {body(*plan, "soft", "sphere", {0.3, 0, 0}),
                    body(*plan, "hard", "sphere", {-0.3, 0, 0.5}, 0.4)};
    plan->bodies[0].kind = capsule(*plan, membrane::find_scheme("explicit-euler"), 10);
    plan->bodies[1].kind = RigidPlan{};
    Suspension straight(*plan, PETSC_COMM_WORLD);
    for (int n = 0; n < 3; ++n) straight.step();
    Suspension resumed(*plan, PETSC_COMM_WORLD);
    load(resumed, saved(straight));
    for (int n = 0; n < 4; ++n) {
      straight.step();
      resumed.step();
    }
    EXPECT_EQ(View(resumed).numbers, View(straight).numbers);
    EXPECT_EQ(saved(resumed), saved(straight));
  }
}

// What is saved is the same on any number of ranks, and any number goes on from it.
TEST(Suspension, GoesOnOnAnotherNumberOfRanks) {
  for (const auto precision :
       {fluid::Precision::double_precision, fluid::Precision::single_precision}) {
    const Plan plan = everything(precision);
    Suspension together(plan, PETSC_COMM_WORLD);
    Suspension alone(plan, PETSC_COMM_SELF);
    for (int n = 0; n < 7; ++n) {
      together.step();
      alone.step();
    }
    Store of_all = saved(together);
    const Store of_one = saved(alone);
    if (together.rank() == 0) {
      EXPECT_EQ(of_all, of_one);
      Suspension fewer(plan, PETSC_COMM_SELF);
      load(fewer, of_all);
      for (int n = 0; n < 5; ++n) fewer.step();
      for (int n = 0; n < 5; ++n) alone.step();
      EXPECT_EQ(saved(fewer), saved(alone));
    }
    Suspension more(plan, PETSC_COMM_WORLD);
    load(more, together.rank() == 0 ? of_one : Store());
    for (int n = 0; n < 5; ++n) more.step();
    for (int n = 0; n < 5; ++n) together.step();
    EXPECT_EQ(saved(more), saved(together));
    EXPECT_EQ(View(more).numbers, View(together).numbers);
  }
}

// Whatever fails at whatever part is every rank's to hear of, and a good load mends all.
TEST(Suspension, AFailedLoadOrSaveIsEveryRanksToHearOf) {
  const Plan plan = everything(fluid::Precision::double_precision);
  Suspension straight(plan, PETSC_COMM_WORLD);
  straight.step();
  const Store state = saved(straight);
  Suspension other(plan, PETSC_COMM_WORLD);
  for (std::size_t n = 0; n < 60; n += 4) {
    std::size_t count = 0;
    const auto fail = [&] {
      if (count++ == n) throw std::out_of_range("not there");
    };
    EXPECT_THROW(other.load([&](std::string_view name, std::span<double> numbers) {
      fail();
      std::ranges::copy(state.at(std::string(name)), numbers.begin());
    }),
                 std::exception)
        << n;
    count = 0;
    EXPECT_THROW(other.save([&](std::string_view, std::span<const double>) { fail(); }),
                 std::exception)
        << n;
  }
  load(other, state);
  straight.step();
  other.step();
  EXPECT_EQ(View(other).numbers, View(straight).numbers);
}

// Several systems side by side, each on a rank of its own.
TEST(Suspension, RunsOnOneRankOfALargerJob) {
  const Plan plan = everything(fluid::Precision::double_precision);
  Suspension alone(plan, PETSC_COMM_SELF);
  Suspension together(plan, PETSC_COMM_WORLD);
  for (int n = 0; n < 3; ++n) {
    alone.step();
    together.step();
  }
  const View expected(alone);
  const View all(together);
  if (together.rank() != 0) return;
  EXPECT_EQ(all.numbers, expected.numbers);
}

TEST(Suspension, RefusesAPlanThatContradictsItself) {
  const auto refusal = [](Plan plan) -> std::string {
    try {
      const Suspension suspension(std::move(plan), PETSC_COMM_WORLD);
      return "";
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
  };
  const Plan good = everything(fluid::Precision::double_precision);
  Plan plan = good;
  plan.fluid.tau = 0.8;
  EXPECT_NE(refusal(plan).find("the units have the viscosity 0.133333"), std::string::npos);
  plan = good;
  plan.fluid.wall_velocity[0][1] = {0, 0, 0.01};
  EXPECT_NE(refusal(plan).find("start at rest"), std::string::npos);
  plan = good;
  plan.bodies[1].name = "soft";
  EXPECT_NE(refusal(plan).find("body name 'soft'"), std::string::npos);
  plan = good;
  plan.bodies[2].shape.reset();
  EXPECT_NE(refusal(plan).find("body cell has no shape"), std::string::npos);
  plan = channel({20, 10, 30});
  plan.fluid.mirror = fluid::Mirror::between_nodes;
  plan.units = Plan::channel_units(plan.fluid);
  plan.drive(10);
  plan.bodies = {body(plan, "aside", "sphere", {0, 0.4, 0})};
  plan.bodies[0].kind = RigidPlan{1, 2, 0.9, 0.7, Interior::fluid, 0.03};
  EXPECT_NE(refusal(plan).find("aside, a sphere with slip, is not on the mirror plane"),
            std::string::npos);
}

TEST(Suspension, ARefusedBodyIsEveryRanksToHearOf) {
  Plan plan = everything(fluid::Precision::double_precision);
  std::get<RigidPlan>(plan.bodies[1].kind).memory = 1.5;
  try {
    const Suspension suspension(plan, PETSC_COMM_WORLD);
    FAIL() << "took a memory of 1.5";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("body hard: "), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("memory = 1.5"), std::string::npos) << error.what();
  }
}

// The developed flow is eq. (1) at once, in the paper's units: U_max = Re/2.
TEST(Suspension, AnEmptyChannelFlowsAsTheSeriesSays) {
  Plan plan = channel({16, 16, 6});
  Suspension suspension(plan, PETSC_COMM_WORLD);
  const fluid::DuctFlow duct({1, 1}, 5 / 0.29468541, 1);
  const FluidState fluid = suspension.fields();
  if (suspension.rank() != 0) return;
  const std::size_t count = fluid.density.size();
  ASSERT_EQ(count, 16U * 16 * 6);
  for (int i = 0; i < 16; ++i) {
    for (int j = 0; j < 16; ++j) {
      const Eigen::Vector3d at = plan.units.position({double(i), double(j), 0});
      const std::size_t node = static_cast<std::size_t>(16 * i + j) * 6;
      EXPECT_NEAR(fluid.velocity[2 * count + node], duct.velocity(at.x(), at.y()), 1e-6);
    }
  }
}

// The same flow, by whatever velocity the lattice moves: at once and later on, in a whole channel
// and in half of one with walls on nodes, and at rest.
TEST(Suspension, AnEmptyChannelIsTheSameOnAMovingLattice) {
  Plan half = channel({17, 9, 6});
  half.fluid.boundary[0] = half.fluid.boundary[1] = fluid::Boundary::regularized;
  half.fluid.mirror = fluid::Mirror::on_node;
  half.units = Plan::channel_units(half.fluid);
  half.drive(10);
  Plan still = channel({16, 16, 6});
  still.start = Start::rest;
  still.drive(0);
  for (const Plan& plan : {channel({16, 16, 6}), half, still}) {
    Plan moving = plan;
    moving.follow = true;  // nobody
    moving.ride(0.01);
    moving.ride(0.8 * channel({16, 16, 6}).u_max);  // the last counts
    EXPECT_EQ(moving.wall_velocity(), plan.wall_velocity());
    Suspension of_walls(plan, PETSC_COMM_WORLD);
    Suspension of_lattice(moving, PETSC_COMM_WORLD);
    for (int n = 0; n < 200; ++n) {
      const double expected = of_walls.sample().flow_rate;
      EXPECT_NEAR(of_lattice.sample().flow_rate, expected, 1e-3);  // of 9.6 nu W
      of_walls.step();
      of_lattice.step();
    }
    const FluidState expected = of_walls.fields();
    const FluidState found = of_lattice.fields();
    for (std::size_t n = 0; n < expected.velocity.size(); ++n)
      ASSERT_NEAR(found.velocity[n], expected.velocity[n], 2e-3) << n;
  }
}

// A rigid sphere off the axis; the lattice starts with so much of the flow's largest velocity.
Plan with_sphere(double tau, double frame) {
  Plan plan = channel({16, 16, 32});
  plan.fluid.tau = tau;
  plan.units = Plan::channel_units(plan.fluid);
  plan.drive(10);
  plan.ride(frame * plan.u_max);
  plan.bodies = {body(plan, "sphere", "sphere", {0.2, 0, 0}, 0.4)};
  plan.bodies[0].kind = RigidPlan{1, 2, 0.9};
  return plan;
}

// Where a rigid sphere goes at tau = 1 and 0.7 differs by the lattice's own errors, most of which
// come with its velocity on the lattice (doc/equations.md, "Galilean invariance").
TEST(Suspension, ALatticeThatMovesWithASphereLiftsItTheSameAtAnyTau) {
  const auto lifted = [](double tau, double frame) {
    Suspension suspension(with_sphere(tau, frame), PETSC_COMM_WORLD);
    while (suspension.time() < 2) suspension.step();
    const Sample end = suspension.sample();
    if (suspension.rank() != 0) return Eigen::Vector2d(0, 0);
    return Eigen::Vector2d(end.bodies[0].position().x(), end.bodies[0].position().z());
  };
  const Eigen::Vector2d of_walls = lifted(1, 0) - lifted(0.7, 0);
  const Eigen::Vector2d with_sphere = lifted(1, 0.85) - lifted(0.7, 0.85);
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank != 0) return;
  std::printf(
      "x(2) of tau = 1 and 0.7 apart by %.5f W on a lattice at rest, %.5f W on one that "
      "moves; z by %.3f, %.3f W\n",
      of_walls[0], with_sphere[0], of_walls[1], with_sphere[1]);
  EXPECT_LT(of_walls[0], -0.01);
  EXPECT_LT(std::abs(with_sphere[0]), 0.2 * std::abs(of_walls[0]));
}

// A lattice that follows a sphere has no say in where that goes, whatever its velocity at the
// start.
TEST(Suspension, ALatticeFollowsItsBodies) {
  struct Course {
    double x = 0;
    double behind = 0;  // the lattice, between t = 1 and 2 [W]
    double mach = 0;    // at t = 2
    double walls = 0;   // of the lattice's motion from t = 1 to 2
  };
  const auto course = [](double start, bool follow) {
    Plan plan = with_sphere(1, start);
    plan.follow = follow;
    Suspension suspension(plan, PETSC_COMM_WORLD);
    std::array<double, 2> ahead{};
    std::array<double, 2> way{};
    Course result;
    for (const std::size_t half : {0, 1}) {
      while (suspension.time() < static_cast<double>(half + 1)) suspension.step();
      const Sample sample = suspension.sample();
      const FluidState fluid = suspension.fields();
      if (suspension.rank() != 0) continue;
      result.x = sample.bodies[0].position().x();
      ahead.at(half) = sample.bodies[0].position().z() - fluid.way;
      way.at(half) = fluid.way;
      result.mach = sample.mach;
    }
    result.behind = ahead[1] - ahead[0];
    result.walls = std::sqrt(3.0) * plan.units.lattice_velocity(way[1] - way[0]);
    return result;
  };
  const std::array still = {course(0, false), course(0.85, false)};
  const std::array following = {course(0, true), course(0.85, true)};
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank != 0) return;
  std::printf(
      "x(2) of frames that start at rest and at .85 U apart by %.5f W, by %.5f W where they "
      "follow, the lattice %.3f and %.4f W behind in a unit of time\n",
      still[0].x - still[1].x, following[0].x - following[1].x, still[1].behind,
      following[1].behind);
  EXPECT_LT(still[0].x - still[1].x, -0.005);
  EXPECT_LT(std::abs(following[0].x - following[1].x), 0.1 * std::abs(still[0].x - still[1].x));
  EXPECT_GT(std::abs(still[1].behind), 0.1);
  EXPECT_LT(std::abs(following[0].behind), 0.01);
  EXPECT_LT(std::abs(following[1].behind), 0.01);
  // On a lattice at rest the flow is fastest, on one that goes along with the sphere the walls.
  EXPECT_DOUBLE_EQ(still[0].mach, with_sphere(1, 0).mach());
  EXPECT_NEAR(following[0].mach, following[0].walls, 0.02 * still[0].mach);
  EXPECT_LT(following[0].mach, 0.95 * still[0].mach);
}

// Where the density is the pressure alone, a flow that is steady on the lattice depends on tau
// through (tau - 1/2)(tau_odd - 1/2) alone: so does where a sphere goes that the lattice follows.
TEST(Suspension, ASphereThatIsFollowedGoesTheSameWayAtAnyTau) {
  const auto lifted = [](double tau, fluid::Equilibrium equilibrium) {
    Plan plan = with_sphere(tau, 0.85);
    plan.fluid.collision = fluid::Collision::trt;
    plan.fluid.magic = 0.25;  // of bgk at tau = 1
    plan.fluid.equilibrium = equilibrium;
    plan.follow = true;
    plan.bodies[0].kind = RigidPlan{1, 5, 0.9};
    Suspension suspension(plan, PETSC_COMM_WORLD);
    while (suspension.time() < 6) suspension.step();
    const Sample end = suspension.sample();
    return suspension.rank() == 0 ? end.bodies[0].position().x() : 0.0;
  };
  const auto apart = [&](fluid::Equilibrium equilibrium) {
    return lifted(1, equilibrium) - lifted(0.7, equilibrium);
  };
  const double weighing = apart(fluid::Equilibrium::compressible);
  const double not_weighing = apart(fluid::Equilibrium::incompressible);
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank != 0) return;
  std::printf(
      "x(6) of tau = 1 and 0.7 apart by %.5f W where the density weighs, %.5f W where not\n",
      weighing, not_weighing);
  EXPECT_LT(weighing, -0.01);
  EXPECT_LT(std::abs(not_weighing), 0.2 * std::abs(weighing));
}

// A linear flow is the same to a point, to the kernel and to a mean over a surface: what is told at
// t = 0 is what the first step does.
TEST(Suspension, BodiesInShearStartWithTheVelocityThatTheFirstStepGives) {
  Plan plan = channel({24, 24, 40});
  plan.fluid.boundary[1] = fluid::Boundary::periodic;
  plan.fluid.wall_velocity[0] = {Eigen::Vector3d(0, 0, -0.01), Eigen::Vector3d(0, 0, 0.03)};
  plan.units = Plan::channel_units(plan.fluid);
  plan.drive(0);
  plan.bodies = {body(plan, "soft", "sphere", {0.3, 0, -1}),
                 body(plan, "hard", "sphere", {-0.3, 0.1, 0}),
                 body(plan, "heavy", "sphere", {0.2, 0, 1})};
  plan.bodies[0].kind = capsule(plan, membrane::find_scheme("explicit-euler"), 10);
  plan.bodies[1].kind = RigidPlan{};
  plan.bodies[2].kind = RigidPlan{2};
  const auto flow = [&](double x) { return plan.units.velocity(0.01 + 0.02 * x); };

  Suspension suspension(plan, PETSC_COMM_WORLD);
  const Sample start = suspension.sample();
  const std::vector<SurfaceState> surfaces = suspension.surfaces();
  suspension.step();
  const Sample first = suspension.sample();
  if (suspension.rank() != 0) return;
  for (std::size_t b = 0; b < 3; ++b) {
    const SurfaceState& surface = surfaces[b];
    for (std::size_t n = 0; n < surface.position.size(); n += 3) {
      EXPECT_EQ(surface.velocity[n], 0);
      EXPECT_EQ(surface.velocity[n + 1], 0);
      EXPECT_NEAR(surface.velocity[n + 2], flow(surface.position[n]), 1e-12);
    }
  }
  for (std::size_t b = 0; b < 2; ++b) {
    const Eigen::Vector3d expected(0, 0, flow(start.bodies[b]["x"]));
    EXPECT_LT((start.bodies[b].velocity() - expected).norm(), 1e-11) << b;
    EXPECT_LT((first.bodies[b].velocity() - expected).norm(), 1e-3 * expected.norm()) << b;
  }
  // It is released at rest, and its first step tells of that.
  EXPECT_EQ(start.bodies[2].velocity(), Eigen::Vector3d::Zero());
  EXPECT_LT(first.bodies[2]["vz"], 0.9 * flow(0.2));
}

// In a channel the flow is curved, and a body's velocity a mean over it: below that of the flow at
// its centre. The kernel adds less than 3% here. Nothing moves in a fluid that starts at rest.
TEST(Suspension, BodiesInAChannelStartWithTheVelocityOfTheFlow) {
  for (const Start flow : {Start::developed, Start::rest}) {
    Plan plan = channel({24, 24, 40});
    plan.start = flow;
    plan.bodies = {body(plan, "soft", "sphere", {0.3, 0, -1}),
                   body(plan, "hard", "sphere", {-0.3, 0.1, 1})};
    plan.bodies[0].kind = capsule(plan, membrane::find_scheme("implicit"), 100);
    plan.bodies[1].kind = RigidPlan{};
    Suspension suspension(plan, PETSC_COMM_WORLD);
    const Sample start = suspension.sample();
    suspension.step();
    const Sample first = suspension.sample();
    if (suspension.rank() != 0) continue;
    const fluid::DuctFlow duct({1, 1}, 5 / 0.29468541, 1);
    for (std::size_t b = 0; b < 2; ++b) {
      const BodySample& body = start.bodies[b];
      if (flow == Start::rest) {
        EXPECT_EQ(body.velocity(), Eigen::Vector3d::Zero()) << b;
        continue;
      }
      EXPECT_NEAR(body["vz"], first.bodies[b]["vz"], 0.03 * first.bodies[b]["vz"]) << b;
      EXPECT_LT(body["vz"], duct.velocity(body["x"], body["y"])) << b;
    }
  }
}

TEST(Quantities, HaveNamesOfTheirOwnAndSayWhomTheyAreOf) {
  std::set<std::string_view> names;
  for (const Quantity& quantity : quantities()) {
    EXPECT_TRUE(names.insert(quantity.name).second) << quantity.name;
    EXPECT_FALSE(quantity.unit.empty());
    EXPECT_TRUE(quantity.applies(true) || quantity.applies(false));
  }
  const std::array<std::string_view, motion_quantities> first = {"x", "y", "z", "vx", "vy", "vz"};
  for (std::size_t q = 0; q < first.size(); ++q) EXPECT_EQ(quantities()[q].name, first[q]);
  BodySample sample;
  sample["slip"] = 3;
  EXPECT_EQ(sample["slip"], 3);
  EXPECT_THROW(static_cast<void>(sample["nonsense"]), std::out_of_range);
}

// Shells come after the surface, which is all that is seen.
TEST(Suspension, ASolidBodyHasMarkersInside) {
  Plan plan = channel({30, 30, 30});
  for (const Interior interior : {Interior::fluid, Interior::solid}) {
    plan.bodies = {body(plan, "hard", "sphere", {0, 0, 0}, 0.5)};
    plan.bodies[0].kind = RigidPlan{1, 5, 0, 0, interior};
    Suspension suspension(plan, PETSC_COMM_SELF);
    suspension.step();
    const std::size_t surface = plan.bodies[0].mesh().vertices.size();
    const std::size_t markers = make_body(plan, 0)->markers().marker_count();
    // Of a = 7.5: 6 and 3 inside, with edges half as long again.
    EXPECT_EQ(markers - surface, interior == Interior::solid ? 204U : 0U);
    const std::vector<SurfaceState> seen = suspension.surfaces();
    ASSERT_EQ(seen.at(0).position.size(), 3 * surface);
    ASSERT_EQ(seen.at(0).velocity.size(), 3 * surface);
  }
}

// A quantity is 0 where it does not apply, and the same wherever its owner is.
TEST(Suspension, SamplesAreOfTheBodiesInTheirOrder) {
  const Plan plan = everything(fluid::Precision::double_precision);
  Suspension suspension(plan, PETSC_COMM_WORLD);
  const Sample sample = suspension.sample();
  if (suspension.rank() != 0) {
    EXPECT_TRUE(sample.bodies.empty());
    return;
  }
  ASSERT_EQ(sample.bodies.size(), plan.bodies.size());
  for (std::size_t b = 0; b < plan.bodies.size(); ++b) {
    const Eigen::Vector3d at = plan.units.position(plan.bodies[b].centre);
    EXPECT_LT((sample.bodies[b].position() - at).norm(), 1e-12) << b;
    EXPECT_EQ(sample.bodies[b].capsule, plan.bodies[b].capsule() != nullptr);
    EXPECT_NEAR(sample.bodies[b]["volume_error"], 0, 1e-14);
  }
}

}  // namespace
}  // namespace ductile::suspension
