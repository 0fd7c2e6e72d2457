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
  Outcome run(const std::string& arguments) {
    const std::string command =
        "cd '" + work_.string() + "' && env -i PATH=\"$PATH\" HOME=\"$HOME\"" +
        " OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 ASAN_OPTIONS=detect_leaks=0 '" +
        DUCTILE_PROGRAM + "' " + arguments + " >'" + (root_ / "out").string() + "' 2>'" +
        (root_ / "err").string() + "'";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(root_ / "out"),
            contents(root_ / "err")};
  }

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
