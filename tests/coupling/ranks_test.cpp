// The same bits on any number of ranks: each rank also computes the whole on its own.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <tuple>

#include "coupling/bodies.hpp"
#include "ductile/coupling/coupler.hpp"

namespace {

using namespace ductile;
using coupling::BodyFailure;
using coupling::Coupler;
using coupling::Member;
using test::Explicit;
using test::Held;

int rank() {
  int r = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &r);
  return r;
}
int ranks() {
  int n = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &n);
  return n;
}

// Of the ends along z, and with a mirror plane below the bodies or none.
using Kind = std::tuple<fluid::Boundary, fluid::Mirror>;

constexpr Kind whole_channel = {fluid::Boundary::periodic, fluid::Mirror::none};

fluid::Options channel(const Kind& kind) {
  fluid::Options o;
  o.boundary = {fluid::Boundary::halfway, fluid::Boundary::halfway, std::get<0>(kind)};
  o.mirror = std::get<1>(kind);
  o.nodes = {16, o.mirror == fluid::Mirror::none ? 14 : 9, 22};
  o.tau = 0.9;
  o.force = {0, 0, 2e-4};
  return o;
}

// Clouds of markers held together by springs to their centre, and one held in place; they overlap
// and lie across the cuts, the periodic end and, but for the last, the mirror plane.
std::vector<std::unique_ptr<coupling::Body>> bodies(const Kind& kind) {
  const auto springs = [](std::span<const double> x, std::span<double> force) {
    std::array<double, 3> centre{};
    for (std::size_t n = 0; n < x.size(); ++n)
      centre[n % 3] += 3 * x[n] / static_cast<double>(x.size());
    for (std::size_t n = 0; n < x.size(); ++n) force[n] = -2e-3 * (x[n] - centre[n % 3]);
  };
  std::vector<std::unique_ptr<coupling::Body>> list;
  std::mt19937 random(3);
  for (const double z : {5.0, 7.5, 12.0, 17.0}) {
    std::uniform_real_distribution<double> offset(-2.5, 2.5);
    const double y = std::get<1>(kind) == fluid::Mirror::none ? 6.8 : z == 17.0 ? 3.2 : -0.1;
    std::vector<double> x;
    for (int m = 0; m < 60; ++m) {
      x.insert(x.end(), {7.3 + offset(random), y + offset(random), z + offset(random)});
    }
    if (z == 12.0) {
      list.push_back(std::make_unique<Held>(x, 3, 0.3));
    } else {
      list.push_back(std::make_unique<Explicit>(x, springs));
    }
  }
  return list;
}

std::vector<Member> share_of(const std::vector<std::unique_ptr<coupling::Body>>& list, int part,
                             int parts) {
  std::vector<Member> members;
  for (int id = 0; id < static_cast<int>(list.size()); ++id) {
    if (id % parts == part) members.push_back({id, list[static_cast<std::size_t>(id)].get()});
  }
  return members;
}

class Ranks : public testing::TestWithParam<Kind> {};

TEST_P(Ranks, BodiesAndFluidAreTheSameToTheLastBit) {
  const fluid::Options o = channel(GetParam());
  fluid::Fluid cut(MPI_COMM_WORLD, o);
  fluid::Fluid whole(MPI_COMM_SELF, o);
  auto shared = bodies(GetParam());
  auto own = bodies(GetParam());
  Coupler coupler(cut, share_of(shared, rank(), ranks()), 4);
  Coupler alone(whole, share_of(own, 0, 1), 4);
  const std::int64_t sent_before = cut.bytes_sent();
  for (int step = 0; step < 60; ++step) {
    coupler.step();
    alone.step();
    for (const Member& member : share_of(shared, rank(), ranks())) {
      const auto a = member.body->positions();
      const auto b = own[static_cast<std::size_t>(member.id)]->positions();
      for (std::size_t n = 0; n < a.size(); ++n) ASSERT_EQ(a[n], b[n]) << step << ' ' << n;
    }
  }
  // Markers and velocities of bodies that reach over, and the fluid's planes.
  EXPECT_EQ(alone.profile().bytes_sent, 0);
  if (ranks() > 1) {
    EXPECT_GT(coupler.profile().bytes_sent, cut.bytes_sent() - sent_before);
  }
  const fluid::Totals a = cut.totals();
  const fluid::Totals b = whole.totals();
  EXPECT_EQ(a.mass, b.mass);
  EXPECT_EQ(a.momentum, b.momentum);
}

INSTANTIATE_TEST_SUITE_P(
    Ends, Ranks,
    testing::Combine(testing::Values(fluid::Boundary::periodic, fluid::Boundary::halfway),
                     testing::Values(fluid::Mirror::none, fluid::Mirror::between_nodes,
                                     fluid::Mirror::on_node)));

// Bodies and fluid put into another state between steps, bodies far from their boxes, go on as with
// a new coupler in a fluid of that state.
TEST_P(Ranks, ReplacedBodiesGoOnAsWithANewCoupler) {
  const fluid::Options o = channel(GetParam());
  const auto displaced = [](const std::vector<std::unique_ptr<coupling::Body>>& list) {
    for (const auto& body : list) {
      if (auto* free = dynamic_cast<Explicit*>(body.get())) {
        for (std::size_t n = 2; n < free->x.size(); n += 3) free->x[n] = 21 - free->x[n];
      }
    }
  };
  fluid::Fluid used(MPI_COMM_WORLD, o);
  auto bodies_used = bodies(GetParam());
  Coupler coupler(used, share_of(bodies_used, rank(), ranks()), 4);
  for (int step = 0; step < 5; ++step) coupler.step();
  displaced(bodies_used);
  coupler.bodies_replaced();

  fluid::Fluid fresh(MPI_COMM_WORLD, o);
  std::map<std::string, std::vector<double>, std::less<>> state;
  used.save([&](std::string_view name, std::span<const double> numbers) {
    state.emplace(name, std::vector(numbers.begin(), numbers.end()));
  });
  fresh.load([&](std::string_view name, std::span<double> numbers) {
    const auto& saved = state.find(name)->second;
    std::copy(saved.begin(), saved.end(), numbers.begin());
  });
  auto bodies_fresh = bodies(GetParam());
  for (std::size_t id = 0; id < bodies_fresh.size(); ++id) {
    if (auto* free = dynamic_cast<Explicit*>(bodies_fresh[id].get())) {
      free->x = dynamic_cast<Explicit&>(*bodies_used[id]).x;
    }
  }
  Coupler anew(fresh, share_of(bodies_fresh, rank(), ranks()), 4);
  for (int step = 0; step < 20; ++step) {
    coupler.step();
    anew.step();
    for (const Member& member : share_of(bodies_used, rank(), ranks())) {
      const auto a = member.body->positions();
      const auto b = bodies_fresh[static_cast<std::size_t>(member.id)]->positions();
      for (std::size_t n = 0; n < a.size(); ++n) ASSERT_EQ(a[n], b[n]) << step << ' ' << n;
    }
  }
  EXPECT_EQ(used.totals().momentum, fresh.totals().momentum);
}

TEST(Ranks, AFailureOnOneRankIsThrownOnAll) {
  fluid::Fluid fluid(MPI_COMM_WORLD, channel(whole_channel));
  auto list = bodies(whole_channel);
  int calls = 0;
  list[1] = std::make_unique<Explicit>(std::vector<double>{7, 7, 7}, [&](auto, auto) {
    if (++calls == 3) throw std::runtime_error("enough");
  });
  Coupler coupler(fluid, share_of(list, rank(), ranks()), 4);
  coupler.step();
  coupler.step();
  try {
    coupler.step();
    FAIL() << "no exception";
  } catch (const BodyFailure& failure) {
    EXPECT_EQ(failure.body(), 1);
    EXPECT_EQ(failure.reason(), "enough");
    EXPECT_EQ(failure.step(), 2);
  }
}

// Whatever it throws, and where a step has not begun: nobody waits for ever.
TEST(Ranks, WhatABodyThrowsIsEveryRanksToHearOf) {
  class Odd final : public coupling::Body {
   public:
    explicit Odd(bool at_once) : at_once_(at_once) {}
    [[nodiscard]] std::size_t marker_count() const override { return 1; }
    [[nodiscard]] std::span<const double> positions() const override {
      if (at_once_) throw std::runtime_error("nowhere");
      return x_;
    }
    [[nodiscard]] int corrections() const override { return 0; }
    void predict_force(std::span<double>) override { throw 1; }
    void correct_force(std::span<const double>, const coupling::Response&,
                       std::span<double>) override {}
    void advance(std::span<const double>) override {}

   private:
    bool at_once_;
    std::vector<double> x_ = {7, 7, 7};
  };
  for (const bool at_once : {true, false}) {
    fluid::Fluid fluid(MPI_COMM_WORLD, channel(whole_channel));
    auto list = bodies(whole_channel);
    list[1] = std::make_unique<Odd>(at_once);
    Coupler coupler(fluid, share_of(list, rank(), ranks()), 4);
    try {
      coupler.step();
      FAIL() << "no exception";
    } catch (const BodyFailure& failure) {
      EXPECT_EQ(failure.body(), 1);
      EXPECT_EQ(failure.reason(), at_once ? "nowhere" : "it throws no std::exception");
    }
  }
}

// What holds on a machine however busy: sleep_for() sleeps at least as long as it says, and laps
// that follow each other cannot add up to more than the time from before the first to after the
// last, by the same clock.
TEST(Profile, PartsAreOfTheStepAndASlowBodyIsFoundInItsPart) {
  fluid::Fluid fluid(MPI_COMM_WORLD, channel(whole_channel));
  auto list = bodies(whole_channel);
  constexpr std::chrono::milliseconds nap(5);
  list[1] = std::make_unique<Explicit>(std::vector<double>{7, 7, 7}, [&](auto, auto force) {
    std::this_thread::sleep_for(nap);
    std::fill(force.begin(), force.end(), 0.0);
  });
  Coupler coupler(fluid, share_of(list, rank(), ranks()), 4);
  EXPECT_EQ(coupler.profile().steps, 0);
  EXPECT_EQ(coupler.profile().total(), 0);
  coupler.step();
  coupler.reset_profile();
  EXPECT_EQ(coupler.profile().total(), 0);

  constexpr int steps = 10;
  const auto start = std::chrono::steady_clock::now();
  for (int n = 0; n < steps; ++n) coupler.step();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  const coupling::Profile& profile = coupler.profile();
  EXPECT_EQ(profile.steps, steps);
  for (const double seconds : profile.seconds) EXPECT_GE(seconds, 0);
  EXPECT_GT(profile[coupling::Part::fluid], 0);
  constexpr double round_off = 1e-12;  // some 200 additions of times under a second
  EXPECT_LE(profile.total(), elapsed.count() + round_off);
  const double asleep = std::chrono::duration<double>(steps * nap).count();
  if (rank() == 1 % ranks()) {
    EXPECT_GE(profile[coupling::Part::bodies], asleep - round_off);
  }
}

}  // namespace
