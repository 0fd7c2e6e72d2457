#include "ductile/coupling/coupler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "coupling/bodies.hpp"
#include "support/random_numbers.hpp"

namespace {

using namespace ductile;
using coupling::BodyFailure;
using coupling::Coupler;
using ductile::testing_support::random_numbers;
using test::Explicit;
using test::Held;
using test::ImplicitSpring;

fluid::Options box(int n) {
  fluid::Options o;
  o.nodes = {n, n, n};
  return o;
}

fluid::NodeState uniform(const Eigen::Vector3d& u) {
  fluid::NodeState s;
  s.velocity = u;
  return s;
}

TEST(Coupler, TracersMoveWithTheFluidRoundThePeriodicEnd) {
  fluid::Fluid fluid(MPI_COMM_SELF, box(12));
  const Eigen::Vector3d u(0.002, -0.001, 0.05);
  fluid.initialise([&](int, int, int) { return uniform(u); });
  Explicit tracers({5.2, 5.1, 10.9, 6.6, 6.9, 12.3}, nullptr);
  const std::vector<double> start = tracers.x;
  Coupler coupler(fluid, {{0, &tracers}}, 1);
  constexpr int steps = 300;  // more than once round
  for (int n = 0; n < steps; ++n) coupler.step();
  for (std::size_t n = 0; n < 6; ++n) {
    EXPECT_NEAR(tracers.x[n], start[n] + steps * u[static_cast<Eigen::Index>(n % 3)], 1e-10);
  }
  EXPECT_EQ(fluid.time(), steps);
  EXPECT_EQ(coupler.profile().bytes_sent, 0);
}

// The convention of the half force: the velocity that a marker moves with holds half of the force
// of the very step, so that one marker in a fluid at rest answers with (1/2 rho) (3/8)^3 F.
TEST(Coupler, MarkerVelocityHoldsHalfOfTheForceOfTheStep) {
  fluid::Fluid fluid(MPI_COMM_SELF, box(12));
  const std::array<double, 3> f = {1e-3, -2e-3, 5e-4};
  Explicit body({5.3, 6.7, 4.1},
                [&](auto, auto force) { std::copy(f.begin(), f.end(), force.begin()); });
  Coupler coupler(fluid, {{0, &body}}, 1);
  coupler.step();
  for (std::size_t n = 0; n < 3; ++n) {
    EXPECT_NEAR(body.velocity[n], 0.5 * std::pow(3.0 / 8.0, 3) * f[n], 1e-17);
  }
}

TEST(Coupler, FluidGainsTheBodiesForceAsMomentum) {
  fluid::Fluid fluid(MPI_COMM_SELF, box(14));
  const auto law = [](auto x, auto force) {
    for (std::size_t n = 0; n < force.size(); ++n)
      force[n] = 1e-4 * std::sin(7.0 * x[n] + static_cast<double>(n));
  };
  const std::vector<double> x = random_numbers(3 * 30, 3, 10, 1);
  Explicit one({x.begin(), x.begin() + 45}, law);
  Explicit two({x.begin() + 45, x.end()}, law);
  Coupler coupler(fluid, {{1, &two}, {0, &one}}, 2);
  Eigen::Vector3d expected = Eigen::Vector3d::Zero();
  for (int step = 0; step < 20; ++step) {
    std::vector<double> force(45);
    for (const Explicit* body : {&one, &two}) {
      law(std::span<const double>(body->x), std::span(force));
      for (std::size_t n = 0; n < 45; ++n) expected[static_cast<Eigen::Index>(n % 3)] += force[n];
    }
    coupler.step();
  }
  EXPECT_LT((fluid.totals().momentum - expected).norm(), 1e-14);
}

TEST(Coupler, BodiesFeelEachOtherWithinTheStep) {
  fluid::Fluid fluid(MPI_COMM_SELF, box(12));
  Explicit pusher({5.5, 5.5, 5.5}, [](auto, auto force) { force[2] = 1e-3; });
  Explicit tracer({6.5, 5.5, 5.5}, nullptr);
  Coupler coupler(fluid, {{0, &tracer}, {1, &pusher}}, 2);
  coupler.step();
  EXPECT_GT(tracer.velocity[2], 0);
  EXPECT_LT(tracer.velocity[2], pusher.velocity[2]);
}

TEST(Coupler, CorrectionsDriveTheSlipToZero) {
  std::vector<double> x;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) x.insert(x.end(), {4 + 1.5 * i, 4 + 1.5 * j, 6.3});
  }
  double last = 0;
  for (const int corrections : {0, 2, 4, 8, 16}) {
    fluid::Fluid fluid(MPI_COMM_SELF, box(14));
    fluid.initialise([](int, int, int) { return uniform({0, 0, 0.01}); });
    Held plate(x, corrections, 6.0);
    Coupler coupler(fluid, {{0, &plate}}, 1);
    coupler.step();
    double slip = 0;
    for (const double u : plate.velocity) slip = std::max(slip, std::abs(u));
    if (corrections == 0) {
      EXPECT_NEAR(slip, 0.01, 1e-15);
    } else {
      EXPECT_LT(slip, last);
    }
    last = slip;
  }
  EXPECT_LT(last, 0.05 * 0.01);
}

// The response that a solver sees is the one that the fluid then gives, so backward Euler holds to
// round-off and stays stable at any stiffness.
TEST(Coupler, ResponseIsTheFluidsOwn) {
  for (const double k : {1.0, 1e3, 1e6}) {
    fluid::Fluid fluid(MPI_COMM_SELF, box(12));
    ImplicitSpring spring({5.7, 6.2, 5.1}, {5.5, 6.0, 5.4}, k);
    Coupler coupler(fluid, {{0, &spring}}, 1);
    coupler.step();
    const double mobility = 0.5 * std::pow(3.0 / 8.0, 3);
    EXPECT_NEAR(spring.x[0] - 5.5, 0.2 / (1 + k * mobility), 1e-13);
    for (int n = 0; n < 500; ++n) coupler.step();
    for (const double c : {spring.x[0] - 5.5, spring.x[1] - 6.0, spring.x[2] - 5.4}) {
      EXPECT_LT(std::abs(c), 0.01);
    }
  }
}

// Exerts forces in a first correction, and remembers what the response says of them and what the
// fluid tells.
class Asking final : public coupling::Body {
 public:
  Asking(std::vector<double> start, std::vector<double> force)
      : x_(std::move(start)), force_(std::move(force)), expected(x_.size()) {}
  [[nodiscard]] std::size_t marker_count() const override { return x_.size() / 3; }
  [[nodiscard]] std::span<const double> positions() const override { return x_; }
  [[nodiscard]] int corrections() const override { return 1; }
  void predict_force(std::span<double>) override {}
  void correct_force(std::span<const double> u, const coupling::Response& response,
                     std::span<double> increment) override {
    response.apply(force_, expected);
    for (std::size_t n = 0; n < u.size(); ++n) expected[n] += u[n];
    std::copy(force_.begin(), force_.end(), increment.begin());
  }
  void advance(std::span<const double> u) override { told.assign(u.begin(), u.end()); }

 private:
  std::vector<double> x_;
  std::vector<double> force_;

 public:
  std::vector<double> expected;
  std::vector<double> told;
};

// Also of markers that are not symmetric about a mirror plane, across it or near it on one side.
TEST(Coupler, ResponseIsTheFluidsOwnAtAMirrorPlane) {
  for (const fluid::Mirror mirror :
       {fluid::Mirror::none, fluid::Mirror::between_nodes, fluid::Mirror::on_node}) {
    fluid::Options o = box(14);
    o.boundary[1] = fluid::Boundary::halfway;
    o.mirror = mirror;
    for (const auto& [low, high] :
         {std::pair(-3.0, 4.0), std::pair(0.2, 4.0), std::pair(-4.0, -0.6)}) {
      const double y = mirror == fluid::Mirror::none ? 6 : 0;
      std::vector<double> x = random_numbers(3 * 50, 4, 9, 1);
      const std::vector<double> across = random_numbers(50, y + low, y + high, 2);
      for (std::size_t m = 0; m < 50; ++m) x[3 * m + 1] = across[m];
      fluid::Fluid fluid(MPI_COMM_SELF, o);
      Asking body(x, random_numbers(x.size(), -1e-3, 1e-3, 3));
      Coupler coupler(fluid, {{0, &body}}, 1);
      coupler.step();
      for (std::size_t n = 0; n < x.size(); ++n)
        ASSERT_NEAR(body.told[n], body.expected[n], 1e-17) << low << ' ' << high << ' ' << n;
    }
  }
}

// A body that leaves a mirror plane on one side has an image on the other, which it feels.
TEST(Coupler, ABodyBesideAMirrorPlaneMeetsItsImage) {
  constexpr std::size_t markers = 40;
  const auto law = [](double plane, double sign) {
    return [=](std::span<const double> x, std::span<double> force) {
      for (std::size_t n = 0; n < x.size(); n += 3) {
        force[n] = 1e-3 * std::sin(x[n]);
        force[n + 1] = sign * 1e-3 * std::cos(x[n + 2] + sign * (x[n + 1] - plane));
        force[n + 2] = 2e-3 * std::cos(x[n]);
      }
    };
  };
  const std::vector<double> cloud = random_numbers(3 * markers, 0.4, 3, 9);
  const auto at = [&](double y, double sign) {
    std::vector<double> x = cloud;
    for (std::size_t n = 0; n < x.size(); n += 3) {
      x[n] += 4;
      x[n + 1] = y + sign * x[n + 1];
      x[n + 2] += 4;
    }
    return x;
  };
  for (const fluid::Mirror mirror : {fluid::Mirror::between_nodes, fluid::Mirror::on_node}) {
    const bool between = mirror == fluid::Mirror::between_nodes;
    fluid::Options half = box(12);
    half.nodes[1] = 7;
    half.boundary[1] = fluid::Boundary::halfway;
    fluid::Options whole = half;
    half.mirror = mirror;
    whole.nodes[1] = between ? 14 : 13;
    const double low = between ? -0.5 : 0;
    const double middle = 0.5 * (whole.nodes[1] - 1);
    fluid::Fluid half_fluid(MPI_COMM_SELF, half);
    fluid::Fluid whole_fluid(MPI_COMM_SELF, whole);
    Explicit alone(at(low, 1), law(low, 1));
    Explicit body(at(middle, 1), law(middle, 1));
    Explicit image(at(middle, -1), law(middle, -1));
    Coupler in_half(half_fluid, {{0, &alone}}, 1);
    Coupler in_whole(whole_fluid, {{0, &body}, {1, &image}}, 2);
    double fastest = 0;
    for (int step = 0; step < 20; ++step) {
      in_half.step();
      in_whole.step();
      for (std::size_t n = 0; n < alone.x.size(); ++n) {
        ASSERT_NEAR(alone.velocity[n], body.velocity[n], 1e-15) << step << ' ' << n;
        fastest = std::max(fastest, std::abs(body.velocity[n]));
      }
    }
    EXPECT_GT(fastest, 1e-3);
  }
}

TEST(Coupler, ExplicitAndCorrectedBodiesMix) {
  fluid::Fluid fluid(MPI_COMM_SELF, box(16));
  fluid.initialise([](int, int, int) { return uniform({0, 0, 0.01}); });
  Explicit tracer({4, 4, 4}, nullptr);
  Held held({11.2, 11.3, 11.4}, 3, 5);
  Coupler coupler(fluid, {{0, &tracer}, {1, &held}}, 2);
  coupler.step();
  EXPECT_NEAR(tracer.velocity[2], 0.01, 1e-15);
  EXPECT_LT(held.velocity[2], 0.01);
}

// Bodies that are symmetric about a plane move in half of a symmetric fluid, on a mirror plane, as
// in the whole; their markers are on both sides.
TEST(Coupler, BodiesInHalfASymmetricFluidMoveAsInTheWhole) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> offset(-2.2, 2.2);
  std::vector<double> cloud;  // about the plane at y = 0
  for (int m = 0; m < 40; ++m) {
    const Eigen::Vector3d r(offset(random), offset(random), offset(random));
    cloud.insert(cloud.end(), {r.x(), r.y(), r.z(), r.x(), -r.y(), r.z()});
  }
  const auto at = [&](double x, double y, double z) {
    std::vector<double> moved = cloud;
    for (std::size_t n = 0; n < moved.size(); n += 3) {
      moved[n] += x;
      moved[n + 1] += y;
      moved[n + 2] += z;
    }
    return moved;
  };
  for (const fluid::Mirror mirror : {fluid::Mirror::between_nodes, fluid::Mirror::on_node}) {
    const bool between = mirror == fluid::Mirror::between_nodes;
    fluid::Options half;
    half.nodes = {13, 8, 20};
    half.boundary = {fluid::Boundary::halfway, fluid::Boundary::halfway, fluid::Boundary::periodic};
    half.force = {0, 0, 2e-4};
    half.mirror = mirror;
    fluid::Options whole = half;
    whole.mirror = fluid::Mirror::none;
    whole.nodes[1] = between ? 16 : 15;
    const double plane = between ? -0.5 : 0;
    std::vector<std::vector<double>> results;
    for (const fluid::Options& options : {half, whole}) {
      const double y = options.mirror == mirror ? plane : 0.5 * (options.nodes[1] - 1);
      fluid::Fluid fluid(MPI_COMM_SELF, options);
      const auto squeeze = [&](std::span<const double> x, std::span<double> force) {
        for (std::size_t n = 0; n < x.size(); n += 3) {
          force[n] = 1e-4 * std::sin(x[n]);
          force[n + 1] = -2e-4 * (x[n + 1] - y);
          force[n + 2] = 1e-4 * std::cos(x[n]);
        }
      };
      Explicit loose(at(6.3, y, 4.6), squeeze);
      Held held(at(6.9, y, 13.2), 3, 0.3);
      Coupler coupler(fluid, {{0, &loose}, {1, &held}}, 2);
      for (int step = 0; step < 60; ++step) coupler.step();
      for (const std::vector<double>* found : {&loose.x, &loose.velocity, &held.velocity})
        results.push_back(*found);
      for (std::size_t n = 1; n < results[results.size() - 3].size(); n += 3)
        results[results.size() - 3][n] -= y;
    }
    for (std::size_t kind = 0; kind < 3; ++kind) {
      for (std::size_t n = 0; n < cloud.size(); ++n)
        ASSERT_NEAR(results[kind][n], results[3 + kind][n], 1e-13) << kind << ' ' << n;
    }
  }
}

TEST(Coupler, NamesTheBodyThatFails) {
  fluid::Fluid fluid(MPI_COMM_SELF, box(16));
  int calls = 0;
  Explicit good({4, 4, 4}, nullptr);
  Explicit bad({11, 11, 11}, [&](auto, auto) {
    if (++calls == 3) throw coupling::MarkerError(0, "marker 0 has had enough");
  });
  Coupler coupler(fluid, {{0, &good}, {1, &bad}}, 2);
  coupler.step();
  coupler.step();
  try {
    coupler.step();
    FAIL() << "no exception";
  } catch (const BodyFailure& failure) {
    EXPECT_EQ(failure.body(), 1);
    EXPECT_EQ(failure.marker(), 0U);
    EXPECT_EQ(failure.step(), 2);
    EXPECT_EQ(failure.reason(), "marker 0 has had enough");
  }
}

TEST(Coupler, RefusesMarkersThatReachAWall) {
  fluid::Options o = box(16);
  o.boundary = {fluid::Boundary::regularized, fluid::Boundary::halfway, fluid::Boundary::periodic};
  const auto failure = [&](std::vector<double> x) -> std::string {
    fluid::Fluid fluid(MPI_COMM_SELF, o);
    Explicit body(std::move(x), nullptr);
    Coupler coupler(fluid, {{0, &body}}, 1);
    try {
      coupler.step();
    } catch (const BodyFailure& error) {
      return (error.cause() == BodyFailure::Cause::boundary ? "boundary: " : "body: ") +
             error.reason();
    }
    return "";
  };
  EXPECT_EQ(failure({2.0, 1.0, 0.0}), "");
  EXPECT_EQ(failure({1.9, 8, 8}),
            "boundary: marker 0 is 1.9 lattice spacings from the wall at the low end of x, under "
            "the 2 that the 4-point kernel needs");
  EXPECT_EQ(failure({8, 0.9, 8}),
            "boundary: marker 0 is 1.4 lattice spacings from the wall at the low end of y, under "
            "the 1.5 that the 4-point kernel needs");
  EXPECT_EQ(failure({8, 14.1, 8}),
            "boundary: marker 0 is 1.4 lattice spacings from the wall at the high end of y, under "
            "the 1.5 that the 4-point kernel needs");
  EXPECT_EQ(failure({8, NAN, 8}), "body: the position of marker 0 is not finite");
  // The wall of a half and its image.
  o.mirror = fluid::Mirror::between_nodes;
  EXPECT_EQ(failure({8, 14.1, 8}),
            "boundary: marker 0 is 1.4 lattice spacings from the wall at the high end of y, under "
            "the 1.5 that the 4-point kernel needs");
  EXPECT_EQ(failure({8, -15.1, 8}),
            "boundary: marker 0 is 1.4 lattice spacings from the wall at the low end of y, under "
            "the 1.5 that the 4-point kernel needs");
}

TEST(Coupler, RejectsIdsThatDoNotNumberTheBodies) {
  fluid::Fluid fluid(MPI_COMM_SELF, box(8));
  Explicit a({4, 4, 4}, nullptr);
  Explicit b({4, 4, 4}, nullptr);
  EXPECT_THROW(Coupler(fluid, {{0, &a}, {0, &b}}, 2), std::invalid_argument);
  EXPECT_THROW(Coupler(fluid, {{0, &a}, {2, &b}}, 2), std::invalid_argument);
  EXPECT_THROW(Coupler(fluid, {{0, &a}}, 2), std::invalid_argument);
}

TEST(Coupler, RefusesBodiesWithoutMarkers) {
  fluid::Fluid fluid(MPI_COMM_SELF, box(8));
  Explicit a({4, 4, 4}, nullptr);
  Explicit none({}, nullptr);
  EXPECT_THROW(Coupler(fluid, {{0, &a}, {1, &none}}, 2), std::invalid_argument);
  EXPECT_THROW(Coupler(fluid, {{0, nullptr}}, 1), std::invalid_argument);
}

// Its arrays are made for those that it has at first.
TEST(Coupler, FailsWhereABodyGetsOtherMarkers) {
  fluid::Fluid fluid(MPI_COMM_SELF, box(8));
  Explicit body({4, 4, 4}, nullptr);
  Coupler coupler(fluid, {{0, &body}}, 1);
  coupler.step();
  body.x = {4, 4, 4, 5, 5, 5};
  coupler.bodies_replaced();
  try {
    coupler.step();
    FAIL() << "no exception";
  } catch (const BodyFailure& failure) {
    EXPECT_EQ(failure.reason(), "it has 2 markers now, and had 1");
  }
}

// A body as long as its channel, whose box is the whole ring, goes round it as if its box were laid
// anew in every step.
TEST(Coupler, ABodyAsLongAsItsChannelGoesRound) {
  fluid::Options o = box(12);
  std::array<std::vector<double>, 2> seen;
  for (const bool anew : {false, true}) {
    fluid::Fluid fluid(MPI_COMM_SELF, o);
    fluid.initialise([](int, int, int) { return uniform({0, 0, 0.08}); });
    Explicit body({6.1, 5.8, 1.3, 6.4, 6.2, 5.1, 5.9, 6.3, 9.2}, [](auto x, auto force) {
      for (std::size_t n = 0; n < 3; ++n) {
        force[3 + n] = 1e-4 * (x[n] + x[6 + n] - 2 * x[3 + n]);
        force[n] = force[6 + n] = -0.5 * force[3 + n];
      }
    });
    Coupler coupler(fluid, {{0, &body}}, 1);
    for (int n = 0; n < 200; ++n) {
      if (anew) coupler.bodies_replaced();
      coupler.step();
    }
    seen[anew ? 1 : 0] = body.x;
    EXPECT_GT(body.x[2], 13);
  }
  EXPECT_EQ(seen[0], seen[1]);
}

// A fluid that starts again, its lattice where it was then, meets the bodies where they are.
TEST(Coupler, FindsBodiesOnALatticeThatWasSetBack) {
  fluid::Options o = box(24);
  o.lattice_velocity = 0.05;
  std::array<std::vector<double>, 2> seen;
  for (const bool begun : {false, true}) {
    fluid::Fluid fluid(MPI_COMM_SELF, o);
    Held body({12, 12, 12}, 1, 0.1);
    Coupler coupler(fluid, {{0, &body}}, 1);
    if (begun) {
      for (int n = 0; n < 100; ++n) coupler.step();
    }
    fluid.initialise([](int i, int, int k) { return uniform({0, 0, 1e-3 * (k - i)}); });
    for (int n = 0; n < 3; ++n) coupler.step();
    seen[begun ? 1 : 0] = body.velocity;
  }
  EXPECT_EQ(seen[0], seen[1]);
}

}  // namespace
