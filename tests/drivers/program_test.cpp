// The program as a user meets it: exit codes, what goes to which stream, and what is written.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace {

namespace fs = std::filesystem;

struct Outcome {
  int exit_code = -1;
  std::string output;
  std::string errors;
};

std::string contents(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class Program : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(root_);
    fs::create_directories(work_);
  }
  void TearDown() override { fs::remove_all(root_); }

  /// Runs the program in an empty directory. The environment is a fresh one: this test is itself a
  /// program of MPI, and what MPI has set would make the child take itself for part of the job.
  Outcome run(const std::string& arguments, const std::string& launch = "") {
    const std::string command =
        "cd '" + work_.string() + "' && env -i PATH=\"$PATH\" HOME=\"$HOME\"" +
        " OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 ASAN_OPTIONS=detect_leaks=0" +
        " OMPI_MCA_btl_vader_single_copy_mechanism=none " + launch + "'" + DUCTILE_PROGRAM + "' " +
        arguments + " >'" + (root_ / "out").string() + "' 2>'" + (root_ / "err").string() + "'";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(root_ / "out"),
            contents(root_ / "err")};
  }

  [[nodiscard]] const fs::path& work() const { return work_; }
  [[nodiscard]] bool nothing_written() const { return fs::is_empty(work_); }

 private:
  fs::path root_ = fs::path(testing::TempDir()) / "ductile_program_test";
  fs::path work_ = root_ / "work";
};

TEST_F(Program, WrongInputEndsWithTwoOneLineAndNothingWritten) {
  for (const std::string arguments :
       {"pair M1 --x-lag 0.9", "pair M1 --x-lag 0 --set channel.nodes=abc", "run absent.toml",
        "pair M1", "nonsense", "", "pair M1 --x-lag 0 -o /dev/null"}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.output, "") << arguments;
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1)
        << arguments << ": " << outcome.errors;
    EXPECT_TRUE(nothing_written()) << arguments;
  }
}

// A membrane far too stiff for the explicit scheme: what was computed stays, and is named.
TEST_F(Program, BlowUpEndsWithThreeAndLeavesWhatWasComputed) {
  for (const std::string launch : {"", "mpirun --quiet --bind-to none --oversubscribe -n 2 "}) {
    const Outcome outcome = run("run " DUCTILE_SCENARIO_DIR
                                "/quickstart.toml --set body.lead.laplace=3000 -o out --force",
                                launch);
    EXPECT_EQ(outcome.exit_code, 3) << outcome.errors;
    EXPECT_NE(outcome.errors.find("body lead blew up at step "), std::string::npos)
        << outcome.errors;
    const std::string summary = contents(work() / "out/summary.json");
    EXPECT_NE(summary.find("\"status\": \"blew up\""), std::string::npos) << summary;
    EXPECT_NE(summary.find("\"body\": \"lead\""), std::string::npos) << summary;
    EXPECT_EQ(summary.find("\"vertex\": null"), std::string::npos) << summary;
    const std::string trajectory = contents(work() / "out/trajectory.csv");
    ASSERT_GE(std::count(trajectory.begin(), trajectory.end(), '\n'), 2);
    EXPECT_EQ(trajectory.back(), '\n');
    EXPECT_TRUE(fs::exists(work() / "out/run.h5"));
    EXPECT_TRUE(fs::exists(work() / "out/trajectory.png"));
  }
}

TEST_F(Program, DoesNotOverwriteARunUnlessTold) {
  const std::string arguments =
      "run " DUCTILE_SCENARIO_DIR "/quickstart.toml --set run.time_limit=0.01 -o out";
  EXPECT_EQ(run(arguments).exit_code, 0);
  const std::string before = contents(work() / "out/trajectory.csv");
  EXPECT_EQ(run(arguments).exit_code, 2);
  EXPECT_EQ(contents(work() / "out/trajectory.csv"), before);
  EXPECT_EQ(run(arguments + " --force").exit_code, 0);
  EXPECT_EQ(contents(work() / "out/trajectory.csv"), before);
}

TEST_F(Program, CheckReportsAndWritesNothing) {
  const Outcome outcome = run("check " DUCTILE_SCENARIO_DIR "/M2.toml --set body.lag.x=0.4");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.errors, "");
  EXPECT_NE(outcome.output.find("36 x 36 x 216"), std::string::npos) << outcome.output;
  EXPECT_TRUE(nothing_written());
}

TEST_F(Program, HelpAndVersionSucceed) {
  for (const std::string arguments : {"--help", "--version", "keys", "pair --help"}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << arguments;
    EXPECT_EQ(outcome.errors, "") << arguments;
    EXPECT_GT(outcome.output.size(), 50U) << arguments;
  }
}

}  // namespace
