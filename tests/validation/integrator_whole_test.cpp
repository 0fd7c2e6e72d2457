// Integrators in the channel, in short.
#include "ductile/coupling/coupler.hpp"
#include "validation/integrator_agreement.hpp"

namespace {

using namespace ductile;

TEST(IntegratorsInAChannel, AgreeOnACoarseLattice) {
  test::expect_agreement(16, 3, 100, 1);
}

TEST(IntegratorsInAChannel, StiffCapsuleMovesAsTheRigidSphere) {
  // Two methods that share nothing but the kernel. Strain is 1e-5 at La = 10^5; the rest is the
  // rigid body's own slip (5 corrections).
  const std::string channel = "[channel]\nnodes = 16\nlength = 3\n";
  test::Channel stiff(channel +
                      "[membrane]\nintegrator = \"implicit\"\n[[body]]\nx = 0.2\nlaplace = 1e5\n");
  test::Channel rigid(channel + "[[body]]\nkind = \"rigid\"\nx = 0.2\n");
  stiff.run(1);
  rigid.run(1);
  std::printf("x = %.5f, rigid %.5f\n", stiff.sample(0).position().x(),
              rigid.sample(0).position().x());
  EXPECT_NEAR(stiff.sample(0).position().x(), rigid.sample(0).position().x(), .002);
  EXPECT_NEAR(stiff.sample(0).velocity().z(), rigid.sample(0).velocity().z(),
              .005 * rigid.largest_velocity());
}

// What round-off does to the symmetry of so stiff a membrane is answered by the fluid as the
// capsule expects, also where half of the channel stands for the whole.
TEST(IntegratorsInAChannel, StiffCapsuleMovesInHalfOfItAsInTheWhole) {
  const auto scenario = [](int nodes, const char* symmetry, const char* precision) {
    return "[channel]\nlength = 3\nnodes = " + std::to_string(nodes) + "\nsymmetry = \"" +
           symmetry + "\"\n[fluid]\nstorage = \"" + precision +
           "\"\n[membrane]\nintegrator = \"implicit\"\n[[body]]\nx = 0.2\nlaplace = 1e5\n";
  };
  // The plane on nodes and between them; what is round-off to the one and the other.
  for (const auto& [nodes, precision, round_off] : {std::tuple(17, "double", 1e-12),
                                                    {24, "double", 1e-12},
                                                    {17, "single", 1e-11},
                                                    {24, "single", 1e-11}}) {
    test::Channel whole(scenario(nodes, "none", precision));
    test::Channel half(scenario(nodes, "y", precision));
    whole.run(.5);
    half.run(.5);
    EXPECT_NEAR(half.sample(0).position().x(), whole.sample(0).position().x(), 1e-7);
    EXPECT_NEAR(half.sample(0).velocity().z(), whole.sample(0).velocity().z(),
                1e-7 * whole.largest_velocity());
    EXPECT_NEAR(half.sample(0).position().y(), 0, round_off) << precision;
  }
}

TEST(IntegratorsInAChannel, ImplicitRunsWhereExplicitBlowsUp) {
  const auto scenario = [](const char* integrator) {
    return std::string("[channel]\nnodes = 16\nlength = 3\n[membrane]\nvolume_modulus = 75000\n") +
           "integrator = \"" + integrator + "\"\n[[body]]\nx = 0.2\nlaplace = 1e4\n";
  };
  test::Channel explicit_run(scenario("explicit-euler"));
  EXPECT_THROW(explicit_run.run(1), coupling::BodyFailure);
  for (const char* integrator : {"semi-implicit", "implicit"}) {
    test::Channel channel(scenario(integrator));
    channel.run(1);
    EXPECT_LT(std::abs(channel.sample(0)["volume_error"]), 1e-4) << integrator;
  }
}

}  // namespace
