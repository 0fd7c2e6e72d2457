// Integrators in the paper's channel: agreement where all are stable, and stiff capsules.
#include <tuple>

#include "validation/integrator_agreement.hpp"

namespace {

using namespace ductile;

TEST(IntegratorsInThePapersChannel, AgreeForASoftCapsule) {
  test::expect_agreement(36, 6, 10, 5);
}
TEST(IntegratorsInThePapersChannel, AgreeForAStiffCapsule) {
  test::expect_agreement(36, 6, 100, 5);
}

/// Any stiffness, one body or a pair, any shape, and a volume modulus at which explicit schemes
/// fail on so coarse a lattice. A solve that does not converge throws.
class Stiff : public testing::TestWithParam<std::tuple<double, bool, bool>> {};
std::string label(const testing::TestParamInfo<std::tuple<double, bool, bool>>& tested) {
  return "La1e" + std::to_string(std::lround(std::log10(std::get<0>(tested.param)))) +
         (std::get<2>(tested.param) ? "Biconcave" : "Sphere") +
         (std::get<1>(tested.param) ? "Pair" : "");
}
INSTANTIATE_TEST_SUITE_P(Capsules, Stiff,
                         testing::Combine(testing::Values(1e3, 1e4, 1e5, 1e6), testing::Bool(),
                                          testing::Bool()),
                         label);

TEST_P(Stiff, StaysStableAndKeepsItsVolume) {
  const auto [laplace, pair, biconcave] = GetParam();
  const std::string softness = "laplace = " + std::to_string(laplace) + "\n";
  const std::string shape = biconcave ? "shape = \"biconcave\"\n" : "";
  std::string text =
      "[channel]\nnodes = 24\nlength = 6\n[membrane]\nvolume_modulus = 75000\nintegrator = "
      "\"implicit\"\n[[body]]\nx = 0.2\nz = 0.5\n" +
      softness + (pair ? "" : shape);
  if (pair) text += "[[body]]\nx = -0.2\nz = -0.5\n" + softness + shape;
  test::Channel channel(text);
  for (const double time : {.25, .5, .75, 1.}) {
    channel.run(time);
    for (std::size_t b = 0; b < (pair ? 2U : 1U); ++b) {
      const suspension::BodySample sample = channel.sample(b);
      EXPECT_LT(std::abs(sample["volume_error"]), .01);
      EXPECT_LT(sample.velocity().norm(), channel.largest_velocity());
      // Strain energies are those of the flow's stress, not of an instability: they go as 1/La.
      EXPECT_LT(sample["strain_energy"] * laplace, .05);
    }
  }
}

/// Capsules whose kernels overlap answer each other within the step.
TEST(NearContact, StiffCapsulesStayStableWithinEachOthersKernel) {
  for (const char* integrator : {"semi-implicit", "implicit"}) {
    for (const double laplace : {1e4, 1e5, 1e6}) {
      if (laplace > 1e5 && std::string(integrator) == "semi-implicit")
        continue;  // beyond its range
      const std::string softness = "laplace = " + std::to_string(laplace) + "\n";
      // A gap of 1.44 spacings.
      std::string text = "[channel]\nnodes = 24\nlength = 4\n[membrane]\nintegrator = \"";
      text.append(integrator).append("\"\n");
      for (const char* z : {"0.46", "-0.46"})
        text.append("[[body]]\nx = 0.2\nz = ").append(z).append("\n").append(softness);
      test::Channel channel(text);
      channel.run(.5);
      for (const std::size_t body : {0U, 1U}) {
        const suspension::BodySample sample = channel.sample(body);
        EXPECT_LT(std::abs(sample["volume_error"]), .01) << integrator << ", La = " << laplace;
        EXPECT_LT(sample["strain_energy"] * laplace, .05) << integrator << ", La = " << laplace;
      }
    }
  }
}

}  // namespace
