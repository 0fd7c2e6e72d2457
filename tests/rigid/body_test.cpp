// Rigid bodies in hand-written fluids of a few lines.
#include "ductile/rigid/body.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "ductile/surface/biconcave.hpp"
#include "ductile/surface/sphere.hpp"

namespace {

using ductile::rigid::Body;
using ductile::rigid::least_density_ratio;
using ductile::rigid::lined;
using ductile::rigid::lined_marker_count;
using ductile::rigid::markers_of;
using ductile::rigid::Motion;
using ductile::rigid::MotionFailure;
using ductile::rigid::Options;
using ductile::rigid::Solid;
using ductile::rigid::solid_of;
using ductile::rigid::State;
using ductile::rigid::StateReader;
using ductile::rigid::Surface;
using ductile::surface::Sphere;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;
constexpr double eps = std::numeric_limits<double>::epsilon();
// Eigenvalue of the 4-point kernel's answer to a smooth force on a surface.
constexpr double lambda = 0.381;

// Spiral of n points: well spread, and without symmetry, so that no sum vanishes by itself.
Surface spiral(double radius, std::size_t n) {
  Surface surface;
  for (std::size_t m = 0; m < n; ++m) {
    const double z = 1 - (2 * static_cast<double>(m) + 1) / static_cast<double>(n);
    const double phi = pi * (3 - std::sqrt(5.0)) * static_cast<double>(m);
    const double s = std::sqrt(1 - z * z);
    surface.markers.emplace_back(radius * s * std::cos(phi), radius * s * std::sin(phi),
                                 radius * z);
  }
  surface.areas.assign(n, 4 * pi * radius * radius / static_cast<double>(n));
  return surface;
}

// The cube's corners, face centres and edge centres on the sphere: the symmetry of the cube makes
// odd sums vanish and second moments isotropic.
Surface cubic(double radius) {
  Surface surface;
  for (const int x : {-1, 0, 1}) {
    for (const int y : {-1, 0, 1}) {
      for (const int z : {-1, 0, 1}) {
        if (x != 0 || y != 0 || z != 0)
          surface.markers.push_back(radius * Vector3d(x, y, z).normalized());
      }
    }
  }
  surface.areas.assign(surface.markers.size(), 4 * pi * radius * radius / 26);
  return surface;
}

Solid ball(double radius) {
  return solid_of(Sphere(radius));
}

// An ellipsoid's solid, and markers on it.
Solid ellipsoid(const Vector3d& axes) {
  const double volume = 4.0 / 3 * pi * axes.prod();
  const Vector3d squares = axes.cwiseAbs2();
  return {volume,
          volume / 5 * (Vector3d::Constant(squares.sum()) - squares).asDiagonal().toDenseMatrix()};
}
Surface ellipsoid_surface(const Vector3d& axes, std::size_t n) {
  Surface surface = spiral(1, n);
  for (Vector3d& r : surface.markers) r = r.cwiseProduct(axes);
  for (double& area : surface.areas) area *= std::pow(axes.prod(), 2.0 / 3);
  return surface;
}

double total(const std::vector<double>& areas) {
  double sum = 0;
  for (const double a : areas) sum += a;
  return sum;
}

// What the markers gave to the fluid in a step.
struct Impulse {
  std::vector<Vector3d> forces;
  Vector3d force = Vector3d::Zero();
  Vector3d torque = Vector3d::Zero();  // about the body's centre
};

// One step of the coupling. fluid(positions, forces) is the velocities of all markers with the
// forces so far.
using Vectors = std::vector<Vector3d>;

Vectors vectors(std::span<const double> values) {
  Vectors list;
  for (std::size_t i = 0; i < values.size(); i += 3)
    list.emplace_back(values[i], values[i + 1], values[i + 2]);
  return list;
}

template <class Fluid>
Impulse step(Body& body, const Fluid& fluid) {
  const std::size_t n = body.marker_count();
  const Vectors x = vectors(body.positions());
  const Vector3d centre = body.state().position;
  std::vector<double> force(3 * n, 1.0), velocity(3 * n), increment(3 * n);
  const auto ask = [&] {
    const Vectors u = fluid(x, vectors(force));
    for (std::size_t m = 0; m < n; ++m) Eigen::Map<Vector3d>(velocity.data() + 3 * m) = u[m];
  };
  body.predict_force(force);
  for (int k = 0; k < body.corrections(); ++k) {
    ask();
    body.correct_force(velocity, increment);
    for (std::size_t i = 0; i < 3 * n; ++i) force[i] += increment[i];
  }
  ask();
  body.advance(velocity);

  Impulse impulse;
  impulse.forces = vectors(force);
  for (std::size_t m = 0; m < n; ++m) {
    impulse.force += impulse.forces[m];
    impulse.torque += (x[m] - centre).cross(impulse.forces[m]);
  }
  return impulse;
}

// A fluid that answers a force at each marker on its own, with the kernel's eigenvalue.
template <class Flow>
auto local_fluid(const Surface& surface, Flow flow) {
  return [&surface, flow](const Vectors& x, const Vectors& forces) {
    Vectors u;
    for (std::size_t m = 0; m < x.size(); ++m)
      u.emplace_back(flow(x[m]) + lambda / (2 * surface.areas[m]) * forces[m]);
    return u;
  };
}

// Fluid of some mass that moves as one, with half of the step's force in its velocity, as Guo's
// forcing has it.
struct Lump {
  double mass;
  Vector3d momentum = Vector3d::Zero();

  Vectors operator()(const Vectors& x, const Vectors& forces) const {
    Vector3d force = Vector3d::Zero();
    for (const Vector3d& f : forces) force += f;
    return Vectors(x.size(), (momentum + 0.5 * force) / mass);
  }
};

TEST(RigidShape, BallHasAnalyticVolumeAndInertia) {
  const Solid solid = ball(3);
  EXPECT_DOUBLE_EQ(solid.volume, 36 * pi);
  EXPECT_NEAR((solid.inertia - 0.4 * 36 * pi * 9 * Matrix3d::Identity()).norm(), 0, 1e-12);
}

TEST(RigidShape, SolidAndMarkersAreThoseOfAShapeAndItsMesh) {
  const ductile::surface::Biconcave cell(3);
  const Solid solid = solid_of(cell);
  EXPECT_EQ(solid.volume, cell.volume());
  EXPECT_EQ(solid.inertia, cell.inertia());
  const auto mesh = cell.mesh(6, -0.3);
  const Surface surface = markers_of(mesh);
  EXPECT_EQ(surface.markers, mesh.vertices);
  EXPECT_NEAR(total(surface.areas), area(mesh), 1e-12);
  EXPECT_NO_THROW(Body(surface, solid, {}, {}));
}

class Corrections : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(One2Five, Corrections, ::testing::Values(1, 2, 5));

TEST_P(Corrections, NeutralBodyTakesTheFlowsRigidMotionWithoutForce) {
  const Vector3d u0(0.02, -0.01, 0.03), spin(1e-3, 4e-3, -2e-3);
  const Surface surface = spiral(4, 150);
  Options options;
  options.corrections = GetParam();
  State start;
  start.position = {10, 11, 12};
  start.velocity = {-0.1, 0.2, 0.1};  // forgotten at once: there is no inertia of its own
  Body body(surface, ball(4), options, start);
  for (int n = 0; n < 20; ++n) {
    const Vector3d x = body.state().position;
    const Impulse impulse =
        step(body,
             local_fluid(surface, [&](const Vector3d& y) { return Vector3d(u0 + spin.cross(y)); }));
    EXPECT_LT((body.state().velocity - (u0 + spin.cross(x))).norm(), 100 * eps);
    EXPECT_LT((body.state().angular_velocity - spin).norm(), 100 * eps);
    for (const Vector3d& f : impulse.forces) EXPECT_LT(f.norm(), 1000 * eps);
    EXPECT_LT(body.slip().max, 100 * eps);
  }
}

// A surface that misses b of the fluid's answer along it.
Surface missing(Surface surface, double b) {
  for (const Vector3d& r : surface.markers) surface.normals.push_back(r.normalized());
  surface.missed = b;
  return surface;
}

// In a straining flow a body as dense as the fluid feels neither force nor torque, in any step.
void expect_balance(const Options& options) {
  for (const double b : {0.0, 0.1, 2.0}) {
    const Surface surface = missing(ellipsoid_surface({6, 4, 3}, 150), b);
    State start;
    start.orientation = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized());
    Body body(surface, ellipsoid({6, 4, 3}), options, start);
    for (int n = 0; n < 20; ++n) {
      const Impulse impulse =
          step(body, local_fluid(surface, [](const Vector3d& y) {
                 return Vector3d(0.01 * y.z(), 0.002 * y.x() * y.y(), 0.02 + 0.005 * y.x());
               }));
      double largest = 0;
      for (const Vector3d& f : impulse.forces) largest = std::max(largest, f.norm());
      ASSERT_GT(largest, 1e-3);
      // Round-off of the sums of 2 kappa A u, over velocities up to 0.1 and arms up to 6; a memory
      // passes on no more than it was given.
      const double round_off = 10 * eps * 4 * total(surface.areas) * 0.1;
      EXPECT_LT(impulse.force.norm(), round_off) << b;
      EXPECT_LT(impulse.torque.norm(), 6 * round_off) << b;
    }
  }
}

TEST_P(Corrections, NeutralBodyFeelsNoForceOrTorqueInAStrainingFlow) {
  Options options;
  options.corrections = GetParam();
  expect_balance(options);
}

TEST(RigidBody, NeutralSphereInShearTurnsWithHalfTheVorticity) {
  const Surface surface = cubic(5);
  State start;
  start.position = {0, 0, 2};
  Body body(surface, ball(5), {}, start);
  step(body, local_fluid(surface, [](const Vector3d& y) { return Vector3d(0.01 * y.z(), 0, 0); }));
  EXPECT_LT((body.state().velocity - Vector3d(0.02, 0, 0)).norm(), 100 * eps);
  EXPECT_LT((body.state().angular_velocity - Vector3d(0, 0.005, 0)).norm(), 100 * eps);
}

// F/A = V_n 2/lambda + V_t/(lambda/2 + b): the fluid gives what the force is worth, and what is
// missed of it besides.
TEST(RigidBody, TheFluidThatThereWouldBeDoesNotSlip) {
  const Vector3d velocity(0.01, -0.02, 0.005), spin(1e-3, 2e-3, 0);
  for (const double b : {0.02, 0.3, 3.0, 1000.0}) {
    const Surface surface = missing(spiral(5, 200), b);
    Options options;
    options.motion = Motion::prescribed;
    options.corrections = 60;
    Body body(surface, ball(5), options, {});
    body.prescribe(velocity, spin);
    const Impulse impulse =
        step(body, local_fluid(surface, [](const Vector3d&) { return Vector3d(0, 0, 0); }));
    for (std::size_t m = 0; m < surface.markers.size(); ++m) {
      const Vector3d v = velocity + spin.cross(surface.markers[m]);
      const Vector3d normal = surface.normals[m].dot(v) * surface.normals[m];
      const Vector3d law =
          surface.areas[m] * (normal * 2 / lambda + (v - normal) / (lambda / 2 + b));
      EXPECT_LT((impulse.forces[m] - law).norm(), 1e-9 * law.norm() + 1e-15) << b;
    }
    EXPECT_LT(body.slip().max, 1e-9) << b;
  }
}

TEST(RigidBody, WhatIsMissedIsCheckedWithItsNormals) {
  Surface none = missing(spiral(5, 50), 0.1);
  none.normals.clear();
  EXPECT_THROW(Body(none, ball(5), {}, {}), std::invalid_argument);
  Surface many = missing(spiral(5, 50), 0.1);
  many.normals.emplace_back(1, 0, 0);
  EXPECT_THROW(Body(many, ball(5), {}, {}), std::invalid_argument);
  Surface longer = missing(spiral(5, 50), 0.1);
  longer.normals[7] *= 1.1;
  EXPECT_THROW(Body(longer, ball(5), {}, {}), std::invalid_argument);
  for (const double b : {-0.1, static_cast<double>(NAN)})
    EXPECT_THROW(Body(missing(spiral(5, 50), b), ball(5), {}, {}), std::invalid_argument);
}

class Relaxation : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(HalfToFastest, Relaxation, ::testing::Values(0.5, 1.0, 2.0, 2.6));

TEST_P(Relaxation, SlipShrinksByOneMinusKappaLambdaEachTime) {
  const double kappa = GetParam();
  const Surface surface = spiral(5, 200);
  // What no rigid motion can take up: strain.
  const auto strain = [](const Vector3d& y) { return Vector3d(0.01 * y.x(), -0.01 * y.y(), 0); };
  const auto slip_after = [&](int corrections) {
    Options options;
    options.relaxation = kappa;
    options.corrections = corrections;
    Body body(surface, ball(5), options, {});
    step(body, local_fluid(surface, strain));
    return body.slip();
  };
  const auto one = slip_after(1);
  // The first step's slip too is known: strain is all of it, but for the spiral's small asymmetry.
  EXPECT_NEAR(one.max, 0.05 * std::abs(1 - kappa * lambda), 0.01 * 0.05);
  for (const int k : {2, 3, 5}) {
    const double rate = std::pow(std::abs(1 - kappa * lambda), k - 1);
    EXPECT_NEAR(slip_after(k).rms, rate * one.rms, 100 * eps * 0.05) << k;
    EXPECT_NEAR(slip_after(k).max, rate * one.max, 100 * eps * 0.05) << k;
  }
}

TEST_P(Relaxation, SlipOfTheBodyItselfShrinksByThePredictedRate) {
  // A body that lags behind a uniform flow: (1 - kappa lambda)(M - M_f)/(2 kappa A + M - M_f).
  const double kappa = GetParam(), a = 4;
  const Surface surface = cubic(a);
  for (const double ratio : {0.8, 5.0}) {
    const double excess = (ratio - 1) * ball(a).volume;
    const double k = 2 * kappa * total(surface.areas);
    const double rate = (1 - kappa * lambda) * excess / (k + excess);
    for (const int corrections : {1, 2, 4}) {
      Options options;
      options.density_ratio = ratio;
      options.relaxation = kappa;
      options.corrections = corrections;
      Body body(surface, ball(a), options, {});
      step(body, local_fluid(surface, [](const Vector3d&) { return Vector3d(0.1, 0, 0); }));
      // Without any force, U - u = -0.1; the first answer brings in K and the rest follows.
      const double expected = 0.1 * std::abs(excess / (k + excess)) * std::abs(1 - kappa * lambda) *
                              std::pow(std::abs(rate), corrections - 1);
      EXPECT_NEAR(body.slip().max, expected, 1000 * eps) << ratio << ' ' << corrections;
    }
  }
}

class DensityRatio : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(HalfToFive, DensityRatio, ::testing::Values(0.5, 0.8, 1.0, 1.2, 2.0, 5.0));

TEST_P(DensityRatio, FallsAlongWithAFluidThatFallsToo) {
  // No slip, no force: (M - M_f) U' = (M - M_f) g for every density, over and over.
  const Surface surface = spiral(4, 100);
  Options options;
  options.density_ratio = GetParam();
  options.gravity = {1e-4, 0, -2e-4};
  Body body(surface, ball(4), options, {});
  Vector3d x = Vector3d::Zero();
  for (int n = 1; n <= 100; ++n) {
    const Vector3d u = n * options.gravity;
    const auto uniform = [&u](const Vector3d&) { return Vector3d(u); };
    const Impulse impulse = step(body, local_fluid(surface, uniform));
    x += u;
    EXPECT_LT((body.state().velocity - u).norm(), 100 * eps);
    EXPECT_LT(impulse.force.norm(), 1e-11);
    // The fluid carries the body as it would the fluid in the body's place.
    EXPECT_LT((body.hydrodynamic_force() - ball(4).volume * options.gravity).norm(), 1e-11);
  }
  EXPECT_LT((body.state().position - x).norm(), 1e-13);
}

TEST_P(DensityRatio, AcceleratesWithItsAddedMass) {
  // The fluid inside and half as much again outside, as of a sphere in potential flow, and of the
  // radius for which it answers with the kernel's eigenvalue, m = A/lambda = 3/2 M_f.
  const double ratio = GetParam(), a = 2 / lambda, g = 1e-4;
  const Surface surface = spiral(a, 150);
  const double volume = ball(a).volume;
  Options options;
  options.density_ratio = ratio;
  options.gravity = {0, 0, g};
  options.corrections = 40;
  Body body(surface, ball(a), options, {});
  Lump lump{1.5 * volume};
  double before = 0;
  for (int n = 1; n <= 60; ++n) {
    before = body.state().velocity.z();
    lump.momentum += step(body, lump).force;
  }
  const double acceleration = (ratio - 1) / (ratio + 0.5) * g;
  EXPECT_NEAR(body.state().velocity.z() - before, acceleration, 1e-10 * g);
  // Force of the fluid outside: minus the added mass times the acceleration.
  EXPECT_NEAR(body.hydrodynamic_force().z(), -0.5 * volume * acceleration, 1e-9 * volume * g);
}

TEST_P(DensityRatio, ApproachesThatAccelerationByThePredictedRate) {
  // Between steps, with m = M - M_f: m (U' - U - g) = -F' and m_a (U' - U) = (F + F')/2, so that F
  // is a fixed-point iteration of rate -m/(2 m_a + m).
  const double ratio = GetParam(), a = 2 / lambda, g = 1e-4;
  const Surface surface = spiral(a, 150);
  const double m = (ratio - 1) * ball(a).volume, m_a = 1.5 * ball(a).volume;
  Options options;
  options.density_ratio = ratio;
  options.gravity = {0, 0, g};
  options.corrections = 40;
  Body body(surface, ball(a), options, {});
  Lump lump{m_a};
  const double final_force = m_a * m / (m_a + m) * g;
  double deviation = 0;
  for (int n = 0; n < 4; ++n) {
    const Vector3d force = step(body, lump).force;
    lump.momentum += force;
    if (n > 0) {
      EXPECT_NEAR(force.z() - final_force, -m / (2 * m_a + m) * deviation, 1e-10 * m_a * g);
    }
    deviation = force.z() - final_force;
  }
}

TEST_P(DensityRatio, MomentumOfBodyAndFluidGrowsByTheExcessWeightAlone) {
  // In every step, however few corrections.
  const double ratio = GetParam(), a = 6;
  const Surface surface = spiral(a, 150);
  Options options;
  options.density_ratio = ratio;
  options.gravity = {0, 3e-5, 1e-4};
  options.corrections = 2;
  State start;
  start.velocity = {0.01, 0, 0};
  Body body(surface, ball(a), options, start);
  const double excess = (ratio - 1) * ball(a).volume;
  Lump lump{1.5 * ball(a).volume};
  for (int n = 1; n <= 50; ++n) {
    lump.momentum += step(body, lump).force;
    const Vector3d momentum = excess * body.state().velocity + lump.momentum;
    const Vector3d expected = excess * (start.velocity + n * options.gravity);
    EXPECT_LT((momentum - expected).norm(), 1e-12 * ball(a).volume) << n;
  }
}

// What a film exerts in a step goes on to body and fluid together, and is part of what the body
// tells of the fluid's force; the next step has none of it.
TEST_P(DensityRatio, AFilmsForceIsOfItsStepAlone) {
  const double ratio = GetParam(), a = 6;
  const Surface surface = spiral(a, 150);
  Options options;
  options.density_ratio = ratio;
  options.corrections = 2;
  options.memory = 0.5;
  Body body(surface, ball(a), options, {});
  const double excess = (ratio - 1) * ball(a).volume;
  const double inertia = (ratio - 1) * ball(a).inertia(0, 0);
  const auto fluid = local_fluid(surface, [](const Vector3d&) { return Vector3d(0, 0, 0); });
  const Vector3d film(0.2, -0.1, 0.3), turn(0.3, 0.1, 0.2);
  Vector3d velocity = Vector3d::Zero(), spin = Vector3d::Zero();
  for (const double share : {0.0, 1.0, 2.0, 0.0}) {
    if (share > 0) {
      body.set_film_force({1, 1, 1}, {1, 1, 1});  // the last word counts
      body.set_film_force(share * film, share * turn);
    }
    const Impulse impulse = step(body, fluid);
    const Vector3d change = body.state().velocity - velocity;
    const Vector3d turned = body.state().angular_velocity - spin;
    EXPECT_LT((excess * change + impulse.force - share * film).norm(), 1e-11);
    EXPECT_LT((inertia * turned + impulse.torque - share * turn).norm(), 1e-10);
    // Force of the fluid on the solid: its mass times its acceleration, there being no weight.
    EXPECT_LT((ratio * ball(a).volume * change - body.hydrodynamic_force()).norm(), 1e-10);
    EXPECT_LT((ratio * ball(a).inertia(0, 0) * turned - body.hydrodynamic_torque()).norm(), 1e-9);
    velocity = body.state().velocity;
    spin = body.state().angular_velocity;
    EXPECT_GE(velocity.norm(), 1e-5 * share);
  }
  // What is loaded has none.
  std::map<std::string, std::vector<double>, std::less<>> store;
  body.save([&](std::string_view name, std::span<const double> numbers) {
    store[std::string(name)].assign(numbers.begin(), numbers.end());
  });
  body.set_film_force(film, turn);
  body.load([&](std::string_view name, std::span<double> numbers) {
    std::ranges::copy(store.find(name)->second, numbers.begin());
  });
  const Impulse impulse = step(body, fluid);
  EXPECT_LT((excess * (body.state().velocity - velocity) + impulse.force).norm(), 1e-11);
  EXPECT_THROW(body.set_film_force({0, 0, NAN}, turn), std::invalid_argument);
  EXPECT_THROW(body.set_film_force(film, {INFINITY, 0, 0}), std::invalid_argument);
}

struct Remembering {
  double memory;
  int corrections;
};
class Memory : public ::testing::TestWithParam<Remembering> {};
INSTANTIATE_TEST_SUITE_P(FromNoneToMost, Memory,
                         ::testing::Values(Remembering{0, 2}, Remembering{0.5, 1},
                                           Remembering{0.9, 1}, Remembering{0.9, 2},
                                           Remembering{0.95, 3}));

TEST_P(Memory, SlipOfASteadyFlowFallsStepByStepToThePredictedShare) {
  // Of a slip p without force, a step that starts at m f leaves P (p + m f), P = (1 - kappa
  // lambda)^corrections. The flow strains the markers in the body's own frame, so that this holds
  // while it turns only if the force turns along.
  const auto [m, corrections] = GetParam();
  const double P = std::pow(1 - 2 * lambda, corrections);
  const Vector3d spin(0.02, -0.03, 0.05);
  const Surface surface = cubic(4);
  Options options;
  options.motion = Motion::prescribed;
  options.memory = m;
  options.corrections = corrections;
  Body body(surface, ball(4), options, {});
  body.prescribe(Vector3d::Zero(), spin);
  const double p = 0.04;  // at the markers on the body's x and y axes
  double f = 0;
  for (int n = 0; n < 60; ++n) {
    const Quaterniond q = body.state().orientation;
    step(body, local_fluid(surface, [&](const Vector3d& y) {
           const Vector3d b = q.conjugate() * y;
           return Vector3d(spin.cross(y) + q * Vector3d(0.01 * b.x(), -0.01 * b.y(), 0));
         }));
    const double slip = P * (p + m * f);
    f = slip - p;
    EXPECT_NEAR(body.slip().max, std::abs(slip), 100 * eps * p) << n;
  }
  // 1e-4: what is left of (m P)^60 at most.
  EXPECT_NEAR(body.slip().max, std::abs(P * (1 - m) / (1 - m * P)) * p, 1e-4 * p);
}

TEST_P(Memory, NeutralBodyFeelsNoForceOrTorque) {
  Options options;
  options.memory = GetParam().memory;
  options.corrections = GetParam().corrections;
  expect_balance(options);
}

// A free body in gravity whose corrections begin with the force of the step before.
Options remembering(double density_ratio) {
  Options options;
  options.density_ratio = density_ratio;
  options.gravity = {0, 3e-5, 1e-4};
  options.corrections = 2;
  options.memory = 0.9;
  return options;
}

TEST_P(DensityRatio, MemoryKeepsTheBalanceOfMomentum) {
  const double ratio = GetParam(), a = 6;
  const Surface surface = spiral(a, 150);
  const Options options = remembering(ratio);
  State start;
  start.velocity = {0.01, 0, 0};
  Body body(surface, ball(a), options, start);
  const double excess = (ratio - 1) * ball(a).volume;
  Lump lump{1.5 * ball(a).volume};
  for (int n = 1; n <= 50; ++n) {
    lump.momentum += step(body, lump).force;
    const Vector3d momentum = excess * body.state().velocity + lump.momentum;
    const Vector3d expected = excess * (start.velocity + n * options.gravity);
    EXPECT_LT((momentum - expected).norm(), 1e-12 * ball(a).volume) << n;
  }
}

TEST_P(DensityRatio, SpinIsSharedWithTheFluidByMomentsOfInertia) {
  // A spinning sphere in a lump of fluid that can only turn about the same axis as one.
  const double ratio = GetParam(), a = 5;
  const Surface surface = spiral(a, 150);
  const double inertia = ball(a).inertia(0, 0), excess = (ratio - 1) * inertia;
  const double fluid_inertia = 2 * inertia;
  Options options;
  options.density_ratio = ratio;
  options.corrections = 20;
  State start;
  start.angular_velocity = {0, 0, 1e-3};
  Body body(surface, ball(a), options, start);
  double momentum = 0;
  const auto fluid = [&](const Vectors& x, const Vectors& forces) {
    Vector3d torque = Vector3d::Zero();
    for (std::size_t m = 0; m < x.size(); ++m) torque += x[m].cross(forces[m]);
    const Vector3d omega(0, 0, (momentum + 0.5 * torque.z()) / fluid_inertia);
    Vectors u;
    for (const Vector3d& r : x) u.push_back(omega.cross(r));
    return u;
  };
  for (int n = 0; n < 60; ++n) momentum += step(body, fluid).torque.z();
  const double expected = 1e-3 * excess / (excess + fluid_inertia);
  EXPECT_NEAR(body.state().angular_velocity.z(), expected, 1e-12);
  EXPECT_NEAR(momentum, fluid_inertia * expected, 1e-9);
}

class LightestBody : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Memories, LightestBody, ::testing::Values(0, 0.9));

TEST_P(LightestBody, AllowedIsStable) {
  // On the bound, in the fluid that follows least: one lump of mass A/lambda.
  const double a = 12;
  const Surface surface = spiral(a, 300);
  const double area = total(surface.areas), volume = ball(a).volume;
  Options options;
  options.density_ratio = 1 - 2.5 * area / volume + 1e-6;
  options.gravity = {0, 0, 1e-6};
  options.memory = GetParam();
  Body body(surface, ball(a), options, {});
  Lump lump{area / lambda};
  double before = 0;
  for (int n = 0; n < 1500; ++n) {
    before = body.state().velocity.z();
    lump.momentum += step(body, lump).force;
  }
  const double excess = (options.density_ratio - 1) * volume;
  const double expected = excess / (excess + lump.mass) * options.gravity.z();
  EXPECT_NEAR((body.state().velocity.z() - before) / expected, 1, 1e-6);
}

TEST(RigidBody, TooLightAndLargeABodyIsRefusedWithoutInnerShells) {
  Options options;
  options.density_ratio = 0.5;
  const Surface surface = spiral(18, 400);
  EXPECT_THROW(Body(surface, ball(18), options, {}), std::invalid_argument);
  EXPECT_NO_THROW(Body(lined(Sphere(18), 18, 0), ball(18), options, {}));
  EXPECT_NEAR(least_density_ratio(surface, ball(18), 2), 1 - 7.5 / 18, 1e-6);
  EXPECT_NEAR(least_density_ratio(surface, ball(18), 2, true), 1 - 6.0 / 18, 1e-6);
  options.density_ratio = 1 - 7.5 / 18 + 1e-6;
  EXPECT_NO_THROW(Body(surface, ball(18), options, {}));

  // Corrections that would not converge are refused too: (M_f - M)/A = 4/3 here.
  options.density_ratio = 0.5;
  options.relaxation = 1;
  EXPECT_THROW(Body(spiral(8, 100), ball(8), options, {}), std::invalid_argument);
  options.relaxation = 2;
  EXPECT_NO_THROW(Body(spiral(8, 100), ball(8), options, {}));
  // A prescribed body has no such bound.
  options.motion = Motion::prescribed;
  EXPECT_NO_THROW(Body(surface, ball(18), options, {}));
}

TEST(LinedBody, HasShellsInsideOfItsSurface) {
  // Radii and the share of each in the area, the first one's halved.
  const double retraction = 0.4, a = 10.4 - retraction;
  const Surface surface = lined(Sphere(10.4), 10, retraction);
  const Surface outer = markers_of(Sphere(10.4).mesh(10, -retraction));
  ASSERT_GT(surface.markers.size(), outer.markers.size());
  for (std::size_t m = 0; m < outer.markers.size(); ++m) {
    ASSERT_EQ(surface.markers[m], outer.markers[m]);
    ASSERT_EQ(surface.areas[m], outer.areas[m]);
  }
  std::map<double, double> areas;  // of the shells, by radius
  for (std::size_t m = outer.markers.size(); m < surface.markers.size(); ++m)
    areas[std::round(1e6 * surface.markers[m].norm()) * 1e-6] += surface.areas[m];
  ASSERT_EQ(areas.size(), 3U);
  for (const auto& [radius, weight] : std::map<double, double>{{8.5, 0.5}, {5.5, 1}, {2.5, 1}}) {
    ASSERT_TRUE(areas.contains(radius)) << radius;
    // Flat triangles with edges of 1.8 or, at the least, 2.5 on a radius of 2.5.
    const double area = weight * 4 * pi * radius * radius;
    EXPECT_NEAR(areas[radius], area, (radius < a / 2 ? 0.25 : 0.03) * area) << radius;
  }
  EXPECT_EQ(lined_marker_count(Sphere(10.4), 10, retraction),
            static_cast<long long>(surface.markers.size()));
  // Too small for any.
  EXPECT_EQ(lined(Sphere(3.4), 3, 0).markers.size(), 92U);
  EXPECT_GT(lined(Sphere(3.6), 3, 0).markers.size(), 92U);
}

TEST(LinedBody, KeepsTheBalancesOfMomentum) {
  // (2) and (3) with all markers, and what the body reports follows from its own motion: M U' =
  // force + (M - M_f) g, and alike for the spin.
  const double ratio = 2, a = 8;
  const Surface surface = lined(Sphere(a), 8, 0);
  const Solid solid = ball(a);
  const Options options = remembering(ratio);
  State start;
  start.velocity = {0.01, 0, 0};
  start.angular_velocity = {0, 1e-3, 0};
  Body body(surface, solid, options, start);
  const auto flow = local_fluid(surface, [](const Vector3d& y) {
    return Vector3d(0.001 * y.z(), 0.0002 * y.x() * y.y(), 0.02 + 0.0005 * y.x());
  });
  const double inertia = solid.inertia(0, 0);
  for (int n = 0; n < 30; ++n) {
    const State before = body.state();
    const Impulse impulse = step(body, flow);
    const Vector3d dU = body.state().velocity - before.velocity;
    const Vector3d dW = body.state().angular_velocity - before.angular_velocity;
    const double weight = solid.volume * 1e-2;
    const Vector3d excess = (ratio - 1) * solid.volume * (dU - options.gravity);
    ASSERT_LT((excess + impulse.force).norm(), 1e-12 * weight);
    ASSERT_LT(((ratio - 1) * inertia * dW + impulse.torque).norm(), 1e-12 * a * weight);
    ASSERT_LT((body.hydrodynamic_force() - ratio * solid.volume * dU +
               (ratio - 1) * solid.volume * options.gravity)
                  .norm(),
              1e-12 * weight);
    ASSERT_LT((body.hydrodynamic_torque() - ratio * inertia * dW).norm(), 1e-12 * a * weight);
  }
}

TEST(PrescribedBody, MovesAsToldAndReportsTheForceItTakes) {
  const Surface surface = cubic(4);
  Options options;
  options.motion = Motion::prescribed;
  State start;
  start.velocity = {0.01, 0, 0};
  Body body(surface, ball(4), options, start);
  const auto rest = local_fluid(surface, [](const Vector3d&) { return Vector3d(0, 0, 0); });
  const double left = std::pow(1 - 2 * lambda, 5), area = total(surface.areas);
  const double resistance = 2 * area / lambda * (1 - left);
  for (int n = 1; n <= 3; ++n) {
    step(body, rest);
    EXPECT_LT((body.state().position - n * start.velocity).norm(), 10 * eps);
    EXPECT_LT((body.hydrodynamic_force() + resistance * start.velocity).norm(), 1e-12);
    EXPECT_NEAR(body.slip().max, left * 0.01, 10 * eps);
  }
  // A change of velocity takes the fluid inside along.
  const Vector3d faster(0.01, 0.02, 0), spin(0, 0, 1e-3);
  body.prescribe(faster, spin);
  step(body, rest);
  double arm2 = 0;
  for (const Vector3d& r : surface.markers) arm2 += surface.areas[0] * r.head<2>().squaredNorm();
  EXPECT_NEAR(body.hydrodynamic_force().y(), (ball(4).volume - resistance) * 0.02,
              1e-12 * resistance);
  EXPECT_NEAR(body.hydrodynamic_torque().z(),
              (ball(4).inertia(2, 2) - 2 * arm2 / lambda * (1 - left)) * 1e-3, 1e-12 * arm2);
  EXPECT_EQ(body.state().velocity, faster);
  EXPECT_EQ(body.state().angular_velocity, spin);
}

TEST(PrescribedBody, FreeBodyCannotBeTold) {
  Body body(spiral(4, 50), ball(4), {}, {});
  EXPECT_THROW(body.prescribe(Vector3d::Zero(), Vector3d::Zero()), std::logic_error);
}

TEST(PrescribedBody, ConstantSpinTurnsItExactly) {
  const int steps = 1000;
  const Vector3d axis = Vector3d(1, -2, 0.5).normalized();
  const Surface surface = ellipsoid_surface({5, 4, 3}, 60);
  Options options;
  options.motion = Motion::prescribed;
  State start;
  start.position = {3, 4, 5};
  start.orientation = Eigen::AngleAxisd(1.1, Vector3d(0.3, 0.1, -1).normalized());
  start.angular_velocity = 2 * pi / steps * axis;
  Body body(surface, ellipsoid({5, 4, 3}), options, start);
  const std::vector<double> x0(body.positions().begin(), body.positions().end());
  const auto rest = local_fluid(surface, [](const Vector3d&) { return Vector3d(0, 0, 0); });
  for (int n = 1; n <= steps; ++n) {
    step(body, rest);
    ASSERT_NEAR(body.state().orientation.norm(), 1, 4 * eps);
    if (n == steps / 4) {
      const Quaterniond expected = Eigen::AngleAxisd(pi / 2, axis) * start.orientation;
      EXPECT_LT(body.state().orientation.angularDistance(expected), 1e-12);
    }
  }
  // A whole turn: back, shape and all.
  for (std::size_t i = 0; i < x0.size(); ++i) EXPECT_NEAR(body.positions()[i], x0[i], 1e-11);
}

// A body whose markers hardly touch the fluid is in a vacuum.
Surface untouched(Surface surface) {
  for (double& area : surface.areas) area *= 1e-18;
  return surface;
}

TEST(RigidBody, FallsFreelyInAVacuum) {
  const Surface surface = untouched(spiral(4, 50));
  Options options;
  options.density_ratio = 3;
  options.gravity = {0, 0, -1e-4};
  Body body(surface, ball(4), options, {});
  for (int n = 0; n < 100; ++n)
    step(body, local_fluid(surface, [](const Vector3d&) { return Vector3d(0.1, 0, 0); }));
  EXPECT_LT((body.state().velocity - 100 * options.gravity).norm(), 1e-12);
  EXPECT_LT((body.state().position - 5050 * options.gravity).norm(), 1e-10);
}

TEST(RigidBody, FreeSymmetricTopPrecessesAboutItsAngularMomentum) {
  // Poinsot: the axis of a free symmetric top goes round L at the rate |L|/I_1.
  const Vector3d axes(3, 3, 5);
  const Surface surface = untouched(ellipsoid_surface(axes, 60));
  const Solid solid = ellipsoid(axes);
  const auto tumble = [&](int steps) {
    Options options;
    options.density_ratio = 3;
    State start;
    start.angular_velocity = 4.0 / steps * Vector3d(1, 0, 1);
    Body body(surface, solid, options, start);
    // The first step begins with the momentum of the one before, when the body was turned back.
    const Quaterniond back(
        Eigen::AngleAxisd(-start.angular_velocity.norm(), start.angular_velocity.normalized()));
    const Vector3d momentum = back * (solid.inertia * start.angular_velocity);
    for (int n = 0; n < steps; ++n)
      step(body, local_fluid(surface, [](const Vector3d&) { return Vector3d(0, 0, 0); }));
    const State& end = body.state();
    // Momentum of the last step, of the orientation that it began with.
    const Quaterniond last(
        Eigen::AngleAxisd(-end.angular_velocity.norm(), end.angular_velocity.normalized()));
    const Matrix3d r = (last * end.orientation).toRotationMatrix();
    const Vector3d kept = r * solid.inertia * r.transpose() * end.angular_velocity;
    EXPECT_LT((kept - momentum).norm(), 1e-12 * momentum.norm());
    const Vector3d axis =
        Eigen::AngleAxisd(steps * momentum.norm() / solid.inertia(0, 0), momentum.normalized()) *
        Vector3d::UnitZ();
    const double energy = kept.dot(end.angular_velocity) / (momentum.dot(start.angular_velocity));
    return std::pair{(end.orientation * Vector3d::UnitZ() - axis).norm(), std::abs(energy - 1)};
  };
  const auto [axis_1, energy_1] = tumble(1000);
  const auto [axis_2, energy_2] = tumble(2000);
  EXPECT_LT(axis_2, 4e-3);
  EXPECT_LT(energy_2, 4e-3);
  // First order in the time step, like the advance of every marker.
  EXPECT_NEAR(axis_1 / axis_2, 2, 0.05);
  EXPECT_NEAR(energy_1 / energy_2, 2, 0.05);
}

TEST_P(Memory, StateDeterminesAllThatFollowsToTheLastBit) {
  const Vector3d axes(5, 4, 3);
  const Surface surface = ellipsoid_surface(axes, 80);
  const auto flow = local_fluid(surface, [](const Vector3d& y) {
    return Vector3d(0.01 * y.z(), 0.003 * y.x(), 0.02 + 0.005 * y.x());
  });
  Options options;
  options.density_ratio = 2;
  options.gravity = {0, 0, 1e-5};
  options.memory = GetParam().memory;
  options.corrections = GetParam().corrections;
  Body body(surface, ellipsoid(axes), options, {});
  for (int n = 0; n < 7; ++n) step(body, flow);
  Body resumed(surface, ellipsoid(axes), options, body.state());
  for (int n = 0; n < 7; ++n) {
    step(body, flow);
    step(resumed, flow);
  }
  EXPECT_EQ(resumed.state().position, body.state().position);
  EXPECT_EQ(resumed.state().velocity, body.state().velocity);
  EXPECT_EQ(resumed.state().orientation.coeffs(), body.state().orientation.coeffs());
  EXPECT_EQ(resumed.state().angular_velocity, body.state().angular_velocity);
  EXPECT_EQ(resumed.hydrodynamic_torque(), body.hydrodynamic_torque());
}

using Saved = std::map<std::string, std::vector<double>, std::less<>>;

Saved saved(const Body& body) {
  Saved state;
  body.save([&](std::string_view name, std::span<const double> numbers) {
    EXPECT_FALSE(state.contains(name)) << name << " comes twice";
    state[std::string(name)].assign(numbers.begin(), numbers.end());
  });
  return state;
}

StateReader reader(const Saved& state) {
  return [&state](std::string_view name, std::span<double> numbers) {
    const auto found = state.find(name);
    if (found == state.end() || found->second.size() != numbers.size())
      throw std::out_of_range(std::string(name));
    std::copy(found->second.begin(), found->second.end(), numbers.begin());
  };
}

bool same(const Body& a, const Body& b) {
  const auto equal = [](std::span<const double> p, std::span<const double> q) {
    return std::equal(p.begin(), p.end(), q.begin(), q.end());
  };
  return equal(a.positions(), b.positions()) && saved(a) == saved(b) &&
         a.state().forces == b.state().forces && a.slip().max == b.slip().max &&
         a.hydrodynamic_force() == b.hydrodynamic_force();
}

TEST_P(Memory, LoadedBodyGoesOnToTheLastBit) {
  // Heavy and turned over by the flow; light, with inner shells; told how to move.
  const Vector3d axes(5, 4, 3);
  Options heavy;
  heavy.density_ratio = 2;
  heavy.gravity = {0, 0, 1e-5};
  heavy.memory = GetParam().memory;
  heavy.corrections = GetParam().corrections;
  Options light = heavy, told = heavy;
  light.density_ratio = 0.5;
  told.motion = Motion::prescribed;
  const Surface shells = lined(Sphere(18), 6, 0);
  ASSERT_GT(shells.markers.size(), markers_of(Sphere(18).mesh(6)).markers.size());
  const auto check = [](const Surface& surface, const Solid& solid, const Options& options) {
    const auto flow = local_fluid(surface, [](const Vector3d& y) {
      return Vector3d(0.001 * y.z(), 0.0003 * y.x(), 0.02 + 0.0005 * y.x());
    });
    const auto prescribe = [&](Body& body, int n) {
      if (options.motion == Motion::prescribed)
        body.prescribe({0.01, 1e-3 * n, 0}, {0, 0, 1e-3 * n});
    };
    State start;
    start.position = {3, 4, 5};
    for (const int n : {0, 1, 2, 9}) {
      Body straight(surface, solid, options, start);
      for (int k = 0; k < n; ++k) {
        step(straight, flow);
        prescribe(straight, k);
      }
      Body resumed(surface, solid, options, {});
      step(resumed, flow);
      resumed.load(reader(saved(straight)));
      ASSERT_TRUE(same(resumed, straight)) << "after " << n << " steps";
      for (int k = 0; k < 6; ++k) {
        step(straight, flow);
        step(resumed, flow);
        ASSERT_TRUE(same(resumed, straight)) << "after " << n << " and " << k << " steps";
      }
    }
  };
  check(ellipsoid_surface(axes, 80), ellipsoid(axes), heavy);
  check(shells, ball(18), light);
  check(ellipsoid_surface(axes, 80), ellipsoid(axes), told);
}

TEST_P(Memory, LoadThatFailsLeavesTheBodyAsItWas) {
  const Surface surface = spiral(4, 80);
  const auto flow = local_fluid(surface, [](const Vector3d& y) {
    return Vector3d(0.01 * y.z(), 0.003 * y.x(), 0.02 + 0.005 * y.x());
  });
  Options options;
  options.density_ratio = 2;
  options.memory = GetParam().memory;
  Body body(surface, ball(4), options, {}), other(surface, ball(4), options, {});
  for (int n = 0; n < 3; ++n) step(body, flow);
  for (int n = 0; n < 5; ++n) step(other, flow);
  const Body before = body;
  const Saved whole = saved(other);
  for (const auto& [name, numbers] : whole) {
    Saved missing = whole;
    missing.erase(name);
    EXPECT_THROW(body.load(reader(missing)), std::out_of_range) << name;
    EXPECT_TRUE(same(body, before)) << name;
  }
  for (const std::string name : {"position", "orientation"}) {
    Saved broken = whole;
    broken[name][0] = std::nan("");
    EXPECT_THROW(body.load(reader(broken)), std::invalid_argument) << name;
    EXPECT_TRUE(same(body, before)) << name;
  }
  body.load(reader(whole));
  EXPECT_TRUE(same(body, other));
}

TEST(RigidBody, RunawayStepIsRefusedAndLeavesTheStateAsItWas) {
  const Surface surface = cubic(4);
  const auto run = [&](const Vector3d& flow, const Vector3d& spin) {
    State start;
    start.position = {1, 2, 3};
    start.forces.assign(surface.markers.size(), {1e-9, 0, -1e-9});
    Options options;
    options.memory = 0.9;
    Body body(surface, ball(4), options, start);
    const std::vector<double> x(body.positions().begin(), body.positions().end());
    std::size_t marker = surface.markers.size();
    try {
      step(body, local_fluid(surface, [&](const Vector3d& y) {
             return Vector3d(flow + spin.cross(y - start.position));
           }));
    } catch (const MotionFailure& error) {
      marker = error.marker();
      EXPECT_EQ(body.state().position, start.position);
      EXPECT_EQ(body.state().velocity, start.velocity);
      EXPECT_EQ(body.state().forces, start.forces);
      EXPECT_EQ(body.state().orientation.coeffs(), start.orientation.coeffs());
      EXPECT_TRUE(std::equal(x.begin(), x.end(), body.positions().begin()));
      EXPECT_NE(std::string(error.what()).find("marker"), std::string::npos);
    }
    return marker;
  };
  const Vector3d zero = Vector3d::Zero();
  EXPECT_EQ(run({0.49, 0, 0}, zero), surface.markers.size());
  EXPECT_LT(run({0.51, 0, 0}, zero), surface.markers.size());
  EXPECT_EQ(run(zero, {0, 0, 0.12}), surface.markers.size());
  // Turning about z, the markers of the equator move furthest.
  const std::size_t worst = run(zero, {0, 0, 0.13});
  ASSERT_LT(worst, surface.markers.size());
  EXPECT_EQ(surface.markers[worst].z(), 0);
  EXPECT_LT(run({std::nan(""), 0, 0}, zero), surface.markers.size());
  EXPECT_LT(run({0, 0, std::numeric_limits<double>::infinity()}, zero), surface.markers.size());
}

std::string refusal(const Surface& surface, const Solid& solid, const Options& options,
                    const State& state = {}) {
  try {
    const Body body(surface, solid, options, state);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(RigidBody, WrongInputIsNamedWithItsBound) {
  const Surface good = spiral(4, 50);
  const Solid solid = ball(4);
  const auto expect = [](const std::string& message, std::initializer_list<const char*> parts) {
    for (const char* part : parts)
      EXPECT_NE(message.find(part), std::string::npos) << part << " in: " << message;
  };
  EXPECT_EQ(refusal(good, solid, {}), "accepted");
  const auto with = [&](auto change) {
    Options options;
    change(options);
    return refusal(good, solid, options);
  };
  expect(with([](Options& o) { o.density_ratio = -1; }), {"density_ratio", "-1", "positive"});
  expect(with([](Options& o) { o.density_ratio = std::nan(""); }), {"density_ratio", "nan"});
  expect(with([](Options& o) { o.corrections = 0; }), {"corrections", "0", "at least 1"});
  expect(with([](Options& o) { o.relaxation = 0; }), {"relaxation", "0", "default 2"});
  expect(with([](Options& o) { o.relaxation = 3; }), {"relaxation", "3", "2.62"});
  expect(with([](Options& o) { o.memory = -0.1; }), {"memory", "-0.1", "0 to 0.95"});
  expect(with([](Options& o) { o.memory = 1; }), {"memory", "1", "0 to 0.95"});
  expect(with([](Options& o) { o.memory = std::nan(""); }), {"memory", "nan"});
  expect(with([](Options& o) { o.gravity.x() = std::nan(""); }), {"gravity", "finite"});
  Options light;
  light.density_ratio = 0.5;
  expect(refusal(spiral(18, 400), ball(18), light), {"density_ratio", "0.5", "0.58", "lined"});

  Surface bad = good;
  bad.areas.pop_back();
  expect(refusal(bad, solid, {}), {"50 markers", "49 areas"});
  bad = good;
  bad.areas[7] = 0;
  expect(refusal(bad, solid, {}), {"marker 7", "0", "positive"});
  bad = good;
  bad.markers[3].y() = std::nan("");
  expect(refusal(bad, solid, {}), {"marker 3", "finite"});
  bad = good;
  for (Vector3d& r : bad.markers) r = {r.x(), 2 * r.x(), 0};
  expect(refusal(bad, solid, {}), {"line"});
  expect(refusal({}, solid, {}), {"0 markers"});

  Solid odd = solid;
  odd.volume = 0;
  expect(refusal(good, odd, {}), {"volume", "0", "positive"});
  odd = solid;
  odd.inertia(0, 1) = 1;
  expect(refusal(good, odd, {}), {"inertia", "symmetric"});
  odd = solid;
  odd.inertia(2, 2) = -1;
  expect(refusal(good, odd, {}), {"inertia", "positive definite"});

  State state;
  state.orientation.coeffs() *= 1.1;
  expect(refusal(good, solid, {}, state), {"orientation", "1.1", "normalise"});
  state = {};
  state.velocity.z() = std::nan("");
  expect(refusal(good, solid, {}, state), {"finite"});
  state = {};
  state.forces.assign(49, Vector3d::Zero());
  expect(refusal(good, solid, {}, state), {"50 markers", "49 forces"});
  state.forces.assign(50, Vector3d(0, std::nan(""), 0));
  expect(refusal(good, solid, {}, state), {"forces", "finite"});

  Body body(good, solid, {}, {});
  std::vector<double> right(150), wrong(149);
  EXPECT_THROW(body.predict_force(wrong), std::invalid_argument);
  EXPECT_THROW(body.correct_force(wrong, right), std::invalid_argument);
  EXPECT_THROW(body.correct_force(right, wrong), std::invalid_argument);
  EXPECT_THROW(body.advance(wrong), std::invalid_argument);
}

}  // namespace
