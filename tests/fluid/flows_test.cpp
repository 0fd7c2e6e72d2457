// Flows with known solutions.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "ductile/fluid/duct.hpp"
#include "ductile/fluid/fluid.hpp"
#include "fluid/precisions.hpp"

namespace {

using namespace ductile::fluid;

struct Field {
  std::vector<double> density;
  std::vector<double> velocity;
};
Field fields(Fluid& fluid) {
  const auto& n = fluid.options().nodes;
  const auto count = static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) *
                     static_cast<std::size_t>(n[2]);
  Field field{std::vector<double>(count), std::vector<double>(3 * count)};
  fluid.fields(field.density, field.velocity);
  return field;
}

// A slow flow that starts is the same in the frame at rest, however the lattice is accelerated
// under it: between walls that move, and where nothing holds it. What is apart is quadratic in
// velocities.
TEST(MovingLattice, TellsTheSameFlowAsOneAtRest) {
  using enum Boundary;
  for (const auto walls : {halfway, regularized, periodic}) {
    for (const auto mirror : {Mirror::none, Mirror::between_nodes, Mirror::on_node}) {
      if (walls == periodic && mirror != Mirror::none) continue;
      Options o;
      o.nodes = {11, 8, 3};
      o.boundary = {walls, walls, periodic};
      o.mirror = mirror;
      o.tau = 0.8;
      o.force = {0, 0, 1e-6};
      if (walls != periodic) o.wall_velocity[0] = {Eigen::Vector3d(0, 0, 1e-4), {0, 0, -2e-4}};
      Fluid at_rest(MPI_COMM_SELF, o);
      Fluid moving(MPI_COMM_SELF, o);
      constexpr double largest = 2e-6;
      double apart = 0;
      double gained = 0;
      double way = 0;
      for (int n = 0; n < 120; ++n) {
        const double acceleration = n < 20 ? 0 : largest * (n < 70 ? 1 : -0.7);
        if (n == 20 || n == 70) moving.accelerate(acceleration);
        const Field expected = fields(at_rest);
        Field found = fields(moving);
        const std::size_t count = found.density.size();
        for (std::size_t i = 0; i < count; ++i) {
          found.velocity[2 * count + i] += moving.motion().velocity;
          for (std::size_t a = 0; a < 3; ++a)
            apart = std::max(
                apart, std::abs(found.velocity[a * count + i] - expected.velocity[a * count + i]));
        }
        EXPECT_NEAR(moving.motion().velocity, gained + acceleration / 2, 1e-15);
        EXPECT_NEAR(moving.motion().position, way, 1e-13);
        way += gained + acceleration / 2;
        gained += acceleration;
        at_rest.step();
        moving.step();
      }
      std::printf("walls %d, mirror %d: %.2e apart where the lattice gains %.1e a step\n",
                  static_cast<int>(walls), static_cast<int>(mirror), apart, largest);
      EXPECT_LT(apart, 1e-3 * largest);
    }
  }
}

// Decay rate of a Taylor-Green vortex in the plane of two axes, over one e-fold, against
// 2 nu k^2.
double taylor_green_error(int n, std::size_t a, std::size_t b, Collision collision) {
  const std::size_t other = 3 - a - b;
  Options o;
  o.nodes = {n, n, n};
  o.nodes[other] = 4;
  o.tau = 1;
  o.collision = collision;
  Fluid fluid(MPI_COMM_WORLD, o);
  const double k = 2 * std::numbers::pi / n;
  const double amplitude = 0.02 * 16 / n;  // diffusive scaling: Mach number falls with dx
  fluid.initialise([&](int x, int y, int z) {
    const std::array<int, 3> node = {x, y, z};
    const double p = k * node[a];
    const double q = k * node[b];
    NodeState s;
    const auto ia = static_cast<Eigen::Index>(a);
    const auto ib = static_cast<Eigen::Index>(b);
    s.velocity[ia] = amplitude * std::sin(p) * std::cos(q);
    s.velocity[ib] = -amplitude * std::cos(p) * std::sin(q);
    s.gradient(ia, ia) = amplitude * k * std::cos(p) * std::cos(q);
    s.gradient(ib, ia) = -amplitude * k * std::sin(p) * std::sin(q);
    s.gradient(ia, ib) = amplitude * k * std::sin(p) * std::sin(q);
    s.gradient(ib, ib) = -amplitude * k * std::cos(p) * std::cos(q);
    s.density = 1 + 0.75 * amplitude * amplitude * (std::cos(2 * p) + std::cos(2 * q));
    return s;
  });
  const auto energy = [&] {
    const Field field = fields(fluid);
    double sum = 0;
    for (const double u : field.velocity) sum += u * u;
    return sum;
  };
  const double before = energy();
  const double efold = 1 / (2 * fluid.viscosity() * k * k);
  const int steps = static_cast<int>(std::lround(efold));
  for (int s = 0; s < steps; ++s) fluid.step();
  const double rate = 0.5 * std::log(before / energy()) / steps;
  return std::abs(rate * efold - 1);
}

TEST(TaylorGreen, DecaysAtTheViscousRateWithOrderTwo) {
  const double e16 = taylor_green_error(16, 0, 1, Collision::bgk);
  const double e32 = taylor_green_error(32, 0, 1, Collision::bgk);
  const double e64 = taylor_green_error(64, 0, 1, Collision::bgk);
  EXPECT_LT(e32, 0.01);
  EXPECT_GT(std::log2(e16 / e32), 1.9);
  EXPECT_GT(std::log2(e32 / e64), 1.9);
}

TEST(TaylorGreen, IsTheSameInEveryPlaneAndWithTwoRelaxationTimes) {
  const double xy = taylor_green_error(16, 0, 1, Collision::bgk);
  EXPECT_NEAR(taylor_green_error(16, 1, 2, Collision::bgk), xy, 1e-10);
  EXPECT_NEAR(taylor_green_error(16, 2, 0, Collision::bgk), xy, 1e-10);
  EXPECT_LT(taylor_green_error(32, 0, 1, Collision::trt), 0.01);
}

// A shear wave in a uniform flow U along its wave vector k = (2 pi/32) (directions 0 or 1): by what
// part of U the lattice carries it too fast, over k^2.
double excess_of_advection(const std::array<int, 3>& direction, const Options& options) {
  constexpr int n = 32;
  constexpr double amplitude = 1e-3;
  Options o = options;
  for (std::size_t axis = 0; axis < 3; ++axis) o.nodes[axis] = direction[axis] != 0 ? n : 2;
  const Eigen::Vector3d k =
      2 * std::numbers::pi / n * Eigen::Vector3d(direction[0], direction[1], direction[2]);
  const Eigen::Vector3d across = 0.02 * k.normalized();
  const Eigen::Vector3d along =
      k.cross(k.x() == k.z() ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ()).normalized();
  Fluid fluid(MPI_COMM_WORLD, o);
  fluid.initialise([&](int x, int y, int z) {
    const double angle = k.dot(Eigen::Vector3d(x, y, z));
    NodeState s;
    s.velocity = across + amplitude * std::sin(angle) * along;
    s.gradient = amplitude * std::cos(angle) * k * along.transpose();
    return s;
  });
  const auto phase = [&] {  // of the wave against the flow
    const Field field = fields(fluid);
    const std::size_t count = field.density.size();
    double sine = 0;
    double cosine = 0;
    std::size_t m = 0;
    for (int x = 0; x < o.nodes[0]; ++x) {
      for (int y = 0; y < o.nodes[1]; ++y) {
        for (int z = 0; z < o.nodes[2]; ++z, ++m) {
          const Eigen::Vector3d u(field.velocity[m], field.velocity[count + m],
                                  field.velocity[2 * count + m]);
          const double angle =
              k.dot(Eigen::Vector3d(x, y, z) - across * static_cast<double>(fluid.time()));
          sine += u.dot(along) * std::sin(angle);
          cosine += u.dot(along) * std::cos(angle);
        }
      }
    }
    return -std::atan2(cosine, sine);
  };
  for (int step = 0; step < 50; ++step) fluid.step();  // until only the wave is left
  const double before = phase();
  constexpr int steps = 100;
  for (int step = 0; step < steps; ++step) fluid.step();
  return (phase() - before) / (k.dot(across) * steps) / k.squaredNorm();
}

// Galilean invariance, doc/equations.md: what the checks of a scenario rely on is the mean over all
// directions, for which Lebedev's rule of 26 points, exact to order 7, has weights.
TEST(ShearWave, IsCarriedByTheFlowAsTheRelaxationTimesSay) {
  for (const double tau : {0.6, 0.7, 1.0}) {
    const double even = std::pow(tau - 0.5, 2);
    for (const double magic : {even, 1.0 / 12, 3.0 / 16, 1.0 / 4}) {
      Options o;
      o.tau = tau;
      o.collision = magic == even ? Collision::bgk : Collision::trt;
      o.magic = magic;
      const double edge = excess_of_advection({1, 0, 0}, o);
      const double face = excess_of_advection({1, 1, 0}, o);
      const double body = excess_of_advection({1, 1, 1}, o);
      const double mean = 6.0 / 21 * edge + 12 * 4.0 / 105 * face + 8 * 9.0 / 280 * body;
      const auto expect = [&](double excess, double law) {
        EXPECT_NEAR(excess, law, 1e-3 + 0.05 * std::abs(law)) << tau << ' ' << magic;
      };
      const double law = 2.0 / 3 * (even - magic);
      expect(edge, law);
      expect(face, law + 0.5 * (magic - 1.0 / 12));
      expect(body, law);
      expect(mean, 2.0 / 3 * (even - (23 * magic + 1) / 35));
    }
  }
}

struct Duct {
  Options options;
  std::array<double, 2> half_width{};
  double maximum = 0;
};

// A duct of 2W = `width` in x, `aspect` times as wide in y, of Reynolds number about 10/aspect.
Duct duct(int width, int aspect, double tau, Boundary walls, Collision collision) {
  const int extra = walls == Boundary::regularized ? 1 : 0;
  Duct d;
  d.options.nodes = {width + extra, aspect * width + extra, 2};
  d.options.boundary = {walls, walls, Boundary::periodic};
  d.options.tau = tau;
  d.options.collision = collision;
  const double w = width / 2.0;
  const double nu = (tau - 0.5) / 3;
  d.half_width = {w, aspect * w};
  d.maximum = 10 * nu / (2 * w);
  d.options.force = {0, 0, d.maximum / DuctFlow(d.half_width, 1, nu).maximum()};
  return d;
}

NodeState developed(const Duct& d, int i, int j) {
  const double nu = (d.options.tau - 0.5) / 3;
  const DuctFlow flow(d.half_width, d.options.force[2], nu);
  const double x = i - (d.options.nodes[0] - 1) / 2.0;
  const double y = j - (d.options.nodes[1] - 1) / 2.0;
  NodeState s;
  if (std::abs(x) < d.half_width[0] && std::abs(y) < d.half_width[1]) {
    s.velocity[2] = flow.velocity(x, y);
    const Eigen::Vector2d g = flow.gradient(x, y);
    s.gradient(0, 2) = g[0];
    s.gradient(1, 2) = g[1];
  }
  return s;
}

// Root-mean-square difference to eq. (1) over the nodes, relative to that of eq. (1), in the steady
// state.
double duct_error(int width, int aspect, double tau, Boundary walls,
                  Collision collision = Collision::bgk) {
  const Duct d = duct(width, aspect, tau, walls, collision);
  Fluid fluid(MPI_COMM_WORLD, d.options);
  fluid.initialise([&](int i, int j, int) { return developed(d, i, j); });
  const double time = width * width / 4.0 / fluid.viscosity();
  for (int s = 0; s < static_cast<int>(1.0 * time); ++s) fluid.step();
  const Field field = fields(fluid);
  double error = 0;
  double norm = 0;
  std::size_t n = 2 * field.density.size();
  for (int i = 0; i < d.options.nodes[0]; ++i) {
    for (int j = 0; j < d.options.nodes[1]; ++j, n += 2) {
      const double exact = developed(d, i, j).velocity[2];
      error += std::pow(field.velocity[n] - exact, 2);
      norm += std::pow(exact, 2);
    }
  }
  return std::sqrt(error / norm);
}

class DuctWalls : public testing::TestWithParam<Boundary> {};

TEST_P(DuctWalls, SteadyFlowIsTheSeriesWithOrderTwo) {
  for (const double tau : {0.6, 0.8, 1.0}) {
    const double e16 = duct_error(16, 1, tau, GetParam());
    const double e32 = duct_error(32, 1, tau, GetParam());
    EXPECT_LT(e32, 0.01) << "tau " << tau;
    EXPECT_GT(std::log2(e16 / e32), 1.9) << "tau " << tau << ' ' << e16 << ' ' << e32;
  }
}

TEST_P(DuctWalls, OrderTwoHoldsOnTheNextGrid) {
  const double e32 = duct_error(32, 1, 1.0, GetParam());
  const double e64 = duct_error(64, 1, 1.0, GetParam());
  EXPECT_GT(std::log2(e32 / e64), 1.9) << e32 << ' ' << e64;
}

TEST_P(DuctWalls, RectangularDuctIsTheSeries) {
  EXPECT_LT(duct_error(24, 2, 1.0, GetParam()), 0.01);
}

// u_c/U_max at nu t/W^2, from the eigenfunction expansion of the start-up flow.
TEST_P(DuctWalls, StartsUpFromRestAsTheSeries) {
  Duct d = duct(32, 1, 0.8, GetParam(), Collision::bgk);
  // a node on the axis
  const int extra = GetParam() == Boundary::regularized ? 1 : 0;
  d.options.nodes[0] = d.options.nodes[1] = 31 + 2 * extra;
  const double w = (d.options.nodes[0] - extra) / 2.0;
  const double nu = (d.options.tau - 0.5) / 3;
  d.maximum = 0.29468541 * d.options.force[2] * w * w / nu;
  Fluid fluid(MPI_COMM_WORLD, d.options);
  const double unit = w * w / nu;
  const std::array<std::array<double, 2>, 5> table = {
      {{.05, .169524}, {.1, .331814}, {.2, .585577}, {.5, .905461}, {1, .991983}}};
  for (const auto& [t, expected] : table) {
    while (static_cast<double>(fluid.time()) < std::round(t * unit)) fluid.step();
    const Field field = fields(fluid);
    const auto across = static_cast<std::size_t>(d.options.nodes[0]);  // also along y
    const std::size_t n = (across / 2 * across + across / 2) * 2;
    EXPECT_NEAR(field.velocity[2 * field.density.size() + n] / d.maximum, expected, 0.01 * expected)
        << "at t = " << t;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, DuctWalls,
                         testing::Values(Boundary::halfway, Boundary::regularized),
                         [](const auto& test) {
                           return test.param == Boundary::halfway ? "Halfway" : "Regularized";
                         });

// The mean density less one, and that over the nodes that are on no wall.
std::array<double, 2> mean_densities(Fluid& fluid) {
  const auto& n = fluid.options().nodes;
  const double volume = (n[0] - 1) * (n[1] - 1) * n[2];
  const Field field = fields(fluid);
  double sum = 0;
  std::size_t m = 0;
  for (int i = 0; i < n[0]; ++i) {
    for (int j = 0; j < n[1]; ++j) {
      const bool inside = i > 0 && i < n[0] - 1 && j > 0 && j < n[1] - 1;
      for (int k = 0; k < n[2]; ++k, ++m) sum += inside ? field.density[m] - 1 : 0;
    }
  }
  return {fluid.totals().mass / volume, sum / ((n[0] - 2) * (n[1] - 2) * n[2])};
}

// Over 200 W^2/nu no mass passes walls on nodes, not at the edges either, and the pressure in the
// fluid stays where it is.
TEST(Duct, WallsOnNodesKeepMassAndPressure) {
  for (const int aspect : {1, 2}) {
    const Duct d = duct(15, aspect, 1.0, Boundary::regularized, Collision::bgk);
    Fluid fluid(MPI_COMM_WORLD, d.options);
    fluid.initialise([&](int i, int j, int) { return developed(d, i, j); });
    const double unit = 15 * 15 / 4.0 / fluid.viscosity();
    EXPECT_EQ(mean_densities(fluid)[0], 0);
    while (static_cast<double>(fluid.time()) < 10 * unit) fluid.step();
    const auto [mass_before, inside_before] = mean_densities(fluid);
    while (static_cast<double>(fluid.time()) < 200 * unit) fluid.step();
    const auto [mass, inside] = mean_densities(fluid);
    EXPECT_NEAR(mass, 0, 1e-13) << aspect;
    EXPECT_NEAR(mass, mass_before, 1e-13) << aspect;
    EXPECT_NEAR(inside, inside_before, 1e-12) << aspect;
  }
}

// With magic = 3/16 half-way walls lie half-way at any tau.
TEST(Duct, TwoRelaxationTimesWithTheMagicNumberDoNotSlip) {
  const double bgk = duct_error(16, 1, 1.0, Boundary::halfway);
  const double trt = duct_error(16, 1, 1.0, Boundary::halfway, Collision::trt);
  const double trt_low = duct_error(16, 1, 0.6, Boundary::halfway, Collision::trt);
  EXPECT_LT(trt, bgk);
  EXPECT_NEAR(trt, trt_low, 0.1 * trt);
}

// Linear profiles are exact, whichever way the walls are made and move.
TEST(Couette, ProfileIsLinear) {
  for (const Boundary walls : {Boundary::halfway, Boundary::regularized}) {
    for (const std::size_t axis : {0U, 1U, 2U}) {
      if (walls == Boundary::regularized && axis == 2) continue;
      Options o;
      o.nodes = {2, 2, 2};
      o.nodes[axis] = 12;
      o.boundary[axis] = walls;
      o.tau = 0.9;
      const std::size_t along = (axis + 1) % 3;
      o.wall_velocity[axis][0][static_cast<Eigen::Index>(along)] = -0.02;
      o.wall_velocity[axis][1][static_cast<Eigen::Index>(along)] = 0.01;
      Fluid fluid(MPI_COMM_WORLD, o);
      for (int s = 0; s < 12000; ++s) fluid.step();
      const Field field = fields(fluid);
      const double wall = walls == Boundary::halfway ? -0.5 : 0;
      const double width = walls == Boundary::halfway ? 12 : 11;
      std::size_t n = 0;
      for (int x = 0; x < o.nodes[0]; ++x) {
        for (int y = 0; y < o.nodes[1]; ++y) {
          for (int z = 0; z < o.nodes[2]; ++z, ++n) {
            const std::array<int, 3> node = {x, y, z};
            const double expected = -0.02 + 0.03 * (node[axis] - wall) / width;
            EXPECT_NEAR(field.velocity[along * field.density.size() + n], expected, 1e-10);
            EXPECT_NEAR(field.velocity[axis * field.density.size() + n], 0, 1e-10);
          }
        }
      }
    }
  }
}

TEST(Precision, SingleKeepsTheDuctFlow) {
  Duct d = duct(16, 1, 1.0, Boundary::halfway, Collision::bgk);
  std::vector<std::vector<double>> velocity;
  for (const ductile::test::Precisions& precision : ductile::test::precisions) {
    precision.choose(d.options);
    Fluid fluid(MPI_COMM_WORLD, d.options);
    for (int s = 0; s < 1000; ++s) fluid.step();
    velocity.push_back(fields(fluid).velocity);
  }
  for (const std::size_t single : {1, 2}) {
    double difference = 0;
    for (std::size_t n = 0; n < velocity[0].size(); ++n) {
      difference = std::max(difference, std::abs(velocity[0][n] - velocity[single][n]));
    }
    EXPECT_GT(difference, 0);
    EXPECT_LT(difference, 1e-5 * d.maximum);
  }
}

// Rounding that leans to one side is a force: a factor of the momentum that is rounded, by 3e-8,
// comes to 3e-5 of what 2000 steps give a fluid that is free to move.
TEST(Precision, SingleLeansToNeitherSide) {
  for (const double tau : {1.0, 0.8, 0.6}) {
    for (const Collision collision : {Collision::bgk, Collision::trt}) {
      Options o;
      o.nodes = {12, 10, 16};
      o.tau = tau;
      o.collision = collision;
      o.force = {1e-5, 2e-5, -3e-5};
      o.storage = o.arithmetic = Precision::single_precision;
      Fluid fluid(MPI_COMM_WORLD, o);
      fluid.initialise([](int i, int j, int k) {
        NodeState s;
        s.velocity = 0.01 * Eigen::Vector3d(std::sin(j + 0.4 * k), std::cos(k - 2), std::sin(i));
        return s;
      });
      const Totals before = fluid.totals();
      constexpr int steps = 2000;
      for (int s = 0; s < steps; ++s) fluid.step();
      const Totals after = fluid.totals();
      const double nodes = 12 * 10 * 16;
      const Eigen::Vector3d gained = (after.momentum - before.momentum) / (nodes * steps);
      EXPECT_LT((gained - o.force).norm(), 1e-5 * o.force.norm()) << tau;
      EXPECT_NEAR(after.mass / nodes, before.mass / nodes, 2e-7) << tau;
    }
  }
}

}  // namespace
