// Capsules in fluids of a few lines: the protocol of a step, the explicit scheme, and its mobility.
#include "ductile/membrane/capsule.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "membrane/linear_fluid.hpp"
#include "membrane/support.hpp"

namespace ductile::membrane {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::LinearFluid;
using test::Points;

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr Moduli soft{.k_s = .02, .k_a = .04, .k_b = 1e-3, .k_v = .1};
const CapsuleOptions with_mobility{.mobility = 1e-3, .viscosity = 1. / 6};
const CapsuleOptions without_mobility{.mobility = 0};

std::vector<double> copy(std::span<const double> numbers) {
  return {numbers.begin(), numbers.end()};
}

class CapsuleInFluid : public testing::Test {
 protected:
  const Mesh sphere_ = icosphere(5, 5);
  Points placed(const Matrix3d& map) const {
    return test::moved(sphere_.vertices, map, {10, 11, 12});
  }
  const Points at_rest_ = placed(Matrix3d::Identity());
  const Points stretched_ = placed(Vector3d(1.2, .9, 1).asDiagonal());
};

TEST_F(CapsuleInFluid, MovesWithAUniformFlowUndeformed) {
  Capsule capsule(sphere_, at_rest_, soft, with_mobility);
  const LinearFluid fluid{.flow = {.01, -.02, .05}, .drag = 1};
  const int steps = 1000;
  for (int n = 0; n < steps; ++n) fluid.step(capsule);
  // Rounding of positions of size 50, step by step.
  const double tolerance = steps * 50 * eps;
  for (int i = 0; i < capsule.vertex_count(); ++i) {
    const Vector3d x = Vector3d::Map(&capsule.positions()[3 * i]);
    EXPECT_LT((x - at_rest_[i] - steps * fluid.flow).norm(), tolerance);
    EXPECT_LT((Vector3d::Map(&capsule.velocities()[3 * i]) - fluid.flow).norm(), tolerance);
  }
  // Round-off in the invariants, over the sphere; the stretched capsule below has 6% of k_s a^2.
  EXPECT_NEAR(capsule.energies().total(), 0, 100 * eps * soft.k_s * area(sphere_));
  EXPECT_LT(std::abs(capsule.volume_error()), tolerance);
  EXPECT_LT((capsule.shape().centroid - Vector3d(20, -9, 62)).norm(), tolerance);
}

TEST_F(CapsuleInFluid, RelaxesToItsReferenceWithFallingEnergy) {
  for (const StrainLaw law : {StrainLaw::skalak, StrainLaw::neo_hookean}) {
    Moduli moduli = soft;
    moduli.law = law;
    Capsule capsule(sphere_, stretched_, moduli, without_mobility);
    const LinearFluid fluid{.drag = 5};
    const double initial = capsule.energies().total();
    EXPECT_GT(capsule.shape().taylor_deformation(), .14);
    double before = initial;
    for (int n = 0; n < 2000; ++n) {
      fluid.step(capsule);
      const double energy = capsule.energies().total();
      ASSERT_LT(energy, before) << "step " << n;
      before = energy;
    }
    EXPECT_LT(before, 1e-3 * initial);
    EXPECT_LT(capsule.shape().taylor_deformation(), .01);
  }
}

TEST_F(CapsuleInFluid, MobilityRelaxesStrainThatTheFluidDoesNotSee) {
  const LinearFluid still{};
  Capsule pure(sphere_, stretched_, soft, without_mobility);
  const std::vector<double> start = copy(pure.positions());
  for (int n = 0; n < 10; ++n) still.step(pure);
  EXPECT_EQ(copy(pure.positions()), start);

  Capsule slipping(sphere_, stretched_, soft, with_mobility);
  const double initial = slipping.energies().total();
  still.step(slipping);
  // v = eps F, eps A = mobility/eta = .006.
  const std::vector<double> areas = vertex_areas(sphere_);
  for (int i = 0; i < slipping.vertex_count(); ++i) {
    const Vector3d expected = .006 / areas[i] * Vector3d::Map(&slipping.forces()[3 * i]);
    const Vector3d v = Vector3d::Map(&slipping.velocities()[3 * i]);
    EXPECT_LT((v - expected).norm(), 1e-14 * expected.norm());
    const Vector3d x = Vector3d::Map(&slipping.positions()[3 * i]);
    EXPECT_LT((x - stretched_[i] - v).norm(), 1e-14);
  }
  double before = slipping.energies().total();
  EXPECT_LT(before, initial);
  for (int n = 0; n < 200; ++n) {
    still.step(slipping);
    const double energy = slipping.energies().total();
    ASSERT_LT(energy, before) << "step " << n;
    before = energy;
  }
}

TEST_F(CapsuleInFluid, PreInflatedPushesInwardAsItsReferenceAsks) {
  // Reference radius 5, started at l = 1.05: p a/k_s = .3667881 for C = 2, less 0.5% for the mesh.
  const Mesh sphere = icosphere(16, 5);
  const Points inflated = test::moved(sphere.vertices, 1.05 * Matrix3d::Identity(), {0, 0, 0});
  Capsule capsule(sphere, inflated, {.k_s = .02, .k_a = .04}, without_mobility);
  EXPECT_NEAR(capsule.volume_error(), std::pow(1.05, 3) - 1, 1e-12);
  std::vector<double> force(capsule.positions().size());
  capsule.predict_force(force);
  EXPECT_EQ(force, copy(capsule.forces()));
  double work = 0;
  for (std::size_t i = 0; i < inflated.size(); ++i) {
    const Vector3d f = Vector3d::Map(&force[3 * i]);
    EXPECT_LT(f.dot(inflated[i]), 0) << "vertex " << i << " is pushed outward";
    work += f.dot(inflated[i]);
  }
  const double pressure = -work / (3 * capsule.shape().volume);
  EXPECT_NEAR(pressure, .3667881 * .02 / 5, .005 * .3667881 * .02 / 5);
}

/// Asks the fluid's response which force would stop the flow, and gives it.
class HoldStill final : public Integrator {
 public:
  [[nodiscard]] int corrections() const override { return 1; }
  void predict_force(const State& /*state*/, Vec force) override { VecZeroEntries(force); }
  void correct_force(const State& state, Vec fluid_velocity, const Response& response,
                     Vec increment) override {
    PetscReal norm = 1;
    VecNorm(state.forces.get(), NORM_INFINITY, &norm);
    EXPECT_EQ(norm, 0);
    const VecArray<const double> u(fluid_velocity);
    const std::vector<double> unit(u.size(), 1);
    std::vector<double> answer(u.size());
    response(unit, answer);
    const VecArray<double> f(increment);
    for (std::size_t k = 0; k < u.size(); ++k) f[k] = -u[k] / answer[k];
  }
  void advance(const State& /*state*/, Vec fluid_velocity, Vec velocity) override {
    VecCopy(fluid_velocity, velocity);
  }
};

TEST_F(CapsuleInFluid, SchemeMayCorrectItsForceByTheFluidsResponse) {
  const CapsuleOptions options{
      .mobility = 0, .integrator = [](const Shell&, Vec) { return std::make_unique<HoldStill>(); }};
  Capsule capsule(sphere_, at_rest_, soft, options);
  const std::vector<double> start = copy(capsule.positions());
  const LinearFluid fluid{.flow = {.25, 0, -.125}, .drag = .5};
  fluid.step(capsule);
  EXPECT_EQ(copy(capsule.positions()), start);
  EXPECT_EQ(capsule.forces()[0], -.5);
  EXPECT_EQ(capsule.forces()[2], .25);
}

TEST_F(CapsuleInFluid, ExplicitSchemeMakesNoCorrections) {
  Capsule capsule(sphere_, at_rest_, soft, with_mobility);
  EXPECT_EQ(capsule.corrections(), 0);
  std::vector<double> u(capsule.positions().size()), increment = u;
  EXPECT_THROW(capsule.correct_force(u, {}, increment), std::logic_error);
}

class FailedStep : public CapsuleInFluid {
 protected:
  Capsule capsule_{sphere_, stretched_, soft, with_mobility};
  std::vector<double> force_ = std::vector<double>(capsule_.positions().size());
  std::vector<double> velocity_ = force_;

  void SetUp() override {
    LinearFluid{.flow = {.1, 0, 0}, .drag = 1}.step(capsule_);
    capsule_.predict_force(force_);
    velocity_.assign(force_.size(), .01);
  }
  // What advance() throws, having left the state alone.
  VertexFailure thrown() {
    const std::vector<double> x = copy(capsule_.positions()), v = copy(capsule_.velocities()),
                              f = copy(capsule_.forces());
    try {
      capsule_.advance(velocity_);
    } catch (const VertexFailure& failure) {
      EXPECT_EQ(copy(capsule_.positions()), x);
      EXPECT_EQ(copy(capsule_.velocities()), v);
      EXPECT_EQ(copy(capsule_.forces()), f);
      return failure;
    }
    throw std::runtime_error("no VertexFailure");
  }
};

TEST_F(FailedStep, NamesTheVertexThatIsTooFast) {
  velocity_[3 * 17 + 1] = 2;
  const VertexFailure failure = thrown();
  EXPECT_EQ(failure.reason(), VertexFailure::Reason::too_fast);
  EXPECT_EQ(failure.vertex(), 17);
  EXPECT_NEAR(failure.displacement(), 2, .01);
  test::expect_contains(failure.what(), "vertex 17 moves 2.0");
}

TEST_F(FailedStep, NamesTheVertexWhoseVelocityIsNotFinite) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    velocity_[3 * 23 + 2] = bad;
    const VertexFailure failure = thrown();
    EXPECT_EQ(failure.reason(), VertexFailure::Reason::velocity_not_finite);
    EXPECT_EQ(failure.vertex(), 23);
    test::expect_contains(failure.what(), "velocity of vertex 23 is not finite");
  }
}

TEST_F(FailedStep, LeavesTheCapsuleAbleToGoOn) {
  velocity_[0] = 2;
  thrown();
  velocity_[0] = .01;
  const double before = capsule_.positions()[0];
  capsule_.advance(velocity_);
  EXPECT_NEAR(capsule_.positions()[0] - before, .01, 1e-3);
}

TEST_F(CapsuleInFluid, CollapsedTriangleIsAFailure) {
  Points flat = at_rest_;
  const auto& [a, b, c] = sphere_.triangles[9];
  flat[a] = flat[b];
  Capsule capsule(sphere_, flat, soft, with_mobility);
  std::vector<double> force(3 * flat.size());
  try {
    capsule.predict_force(force);
    FAIL() << "no VertexFailure";
  } catch (const VertexFailure& failure) {
    EXPECT_EQ(failure.reason(), VertexFailure::Reason::force_not_finite);
    EXPECT_LT((at_rest_[failure.vertex()] - at_rest_[a]).norm(), 3 * mean_edge(sphere_));
  }
}

TEST_F(CapsuleInFluid, RefusesWhatItCannotBe) {
  using test::expect_contains;
  using test::refusal;
  const auto made = [&](const Points& x, const CapsuleOptions& options) {
    return refusal([&] { const Capsule capsule(sphere_, x, soft, options); });
  };
  expect_contains(made({at_rest_.begin(), at_rest_.end() - 1}, with_mobility),
                  "251 positions for a reference of 252 vertices");
  Points nowhere = at_rest_;
  nowhere[8][1] = std::nan("");
  expect_contains(made(nowhere, with_mobility), "position of vertex 8 is not finite");
  const auto moving = [&](const Points& v) {
    return refusal([&] { const Capsule capsule(sphere_, at_rest_, soft, with_mobility, v); });
  };
  expect_contains(moving(nowhere), "velocity of vertex 8 is not finite");
  expect_contains(moving(Points(7)), "7 velocities for a reference of 252 vertices");
  expect_contains(made(at_rest_, {.mobility = -1, .viscosity = 1}), "mobility -1.0");
  expect_contains(made(at_rest_, {.mobility = .1, .viscosity = 0}), "viscosity 0.0");

  Capsule capsule(sphere_, at_rest_, soft, with_mobility);
  std::vector<double> few(10);
  expect_contains(refusal([&] { capsule.predict_force(few); }), "10 numbers where 756");
  expect_contains(refusal([&] { capsule.advance(few); }), "10 numbers where 756");
}

}  // namespace
}  // namespace ductile::membrane
