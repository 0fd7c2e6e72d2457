// Films between spheres, against lubrication theory and in a fluid of one line.
#include "ductile/rigid/lubrication.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using Eigen::Vector3d;
using std::numbers::pi;
using namespace ductile::rigid;

constexpr double eta = 0.2;
constexpr std::array<double, 2> nowhere{0, 0};

// Leading terms of Jeffrey & Onishi's X^A for equal spheres, and of Kim & Karrila's for any.
TEST(Film, ResistsAsLubricationTheorySays) {
  const double a = 5;
  // R h -> 6 pi eta (a b/(a + b))^2
  for (const double b : {5.0, 8.0, 20.0}) {
    const double reduced = a * b / (a + b);
    EXPECT_NEAR(1e-7 * film_resistance(a, b, 1e-7, eta) / (6 * pi * eta * reduced * reduced), 1,
                1e-4);
    EXPECT_NEAR(film_resistance(a, b, 0.1, eta), film_resistance(b, a, 0.1, eta), 1e-12);
  }
  // The second term of equal spheres, 9/40 ln(a/h): what is left, less its value elsewhere.
  const auto left = [&](double h) {
    return film_resistance(a, a, h, eta) / (6 * pi * eta * a) - a / 4 / h -
           a / 4 * 2 / film_reach * std::log(h);
  };
  EXPECT_NEAR(left(1e-5) - left(1e-3), 9.0 / 40 * std::log(100), 1e-3);
  // It begins with neither a step nor a slope, and grows as the film gets thinner.
  EXPECT_EQ(film_resistance(a, a, film_reach, eta), 0);
  EXPECT_LT(film_resistance(a, a, film_reach - 1e-3, eta), 1e-6 * eta * a);
  for (int n = 1; n < 248; ++n) {
    const double h = 0.01 * n;
    EXPECT_GT(film_resistance(a, a, h, eta), film_resistance(a, a, h + 0.01, eta));
  }
}

constexpr double gap = 0.3;

SphereMotion at(const Vector3d& position) {
  return {position, Vector3d::Zero(), Vector3d::Zero()};
}

// Forces and torques of two prescribed spheres by all of their velocities and spins.
Eigen::Matrix<double, 12, 12> resistance(double a, double b, const Vector3d& line) {
  Lubrication films({{a, 0}, {b, 0}}, eta, nowhere);
  Eigen::Matrix<double, 12, 12> matrix;
  for (int k = 0; k < 12; ++k) {
    std::vector<SphereMotion> motions{at((a + b + gap) * line), at({0, 0, 0})};
    SphereMotion& moved = motions[k / 6];
    (k % 6 < 3 ? moved.velocity : moved.angular_velocity)[k % 3] = 1;
    const auto found = films.forces(motions);
    for (int s = 0; s < 2; ++s) {
      matrix.block<3, 1>(6 * s, k) = -found[s].force;
      matrix.block<3, 1>(6 * s + 3, k) = -found[s].torque;
    }
  }
  return matrix;
}

// Reciprocity, dissipation, Newton's third law; a pair that moves as one body has no film at work
// but for what the shear terms leave out, of the order of h/a.
TEST(Film, TakesEnergyAndNoMomentum) {
  const Vector3d line = Vector3d(1, -2, 3).normalized();
  for (const auto& [a, b] : {std::pair{5.0, 5.0}, {4.0, 9.0}}) {
    const auto R = resistance(a, b, line);
    const double size = R.norm();
    EXPECT_LT((R - R.transpose()).norm(), 1e-14 * size);
    const Eigen::Vector<double, 12> eigenvalues =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 12, 12>>(R).eigenvalues();
    EXPECT_GT(eigenvalues[0], -1e-13 * size);
    EXPECT_LT((R.topRows<3>() + R.middleRows<3>(6)).norm(), 1e-14 * size);
    EXPECT_GT(R.topRows<3>().norm(), 1);
    const Vector3d spin = Vector3d(0.3, 0.5, -0.2);
    const Vector3d drift(0.1, 0, 0.2);
    Eigen::Vector<double, 12> together;
    together << drift + spin.cross((a + b + gap) * line), spin, drift, spin;
    Eigen::Vector<double, 12> apart = together;
    apart.segment<3>(9) *= -1;
    EXPECT_LT((R * together).norm(), 2 * gap / a * (R * apart).norm());
    // Twist about the line of centres meets none.
    Eigen::Vector<double, 12> twist = Eigen::Vector<double, 12>::Zero();
    twist.segment<3>(3) = line;
    EXPECT_LT((R * twist).norm(), 1e-13 * size);
  }
}

// A sphere beside a plane, which is one of infinite radius: Goldman, Cox & Brenner 1967, Chem. Eng.
// Sci. 22, 637. What a gap of 1/100 adds to one of 1/10 is their coefficient times ln(10), but for
// the cut.
TEST(Film, BesideAPlaneHasItsKnownCoefficients) {
  const double a = 3;
  const double b = 1e7;
  const auto matrix = [&](double h) {
    Lubrication films({{a, 0}, {b, 0, 1e-12}}, eta, nowhere);
    std::array<double, 3> found{};
    for (int k = 0; k < 2; ++k) {
      std::vector<SphereMotion> motions{at({0, 0, 0}), at({0, 0, -(a + b + h)})};
      (k == 0 ? motions[0].velocity : motions[0].angular_velocity) = {k == 0 ? 1. : 0., k * 1., 0};
      const FilmForce film = films.forces(motions)[0];
      if (k == 0) {
        found[0] = -film.force.x() / (6 * pi * eta * a);
        found[1] = film.torque.y() / (8 * pi * eta * a * a);
      } else {
        found[2] = -film.torque.y() / (8 * pi * eta * a * a * a);
      }
    }
    return found;
  };
  const auto near = matrix(0.01);
  const auto far = matrix(0.1);
  const double more = std::log(10) - 0.09 / shear_reach;
  EXPECT_NEAR(near[0] - far[0], 8.0 / 15 * more, 1e-5);
  EXPECT_NEAR(near[1] - far[1], 1.0 / 10 * more, 1e-5);
  EXPECT_NEAR(near[2] - far[2], 2.0 / 5 * more, 1e-5);
}

// Spheres that nothing but their mass, 1/mobility, keeps from going where a force pushes them.
struct Bodies {
  std::vector<SphereMotion> motions;
  std::vector<Vector3d> push;
  double mobility;  // what the fluid really gives

  void step(Lubrication& films) {
    const auto forces = films.forces(motions);
    films.accept();
    for (std::size_t n = 0; n < motions.size(); ++n) {
      motions[n].velocity += mobility * (push[n] + forces[n].force);
      motions[n].position += motions[n].velocity;
    }
  }
};

// Whatever the body's answer is, of those that film_mobility() stands for: the film gets thinner as
// h' = -2 F/(2 R), and the spheres come to rest at the gap at which they touch.
TEST(Film, GetsThinnerAsTheoryHasItAndIsNeverCrossed) {
  const double a = 5;
  const double m = 0.002;
  for (const double real : {0.6 * m, 0.8 * m, m}) {
    Lubrication films({{a, m}, {a, m}}, eta, nowhere);
    const double h = 0.8;
    const double force = 0.02;
    Bodies bodies{{at({0, 0, 0}), at({0, 0, 2 * a + h})}, {{0, 0, force}, {0, 0, -force}}, real};
    const auto gap_now = [&] {
      return bodies.motions[1].position.z() - bodies.motions[0].position.z() - 2 * a;
    };
    double least = h;
    double before = h;
    int compared = 0;
    for (int n = 0; n < 60000; ++n) {
      bodies.step(films);
      const double now = gap_now();
      least = std::min(least, now);
      if (now < 0.25 && now > 0.02 && n % 20 == 0) {  // their inertia matters before
        const double rate = before - now;
        EXPECT_NEAR(rate * film_resistance(a, a, now, eta) / force, 1, 0.03) << real << ' ' << now;
        ++compared;
      }
      before = now;
    }
    EXPECT_GT(compared, 20);
    EXPECT_NEAR(gap_now(), usual_roughness * a, 1e-4) << real;
    EXPECT_GT(least, 0.98 * usual_roughness * a) << real;
    // Let go, they part as slowly as the film fills again.
    for (Vector3d& push : bodies.push) push *= -1;
    for (int n = 0; n < 20000; ++n) bodies.step(films);
    EXPECT_GT(gap_now(), 0.5);
  }
}

// A train that is pressed from both ends, and a ring across the periodic end.
TEST(Film, KeepsManySpheresApart) {
  const double a = 4;
  const double m = 0.003;
  std::vector<Lubrication::Sphere> spheres(5, {a, m});
  Lubrication films(spheres, eta, nowhere);
  Bodies train{{}, std::vector<Vector3d>(5, Vector3d::Zero()), 0.7 * m};
  for (int n = 0; n < 5; ++n) train.motions.push_back(at({0, 0, n * (2 * a + 0.2)}));
  train.push.front() = {0, 0, 0.05};
  train.push.back() = {0, 0, -0.05};
  for (int n = 0; n < 20000; ++n) train.step(films);
  for (int n = 1; n < 5; ++n) {
    const double left = train.motions[n].position.z() - train.motions[n - 1].position.z() - 2 * a;
    EXPECT_NEAR(left, usual_roughness * a, 1e-4);
  }

  Lubrication ring({{a, m}, {a, m}}, eta, {0, 17});
  // Apart by 0.5 across the end.
  Bodies pair{
      {at({0, 0, 1}), at({0, 0, 17 + 1 - 2 * a - 0.5})}, {{0, 0, -0.02}, {0, 0, 0.02}}, 0.7 * m};
  for (int n = 0; n < 5000; ++n) pair.step(ring);
  const double across = pair.motions[0].position.z() + 17 - pair.motions[1].position.z() - 2 * a;
  EXPECT_GT(across, 0.98 * usual_roughness * a);
  EXPECT_LT(across, 0.5);
}

// Whatever the order of the spheres, and whichever images they are in: each film once.
TEST(Film, AreFoundAcrossThePeriodicEnds) {
  const std::array<double, 2> periods{14, 40};
  const double a = 4;
  const auto count = [&](const std::vector<Vector3d>& centres) {
    Lubrication films(std::vector<Lubrication::Sphere>(centres.size(), {a, 0}), eta, periods);
    std::vector<SphereMotion> motions;
    for (const Vector3d& x : centres) {
      // Towards the first, at a speed that no two have.
      motions.push_back(at(x));
      motions.back().velocity = {0, 0, 1e-3 * static_cast<double>(motions.size())};
    }
    int felt = 0;
    Vector3d sum = Vector3d::Zero();
    for (const FilmForce& film : films.forces(motions)) {
      felt += film.force.norm() > 0 ? 1 : 0;
      sum += film.force;
    }
    EXPECT_LT(sum.norm(), 1e-15);
    return felt;
  };
  EXPECT_EQ(count({{0, 0, 1}, {0, 0, 10}}), 2);
  EXPECT_EQ(count({{0, 0, 1}, {0, 0, 12}}), 0);     // a gap of 3
  EXPECT_EQ(count({{0, 0, 1}, {0, 0, 33}}), 2);     // by the end along z, a gap of 0
  EXPECT_EQ(count({{0, 0, -39}, {0, 0, 153}}), 2);  // the same, in other images
  EXPECT_EQ(count({{0, 0, 3}, {0, 13, 11}}), 2);    // across y
  EXPECT_EQ(count({{0, 0, 3}, {0, 7, 11}}), 0);
  EXPECT_EQ(count({{0, 0, 20}, {9, 0, 20}, {0, 0, 29}, {0, 0, 2}}), 3);
  // In a ring no longer than two of them each has two films with the other, which balance.
  Lubrication ring({{a, 0}, {a, 0}}, eta, {0, 2 * (2 * a + 0.5)});
  std::vector<SphereMotion> motions{at({0, 0, 3}), at({0, 0, 11.5})};
  motions[1].velocity = {0.001, 0, 0};
  const auto both = ring.forces(motions);
  Lubrication open({{a, 0}, {a, 0}}, eta, nowhere);
  EXPECT_NEAR(both[0].force.x(), 2 * open.forces(motions)[0].force.x(), 1e-15);
}

TEST(Film, SpheresThatStartTooNearArePushedApartSlowly) {
  const double a = 4;
  const double m = 0.003;
  Lubrication films({{a, m, 0.01}, {a, m, 0.02}}, eta, nowhere);
  Bodies pair{{at({0, 0, 0}), at({0, 0, 2 * a - 0.5})}, {2, Vector3d::Zero()}, 0.8 * m};
  for (int n = 0; n < 400; ++n) {
    pair.step(films);
    for (const SphereMotion& motion : pair.motions) EXPECT_LT(motion.velocity.norm(), 0.06);
  }
  const double left = pair.motions[1].position.z() - pair.motions[0].position.z() - 2 * a;
  EXPECT_NEAR(left, 0.015 * a, 1e-3);
}

TEST(Film, GoesOnFromASavedStateToTheLastBit) {
  const double a = 5;
  const double m = 0.002;
  const std::vector<Lubrication::Sphere> spheres{{a, m}, {a, m}};
  Lubrication straight(spheres, eta, nowhere);
  Bodies bodies{{at({0, 0, 0}), at({0, 1, 2 * a})}, {{0, 0, 0.02}, {0, 0, -0.02}}, m};
  for (int n = 0; n < 50; ++n) bodies.step(straight);
  std::map<std::string, std::vector<double>, std::less<>> store;
  straight.save([&](std::string_view name, std::span<const double> numbers) {
    store[std::string(name)].assign(numbers.begin(), numbers.end());
  });
  Lubrication resumed(spheres, eta, nowhere);
  resumed.load([&](std::string_view name, std::span<double> numbers) {
    std::ranges::copy(store.find(name)->second, numbers.begin());
  });
  Bodies copy = bodies;
  for (int n = 0; n < 20; ++n) {
    bodies.step(straight);
    copy.step(resumed);
    EXPECT_EQ(bodies.motions[1].position, copy.motions[1].position);
  }
  // A step that was refused, and a load that was, leave no trace.
  (void)straight.forces(std::vector<SphereMotion>(2, at({0, 0, 0.5})));
  EXPECT_THROW(straight.load([](std::string_view, std::span<double> numbers) { numbers[0] = NAN; }),
               std::invalid_argument);
  EXPECT_THROW(
      straight.load([](std::string_view, std::span<double>) { throw std::runtime_error("none"); }),
      std::runtime_error);
  bodies.step(straight);
  copy.step(resumed);
  EXPECT_EQ(bodies.motions[1].position, copy.motions[1].position);
}

TEST(Film, RefusesWhatIsOutOfBounds) {
  EXPECT_THROW(Lubrication({{0, 1}}, eta, nowhere), std::invalid_argument);
  EXPECT_THROW(Lubrication({{1, -1}}, eta, nowhere), std::invalid_argument);
  EXPECT_THROW(Lubrication({{1, 1, 0}}, eta, nowhere), std::invalid_argument);
  EXPECT_THROW(Lubrication({{1, 1}}, 0, nowhere), std::invalid_argument);
  EXPECT_THROW(Lubrication({{1, 1}}, eta, {0, -5}), std::invalid_argument);
  Lubrication films({{4, 0.1}, {4, 0.1}}, eta, nowhere);
  const std::vector<SphereMotion> one{at({0, 0, 0})};
  EXPECT_THROW(films.forces(one), std::invalid_argument);
}

// A layer of fluid and what the body is heavier than the fluid, and half as much again.
TEST(Film, MobilityIsThatOfTheLayerOfFluidAndTheExcessMass) {
  EXPECT_DOUBLE_EQ(film_mobility(100, 0), 1.5 / 260);
  EXPECT_DOUBLE_EQ(film_mobility(100, 240), 1.5 / 500);
}

}  // namespace
