// The coupled system by itself: put together from a plan, sampled, saved and loaded.
#include "ductile/suspension/suspension.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "ductile/fluid/duct.hpp"
#include "membrane/own_integrator.hpp"

namespace ductile::suspension {
namespace {

Plan channel(std::array<int, 3> nodes) {
  Plan plan;
  plan.fluid.nodes = nodes;
  plan.fluid.boundary = {fluid::Boundary::halfway, fluid::Boundary::halfway,
                         fluid::Boundary::periodic};
  plan.fluid.tau = 0.9;
  plan.units = Plan::channel_units(plan.fluid);
  plan.drive(10);
  return plan;
}

BodyPlan body(const Plan& plan, const std::string& name, const std::string& shape,
              const Eigen::Vector3d& at, double radius = 0.3) {
  BodyPlan body;
  body.name = name;
  body.shape = surface::make_shape(shape, plan.units.lattice_length(radius));
  body.frequency = surface::frequency_for_edge(body.shape->radius(), 1.2);
  body.centre = plan.units.lattice_position(at);
  return body;
}

CapsulePlan capsule(const Plan& plan, const membrane::Scheme& scheme, double laplace) {
  const double a = plan.units.lattice_length(0.3);
  CapsulePlan capsule;
  capsule.moduli.k_s = plan.units.lattice_shear_modulus(laplace, a);
  capsule.moduli.k_a = 2 * capsule.moduli.k_s;
  capsule.moduli.k_b = 2.87e-3 * capsule.moduli.k_s * a * a;
  capsule.moduli.k_v = 1;
  capsule.integrator = scheme;
  return capsule;
}

/// Every kind of body and of integrator, in near contact and across the periodic end.
Plan everything(fluid::Storage storage) {
  Plan plan = channel({20, 20, 44});
  plan.fluid.storage = storage;
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
  return plan;
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
  for (const auto storage : {fluid::Storage::double_precision, fluid::Storage::single_precision}) {
    const Plan plan = everything(storage);
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

// A reader that fails on one rank is every rank's to hear of, and a good load mends all.
TEST(Suspension, AFailedLoadIsEveryRanksToHearOf) {
  const Plan plan = everything(fluid::Storage::double_precision);
  Suspension straight(plan, PETSC_COMM_WORLD);
  straight.step();
  const Store state = saved(straight);
  Suspension other(plan, PETSC_COMM_WORLD);
  const int last = other.ranks() - 1;
  EXPECT_THROW(other.load([&](std::string_view name, std::span<double> numbers) {
    if (other.rank() == last && name == "fluid/f07") throw std::out_of_range("not there");
    std::ranges::copy(state.at(std::string(name)), numbers.begin());
  }),
               std::exception);
  load(other, state);
  straight.step();
  other.step();
  EXPECT_EQ(View(other).numbers, View(straight).numbers);
}

// Several systems side by side, each on a rank of its own.
TEST(Suspension, RunsOnOneRankOfALargerJob) {
  const Plan plan = everything(fluid::Storage::double_precision);
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
  const Plan good = everything(fluid::Storage::double_precision);
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
}

TEST(Suspension, ARefusedBodyIsEveryRanksToHearOf) {
  Plan plan = everything(fluid::Storage::double_precision);
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
  const Plan plan = everything(fluid::Storage::double_precision);
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
