// A run inside of another program: what it leaves behind is in its directory, and nowhere else.
#include "run/run.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "checks/read_case.hpp"
#include "run/blow_up.hpp"
#include "run/signals.hpp"
#include "scenario/writer.hpp"
#include "support/temporary_directory.hpp"

namespace ductile::drivers {
namespace {

namespace fs = std::filesystem;

extern "C" void somebody_elses(int /*signal*/) {}

class Run : public testing::Test {
 protected:
  RunResult run(const Case& given) {
    return run_case(given, {directory_, resolved_toml(given.scenario), true, false},
                    PETSC_COMM_WORLD);
  }
  testing_support::TemporaryDirectory temporary_;
  const fs::path& directory_ = temporary_.path();
};

const std::string small_case = R"(
channel.nodes = 16
channel.length = 4
run.time_limit = 0.02
output.every = 0.01
petsc.membrane_ksp_rtol = 0.02
petsc.nobody_reads_this = 1
[[body]]
laplace = 1000
radius = 0.3
integrator = "implicit"
)";

TEST_F(Run, LeavesSignalHandlersAndPetscOptionsAsTheyWere) {
  std::signal(SIGTERM, somebody_elses);
  const RunResult result = run(parse_case(small_case, "small.toml"));
  EXPECT_EQ(result.exit_code, exit_success);
  EXPECT_EQ(std::signal(SIGTERM, SIG_DFL), somebody_elses);
  for (const char* option : {"-membrane_ksp_rtol", "-nobody_reads_this"}) {
    PetscBool there = PETSC_TRUE;
    ASSERT_EQ(PetscOptionsHasName(nullptr, nullptr, option, &there), 0);
    EXPECT_EQ(there, PETSC_FALSE) << option;
  }
  ASSERT_TRUE(result.summary);
  ASSERT_EQ(result.summary->warnings.size(), 1U);
  EXPECT_NE(result.summary->warnings[0].find("nobody_reads_this"), std::string::npos);
}

// No body notices what becomes of a fluid that has none: the loop looks every 32 steps.
TEST_F(Run, EndsWhereTheFluidBlowsUp) {
  Case given = parse_case(
      "channel.nodes = 16\nchannel.length = 2\nchannel.reynolds = 1\nrun.time_limit = 5\n",
      "empty.toml");
  given.plan.fluid.force.z() = 1e3;
  const RunResult result = run(given);
  EXPECT_EQ(result.exit_code, exit_blow_up);
  ASSERT_TRUE(result.summary && result.summary->blow_up);
  EXPECT_EQ(result.summary->blow_up->body, "");
  EXPECT_EQ(result.summary->steps % 32, 0);
  EXPECT_LE(result.summary->steps, 320);
}

TEST_F(Run, GivesBackThePetscOptionsThatWereThere) {
  ASSERT_EQ(PetscOptionsSetValue(nullptr, "-membrane_ksp_rtol", "0.03"), 0);
  EXPECT_EQ(run(parse_case(small_case, "small.toml")).exit_code, exit_success);
  PetscReal value = 0;
  PetscBool there = PETSC_FALSE;
  ASSERT_EQ(PetscOptionsGetReal(nullptr, nullptr, "-membrane_ksp_rtol", &value, &there), 0);
  EXPECT_EQ(there, PETSC_TRUE);
  EXPECT_EQ(value, 0.03);
  ASSERT_EQ(PetscOptionsClearValue(nullptr, "-membrane_ksp_rtol"), 0);
}

// As in a comparison: a signal that comes between two runs ends the next one before its first step.
TEST_F(Run, EndsAtASignalThatCameBeforeIt) {
  const Signals signals;
  std::raise(SIGTERM);
  const RunResult result = run(parse_case(small_case, "small.toml"));
  EXPECT_TRUE(result.interrupted);
  EXPECT_EQ(result.exit_code, exit_interrupted);
  ASSERT_TRUE(result.summary);
  EXPECT_EQ(result.summary->steps, 0);
}

TEST_F(Run, TwiceInOneProgramIsTwiceTheSame) {
  const Case given = parse_case(small_case, "small.toml");
  const auto rows = [&] {
    EXPECT_EQ(run(given).exit_code, exit_success);
    std::ifstream file(directory_ / "trajectory.csv");
    return std::string{std::istreambuf_iterator<char>(file), {}};
  };
  const std::string first = rows();
  EXPECT_GT(first.size(), 200U);
  EXPECT_EQ(rows(), first);
}

// Trouble spreads by a node a step to all sides, also across the ends of the channel.
TEST(BlowUpOfTheFluid, IsWhereItBegan) {
  const Case given = parse_case(small_case, "small.toml", {});
  const auto& nodes = given.plan.fluid.nodes;
  const auto size = static_cast<std::size_t>(given.plan.node_count());
  constexpr double way = 7.3;
  for (const int from : {0, 5, nodes[2] - 2}) {
    suspension::FluidState fluid{way, std::vector<double>(size, 1), std::vector<double>(3 * size)};
    for (int i = 3; i <= 7; ++i) {
      for (int j = 4; j <= 6; ++j) {
        for (int k = from - 4; k <= from + 4; ++k) {
          const int node = (i * nodes[1] + j) * nodes[2] + (k + nodes[2]) % nodes[2];
          fluid.velocity[static_cast<std::size_t>(node) + size] = std::nan("");
        }
      }
    }
    const BlowUp found = explained({100, "", std::nullopt, "", {}, {}}, given, {}, fluid, {}, {});
    ASSERT_TRUE(found.place);
    Eigen::Vector3d expected = given.plan.units.position(Eigen::Vector3d(5, 5, from));
    expected.z() += way;
    const double length = given.plan.units.length(given.plan.length());
    expected.z() -= length * std::floor(expected.z() / length + 0.5);
    EXPECT_NEAR((*found.place - expected).norm(), 0, 1e-12) << from;
    EXPECT_FALSE(found.cause.empty());
  }
  const suspension::FluidState all{0, std::vector<double>(size, std::nan("")),
                                   std::vector<double>(3 * size)};
  EXPECT_FALSE(explained({100, "", std::nullopt, "", {}, {}}, given, {}, all, {}, {}).place);
  const std::string fast = std::string(too_fast) + ": at Mach number 0.6";
  EXPECT_EQ(
      explained({100, "", std::nullopt, "", {}, {}}, given, {}, all, {}, {"a word", fast}).cause,
      fast);
}

// A heavy sphere falls onto a light one that rises: they touch where their centres are 2 a apart.
const std::string collision = R"(
channel.nodes = 16
channel.length = 5
channel.reynolds = 0
channel.gravity = [0, 0, -1000]
rigid.retraction = 0.0
run.time_limit = 0.5
run.until_decided = false
output.every = 0.001
[[body]]
name = "heavy"
kind = "rigid"
density_ratio = 2
z = 0.7
[[body]]
name = "light"
kind = "rigid"
density_ratio = 0.5
z = -0.7
)";

TEST_F(Run, EndsWhereSurfacesCross) {
  const RunResult result = run(parse_case(collision, "collision.toml"));
  EXPECT_EQ(result.exit_code, exit_contact);
  ASSERT_TRUE(result.summary);
  const Summary& summary = *result.summary;
  EXPECT_EQ(summary.status, RunStatus::contact);
  EXPECT_LT(summary.time, 0.5);
  ASSERT_EQ(summary.contacts.size(), 1U);
  const ContactSummary& contact = summary.contacts[0];
  EXPECT_EQ(contact.body + " " + contact.other, "heavy light");
  EXPECT_TRUE(contact.crossed);
  EXPECT_EQ(contact.gap, 0);
  EXPECT_EQ(contact.time, summary.time);
  EXPECT_LT(contact.since, contact.time);
  // A row at the very end. From look to look the spheres come nearer by what they move in 32 steps,
  // and their triangles lie up to e^2/(6 a) within them, e = 1.2/8 W.
  ASSERT_EQ(result.samples.back().time, summary.time);
  const auto speed = [&](std::size_t b) { return result.samples.back().bodies[b].velocity().z(); };
  const double between_looks = (speed(1) - speed(0)) * 32 * 3 * (1.0 / 64) / 6;
  constexpr double within = 2 * 0.15 * 0.15 / (6 * 0.4);
  EXPECT_LT(*summary.dz, 0.8);
  EXPECT_GT(*summary.dz, 0.8 - 2 * within - between_looks);
  EXPECT_EQ(std::ranges::count_if(summary.warnings,
                                  [](const std::string& warning) {
                                    return warning.find(
                                               "surfaces of body \"heavy\" and body "
                                               "\"light\" cross") != std::string::npos;
                                  }),
            1);
}

TEST_F(Run, GoesOnAfterACrossingWhereThatIsWanted) {
  const RunResult result =
      run(parse_case(collision, "collision.toml", {{"run.stop_at_contact", "false", "--set"}}));
  EXPECT_EQ(result.exit_code, exit_success);
  ASSERT_TRUE(result.summary);
  EXPECT_EQ(result.summary->status, RunStatus::time_limit);
  EXPECT_LT(*result.summary->dz, 0.7);
  ASSERT_EQ(result.summary->contacts.size(), 1U);
  EXPECT_TRUE(result.summary->contacts[0].crossed);
  EXPECT_LT(result.summary->contacts[0].time, 0.5);
}

// What falls gathers speed: no case can be refused for it.
TEST_F(Run, WarnsOnceOfWhatBecomesTooFastForTheLattice) {
  const std::string stone = R"(
channel.nodes = 16
channel.length = 3
channel.reynolds = 0
channel.gravity = [0, 0, -1500]
run.time_limit = 0.1
output.every = 0.001
body = [{name = "stone", kind = "rigid", density_ratio = 4}]
)";
  const auto warnings = [](const RunResult& result) {
    std::vector<std::string> all;
    for (const std::string& text : result.summary->warnings) {
      if (text.starts_with("too fast for the lattice")) all.push_back(text);
    }
    return all;
  };
  const RunResult falling = run(parse_case(stone, "stone.toml"));
  ASSERT_TRUE(falling.summary);
  // Of the lattice at rest: 3^(1/2) v, a unit of velocity being 1/(6 . 8) of a spacing a step.
  const auto first = std::ranges::find_if(falling.samples, [](const suspension::Sample& sample) {
    return std::sqrt(3.0) * -sample.bodies[0].velocity().z() / 48 > 0.3;
  });
  ASSERT_NE(first, falling.samples.end());
  ASSERT_GT(first, falling.samples.begin() + 2);
  ASSERT_EQ(warnings(falling).size(), 1U);
  EXPECT_NE(warnings(falling)[0].find(fmt::format("at t = {:.4g} ", first->time)),
            std::string::npos)
      << warnings(falling)[0];
  const RunResult slow =
      run(parse_case(stone, "stone.toml", {{"channel.gravity", "[0, 0, -150]", "--set"}}));
  ASSERT_TRUE(slow.summary);
  EXPECT_TRUE(warnings(slow).empty());
}

TEST_F(Run, EndsWhereABodyComesToAWall) {
  const Case given = parse_case(R"(
channel.nodes = 16
channel.length = 3
channel.reynolds = 0
channel.gravity = [1000, 0, 0]
rigid.retraction = 0.0
output.surfaces_every = 0.5
body = [{name = "stone", kind = "rigid", density_ratio = 2, x = 0.2}]
)",
                                "wall.toml");
  const RunResult result = run(given);
  EXPECT_EQ(result.exit_code, exit_contact);
  ASSERT_TRUE(result.summary);
  EXPECT_EQ(result.summary->status, RunStatus::contact);
  EXPECT_FALSE(result.summary->blow_up);
  EXPECT_NE(result.summary->contact_reason.find("body \"stone\", marker"), std::string::npos);
  ASSERT_EQ(result.summary->contacts.size(), 1U);
  EXPECT_EQ(result.summary->contacts[0].other, "the wall at x = 1");
  EXPECT_LT(result.summary->contacts[0].gap_nodes, 1.5);
  EXPECT_GT(result.summary->contacts[0].gap_nodes, 1.3);
  EXPECT_EQ(result.samples.back().time, result.summary->time);
}

TEST_F(Run, ThatHasNoBodyHasOneHeaderAndRows) {
  const RunResult result = run(parse_case(
      "channel.nodes = 8\nchannel.length = 2\nchannel.reynolds = 1\nrun.time_limit = 0.2\n",
      "empty.toml"));
  EXPECT_EQ(result.exit_code, exit_success);
  std::ifstream file(directory_ / "trajectory.csv");
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line, "t[W^2/nu],flow_rate[nu*W]");
  std::vector<double> times;
  while (std::getline(file, line)) times.push_back(std::stod(line));
  ASSERT_EQ(times.size(), 5U);
  // The step is 1/96: rows come at the steps nearest to 0.05, 0.1 ...
  for (std::size_t n = 0; n < times.size(); ++n)
    EXPECT_NEAR(times[n], 0.05 * static_cast<double>(n), 0.5 / 96 + 1e-12);
}

}  // namespace
}  // namespace ductile::drivers
