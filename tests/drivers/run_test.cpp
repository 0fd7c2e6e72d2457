// A run inside of another program: what it leaves behind is in its directory, and nowhere else.
#include "run/run.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "checks/read_case.hpp"
#include "run/signals.hpp"
#include "scenario/writer.hpp"

namespace ductile::drivers {
namespace {

namespace fs = std::filesystem;

extern "C" void somebody_elses(int /*signal*/) {}

class Run : public testing::Test {
 public:
  ~Run() override {
    std::error_code ignored;
    fs::remove_all(directory_, ignored);
  }

 protected:
  Run() {
    std::string pattern = (fs::temp_directory_path() / "ductile-run-XXXXXX").string();
    directory_ = mkdtemp(pattern.data());
  }
  RunResult run(const Case& given) {
    return run_case(given, {directory_, resolved_toml(given.scenario), true, false},
                    PETSC_COMM_WORLD);
  }
  fs::path directory_;
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

// As in a comparison: a signal that comes between two runs ends the next one at its first row.
TEST_F(Run, EndsAtASignalThatCameBeforeIt) {
  const StopSignals signals;
  std::raise(SIGUSR1);
  const RunResult result = run(parse_case(small_case, "small.toml"));
  EXPECT_TRUE(result.interrupted);
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

}  // namespace
}  // namespace ductile::drivers
