// The program as a user meets it: exit codes, what goes to which stream, and what is written.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

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

const std::string quickstart = DUCTILE_SCENARIO_DIR "/quickstart.toml";

class Program : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(root_);
    fs::create_directories(work_);
    fs::create_directories(home_);
  }
  void TearDown() override { fs::remove_all(root_); }

  /// Runs the program in an empty directory. The environment is a fresh one: this test is itself a
  /// program of MPI, and what MPI has set would make the child take itself for part of the job.
  Outcome run(const std::string& arguments, const std::string& launch = "") {
    const std::string command =
        "cd '" + work_.string() + "' && env -i PATH=\"$PATH\" HOME='" + home_.string() +
        "' XDG_CACHE_HOME=\"${XDG_CACHE_HOME:-$HOME/.cache}\"" +
        " OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1" +
        " OMPI_MCA_btl_vader_single_copy_mechanism=none OMPI_MCA_mpi_yield_when_idle=1 " + launch +
        "'" + DUCTILE_PROGRAM + "' " + arguments + " >'" + (root_ / "out").string() + "' 2>'" +
        (root_ / "err").string() + "'";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, contents(root_ / "out"),
            contents(root_ / "err")};
  }

  [[nodiscard]] const fs::path& work() const { return work_; }
  [[nodiscard]] bool nothing_written() const { return fs::is_empty(work_); }

 private:
  fs::path root_ =
      fs::path(testing::TempDir()) / ("ductile_program_test_" + std::to_string(getpid()));
  fs::path work_ = root_ / "work";
  fs::path home_ = root_ / "home";  // without a .petscrc, which the program would tell of
};

TEST_F(Program, WrongInputEndsWithTwoOneLineAndNothingWritten) {
  const std::string unknown_integrator =
      "compare " + quickstart + " --integrators explicit-euler,nonsense";
  for (const std::string arguments :
       {"pair M1 --x-lag 0.9", "pair M1 --x-lag 0 --set channel.nodes=abc", "run absent.toml",
        "pair M1", "nonsense", "", "pair M1 --x-lag 0 -o /dev/null", unknown_integrator.c_str()}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(outcome.output, "") << arguments;
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1)
        << arguments << ": " << outcome.errors;
    EXPECT_TRUE(nothing_written()) << arguments;
  }
}

// A small bench on two ranks: the table, JSON that can be read, and what `check` makes of it.
TEST_F(Program, BenchMeasuresAndCheckKnowsIt) {
  const std::string launch =
      "XDG_CACHE_HOME=cache mpirun --quiet --bind-to none --oversubscribe -n 2 ";
  const Outcome first = run("check " + quickstart, "XDG_CACHE_HOME=cache ");
  EXPECT_NE(first.output.find("a guess: run `ductile bench`"), std::string::npos) << first.output;
  const Outcome table = run("bench --nodes 24 --repeats 1", launch);
  EXPECT_EQ(table.exit_code, 0) << table.errors;
  for (const char* part : {"24 x 24 x 144 nodes, 2 ranks", "fluid kernel for", "double precision",
                           "single storage, double arithmetic", "single precision",
                           "double arithmetic", "fluid, walls on nodes", "2 ranks are",
                           "of the fluid alone", "spreading", "a vertex of an explicit capsule"}) {
    EXPECT_NE(table.output.find(part), std::string::npos) << part << " not in\n" << table.output;
  }
  EXPECT_NE(table.errors.find("not kept"), std::string::npos) << table.errors;
  std::array<char, 256> host{};
  ASSERT_EQ(gethostname(host.data(), host.size() - 1), 0);
  fs::create_directories(work() / "cache" / "ductile");
  std::ofstream(work() / "cache" / "ductile" / "bench.toml")
      << "machine = \"" << host.data()
      << "\"\nranks = 1\ndouble = 1e8\nsingle_storage = 1e8\nsingle = 2e8\n"
         "double_alone = 1e8\nsingle_storage_alone = 1e8\nsingle_alone = 2e8\n"
         "row = 0\nnode = 0\nnode_read = 0\nnode_update = 0\nmarker = 0\nmarker_pass = 0\nimplicit "
         "= 0\n"
         "stiff = 0\n";
  const Outcome known = run("check " + quickstart, "XDG_CACHE_HOME=cache ");
  // 24 x 24 x 72 nodes, 864 steps a unit of time, 60 units: 10.7 s.
  EXPECT_NE(known.output.find("about 11 s until the time limit on 1 rank, as"), std::string::npos)
      << known.output;
  const Outcome json = run("bench --nodes 24 --repeats 1 --json", launch);
  EXPECT_EQ(json.exit_code, 0) << json.errors;
  const fs::path file = work() / "bench.json";
  std::ofstream(file) << json.output;
  const std::string read =
      "python3 -c \"import json; table = json.load(open('" + file.string() +
      "'))['tables'][1]; assert len(table['rows'][0]['fraction_of_ceiling']) == 1\"";
  EXPECT_EQ(std::system(read.c_str()), 0) << json.output;
  const Outcome wrong = run("bench --nodes 3");
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.errors.find("24 to 400"), std::string::npos) << wrong.errors;
}

// Results come from the scenario alone, and what was warned of at the start is in the summary too.
TEST_F(Program, IgnoresPetscsOwnSourcesOfOptionsAndSaysSo) {
  const std::string arguments =
      "run " + quickstart +
      " --set channel.nodes=16 --set channel.length=4 --set membrane.integrator=implicit"
      " --set run.time_limit=0.2 -o ";
  const Outcome plain = run(arguments + "plain");
  ASSERT_EQ(plain.exit_code, 0) << plain.errors;
  EXPECT_EQ(plain.errors.find("ignored"), std::string::npos);
  std::ofstream(work() / ".petscrc") << "-membrane_ksp_rtol .9\n";
  const Outcome other = run(arguments + "other", "PETSC_OPTIONS='-membrane_snes_rtol .9' ");
  ASSERT_EQ(other.exit_code, 0) << other.errors;
  for (const char* source : {"PETSC_OPTIONS", ".petscrc"}) {
    EXPECT_NE(other.errors.find("warning: " + std::string(source) + " is ignored"),
              std::string::npos)
        << other.errors;
  }
  const std::string rows = contents(work() / "plain" / "trajectory.csv");
  EXPECT_GT(rows.size(), 1000U);
  EXPECT_EQ(contents(work() / "other" / "trajectory.csv"), rows);
  const std::string early = "under 4 results are crude";
  EXPECT_NE(plain.errors.find(early), std::string::npos) << plain.errors;
  EXPECT_NE(contents(work() / "plain" / "summary.json").find(early), std::string::npos);
}

TEST_F(Program, ARunWithoutBodiesHasNothingToDraw) {
  std::ofstream(work() / "empty.toml")
      << "channel.nodes = 8\nchannel.length = 2\nchannel.reynolds = 1\nrun.time_limit = 0.1\n";
  const Outcome outcome = run("run empty.toml -o out");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors.find("warning"), std::string::npos) << outcome.errors;
  EXPECT_FALSE(fs::exists(work() / "out" / "trajectory.png"));
}

// Whatever commands run, and no picture of an earlier end stays.
TEST_F(Program, PicturesComeInTheFormatThatIsAskedFor) {
  const std::string small = quickstart +
                            " --set channel.nodes=12 --set channel.length=4"
                            " --set run.time_limit=0.1 ";
  const Outcome first = run("run " + small + "-o out --format pdf");
  ASSERT_EQ(first.exit_code, 0) << first.errors;
  EXPECT_TRUE(contents(work() / "out/trajectory.pdf").starts_with("%PDF")) << first.errors;
  EXPECT_FALSE(fs::exists(work() / "out/trajectory.png"));
  const Outcome next = run("resume out --until 0.2 --format svg");
  ASSERT_EQ(next.exit_code, 0) << next.errors;
  EXPECT_TRUE(contents(work() / "out/trajectory.svg").starts_with("<?xml")) << next.errors;
  EXPECT_FALSE(fs::exists(work() / "out/trajectory.pdf"));
  const Outcome drawn = run("plot out");
  EXPECT_EQ(drawn.exit_code, 0) << drawn.errors;
  EXPECT_EQ(drawn.output, "out/trajectory.png\n");
  EXPECT_TRUE(contents(work() / "out/trajectory.png").starts_with("\x89PNG"));
  const Outcome compared =
      run("compare " + small + "--integrators explicit-euler,adams-bashforth -o both --format svg");
  ASSERT_EQ(compared.exit_code, 0) << compared.errors;
  EXPECT_TRUE(contents(work() / "both/compare.svg").starts_with("<?xml")) << compared.errors;
  EXPECT_TRUE(fs::exists(work() / "both/adams-bashforth/trajectory.svg"));
  for (const std::string& wrong :
       {"run " + small + "-o no --format jpg", std::string("plot none")}) {
    const Outcome refused = run(wrong);
    EXPECT_EQ(refused.exit_code, 2) << wrong;
    EXPECT_EQ(std::count(refused.errors.begin(), refused.errors.end(), '\n'), 1) << refused.errors;
  }
  EXPECT_FALSE(fs::exists(work() / "no"));
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

const std::string falling = R"(
name = "falling"
channel.nodes = 16
channel.length = 4
channel.reynolds = 0
channel.gravity = [0, 0, 3e4]
fluid.tau = 0.55
run.checkpoint_every = 1e-9
output.every = 0.01
[[body]]
name = "ball"
kind = "rigid"
density_ratio = 5
)";

// The last state is there to be looked at, and no run goes on from it: from the last good one it
// blows up as it did.
TEST_F(Program, BlowUpSaysWhereAndWhyAndSparesTheCheckpoint) {
  std::ofstream(work() / "falling.toml") << falling;
  const Outcome outcome = run("run falling.toml -o out");
  EXPECT_EQ(outcome.exit_code, 3) << outcome.errors;
  const std::size_t said = outcome.errors.find("body ball blew up at step ");
  ASSERT_NE(said, std::string::npos) << outcome.errors;
  const std::string line = outcome.errors.substr(said, outcome.errors.find('\n', said) - said);
  for (const char* part :
       {" near (", ", vertex ", "lattice spacings in one step",
        "likely cause: too fast for the lattice: at t = ", "lower what drives them"})
    EXPECT_NE(line.find(part), std::string::npos) << line;
  const std::string rows = contents(work() / "out/trajectory.csv");
  // The row of the last state is off the schedule.
  const std::string last = rows.substr(rows.rfind('\n', rows.size() - 2) + 1);
  const double time = std::stod(last);
  EXPECT_GT(std::abs(time / 0.01 - std::round(time / 0.01)), 0.02) << last;
  const std::string frames = contents(work() / "out/run.h5");
  ASSERT_TRUE(fs::exists(work() / "out/frames/000001.h5"));
  ASSERT_TRUE(fs::exists(work() / "out/checkpoint.h5"));

  const Outcome again = run("resume out", "mpirun --quiet --bind-to none --oversubscribe -n 2 ");
  EXPECT_EQ(again.exit_code, 3) << again.errors;
  EXPECT_NE(again.errors.find("goes on from t = "), std::string::npos) << again.errors;
  EXPECT_NE(again.errors.find(line), std::string::npos) << again.errors;
  EXPECT_EQ(contents(work() / "out/trajectory.csv"), rows);
  EXPECT_EQ(contents(work() / "out/run.h5"), frames);
}

TEST_F(Program, ResumeTakesAFinishedRunFurtherAndRefusesAnother) {
  const std::string small = quickstart +
                            " --set channel.nodes=16 --set channel.length=4"
                            " --set output.every=0.007 --set output.surfaces_every=0.03 -o ";
  ASSERT_EQ(run("run " + small + "long --set run.time_limit=0.3").exit_code, 0);
  ASSERT_EQ(run("run " + small + "short --set run.time_limit=0.1").exit_code, 0);
  const Outcome further = run("resume short --until 0.3");
  EXPECT_EQ(further.exit_code, 0) << further.errors;
  for (const char* name : {"trajectory.csv", "run.h5", "run.xdmf", "frames/000005.h5"})
    EXPECT_EQ(contents(work() / "short" / name), contents(work() / "long" / name)) << name;
  EXPECT_NE(contents(work() / "short/log.txt").find("goes on from t = 0.0"), std::string::npos);
  // Nothing is left to do, and nothing changes.
  const std::string rows = contents(work() / "short/trajectory.csv");
  EXPECT_EQ(run("resume short").exit_code, 0);
  EXPECT_EQ(contents(work() / "short/trajectory.csv"), rows);

  // Damage is told by name, and the checkpoint before is taken.
  ASSERT_EQ(run("resume short --until 0.35").exit_code, 0);
  std::string bytes = contents(work() / "short/checkpoint.h5");
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
  std::ofstream(work() / "short/checkpoint.h5", std::ios::binary) << bytes;
  const Outcome damaged = run("resume short --until 0.3");
  EXPECT_EQ(damaged.exit_code, 0);
  EXPECT_NE(damaged.errors.find("warning: short/checkpoint.h5 is damaged: its checksum is "),
            std::string::npos)
      << damaged.errors;
  EXPECT_EQ(contents(work() / "short/trajectory.csv"), rows);
  // Rows that are not what they were are told, and nothing is touched.
  std::string other = rows;
  char& digit = other[other.size() / 4];
  digit = digit == '7' ? '8' : '7';
  std::ofstream(work() / "short/trajectory.csv") << other;
  const Outcome changed = run("resume short --until 0.4");
  EXPECT_EQ(changed.exit_code, 1);
  EXPECT_NE(changed.errors.find("short/trajectory.csv has changed since the checkpoint"),
            std::string::npos)
      << changed.errors;
  EXPECT_EQ(contents(work() / "short/trajectory.csv"), other);

  std::string scenario = contents(work() / "long/scenario.toml");
  scenario.replace(scenario.find("reynolds = 10.0"), 15, "reynolds = 12.0");
  std::ofstream(work() / "long/scenario.toml") << scenario;
  const Outcome another = run("resume long --until 0.4");
  EXPECT_EQ(another.exit_code, 2);
  EXPECT_NE(another.errors.find("channel.reynolds = 12.0 where the run has 10.0"),
            std::string::npos)
      << another.errors;
  // Results without a checkpoint are not started over.
  fs::remove(work() / "long/checkpoint.h5");
  fs::remove(work() / "long/checkpoint-before.h5");
  EXPECT_EQ(run("resume long").exit_code, 2);
  EXPECT_EQ(contents(work() / "long/trajectory.csv"), rows);
  EXPECT_EQ(run("resume short --until ''").exit_code, 2);
  EXPECT_EQ(run("resume ''").exit_code, 2);
  EXPECT_EQ(run("resume nowhere").exit_code, 2);
  EXPECT_EQ(run("resume short --until abc").exit_code, 2);
  EXPECT_EQ(run("resume short --max-walltime soon").exit_code, 2);
}

// A body that fails in the very first step: no step is complete, and an option that might have
// helped had it been spelt right is named.
TEST_F(Program, AFailureInTheFirstStepStillNamesUnreadOptions) {
  const Outcome outcome = run(
      "run " DUCTILE_SCENARIO_DIR
      "/quickstart.toml --set membrane.integrator=implicit --set body.lead.laplace=1e7 "
      "--petsc \"-membrane_snes_max_it 1 -membrane_snes_max_its 50\" --set membrane.step_cuts=0 "
      "-o out");
  EXPECT_EQ(outcome.exit_code, 3) << outcome.errors;
  EXPECT_NE(outcome.errors.find("blew up at step 0 (t = 0)"), std::string::npos) << outcome.errors;
  EXPECT_NE(outcome.errors.find("membrane_snes_max_its: nothing in this run reads"),
            std::string::npos)
      << outcome.errors;
  EXPECT_NE(contents(work() / "out/summary.json").find("\"steps\": 0"), std::string::npos);
}

// The same comparison on 1 and 2 ranks: each run is an ordinary one, and leaves what `run` does.
TEST_F(Program, ComparesIntegrators) {
  const std::string changes = " --set run.time_limit=0.1 --set output.every=0.02 ";
  const auto alone = [&](const std::string& integrator) {
    return run("run " + quickstart + changes + "--set membrane.integrator=" + integrator +
               " -o alone-" + integrator);
  };
  ASSERT_EQ(alone("explicit-euler").exit_code, 0);
  ASSERT_EQ(alone("adams-bashforth").exit_code, 0);
  const std::string compare =
      "compare " + quickstart + changes + "--integrators explicit-euler,adams-bashforth --force";
  for (const std::string launch : {"", "mpirun --quiet --bind-to none --oversubscribe -n 2 "}) {
    const Outcome outcome = run(compare, launch);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
    for (const char* label :
         {"explicit-euler", "adams-bashforth", "cost of a step", "  membrane",
          "largest volume error", "  lag", "results in runs/quickstart_compare"})
      EXPECT_NE(outcome.output.find(label), std::string::npos) << label << '\n' << outcome.output;
    const fs::path directory = work() / "runs/quickstart_compare";
    for (const std::string integrator : {"explicit-euler", "adams-bashforth"}) {
      EXPECT_EQ(contents(directory / integrator / "trajectory.csv"),
                contents(work() / ("alone-" + integrator) / "trajectory.csv"))
          << integrator << ' ' << launch;
      EXPECT_EQ(contents(directory / integrator / "scenario.toml"),
                contents(work() / ("alone-" + integrator) / "scenario.toml"))
          << integrator << ' ' << launch;
      EXPECT_TRUE(fs::exists(directory / integrator / "trajectory.png"));
      EXPECT_NE(contents(directory / integrator / "summary.json").find("\"profile\""),
                std::string::npos);
    }
    EXPECT_NE(contents(directory / "compare.json").find("\"reference\": \"explicit-euler\""),
              std::string::npos);
    EXPECT_TRUE(contents(directory / "compare.png").starts_with("\x89PNG\r\n")) << outcome.errors;
  }
}

// Every number of a trajectory, headings apart.
std::vector<double> numbers(const fs::path& file) {
  std::vector<double> values;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] == '#' || std::isalpha(static_cast<unsigned char>(line[0])) != 0)
      continue;
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) values.push_back(std::stod(field));
  }
  return values;
}

// Half of a symmetric channel gives what the whole gives, wherever its nodes and walls are; what
// differs is round-off, and how it grows: that of double precision here.
TEST_F(Program, HalfOfASymmetricChannelGivesTheSameTrajectory) {
  const std::string file = (work() / "pair.toml").string();
  std::ofstream(file)
      << "[channel]\nlength = 5\n[fluid]\nstorage = \"double\"\n[run]\ntime_limit = 0.5\n"
         "[output]\nevery = 0.02\nsurfaces_every = 0\n"
         "[[body]]\nlaplace = 100\nradius = 0.4\nx = 0.2\nz = 0.5\n"
         "[[body]]\nkind = \"rigid\"\ninterior = \"solid\"\nradius = 0.45\nx = -0.2\nz = "
         "-0.5\n";
  for (const std::string lattice : {"--set channel.nodes=16", "--set channel.nodes=17",
                                    "--set channel.nodes=17 --set channel.walls=regularized"}) {
    const std::string command =
        std::string("run ").append(file).append(" --force ").append(lattice);
    ASSERT_EQ(run(command + " -o whole").exit_code, 0) << lattice;
    const Outcome half = run(command + " --set channel.symmetry=y -o half");
    ASSERT_EQ(half.exit_code, 0) << lattice << half.errors;
    const std::vector<double> a = numbers(work() / "whole/trajectory.csv");
    const std::vector<double> b = numbers(work() / "half/trajectory.csv");
    ASSERT_GT(a.size(), 250U) << lattice;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t n = 0; n < a.size(); ++n)
      ASSERT_NEAR(a[n], b[n], 1e-10 * std::max(1.0, std::abs(a[n]))) << lattice << ' ' << n;
  }
}

// Explicit Euler bears a Laplace number of about 760 here, Adams-Bashforth about 950 for so short a
// time: at 900 only the first fails, and that is a result; at 3000 both do.
TEST_F(Program, ABlowUpIsAResultOfAComparisonUnlessAllBlowUp) {
  const std::string command = "compare " + quickstart +
                              " --set run.time_limit=0.25 --set membrane.retraction=0.0 --force "
                              "-o out --integrators explicit-euler,adams-bashforth ";
  const auto laplace = [](const std::string& value) {
    return "--set body.lead.laplace=" + value + " --set body.lag.laplace=" + value;
  };
  const Outcome one = run(command + laplace("900"));
  EXPECT_EQ(one.exit_code, 0) << one.errors;
  EXPECT_NE(one.output.find("explicit-euler: body lead blew up at step "), std::string::npos)
      << one.output;
  EXPECT_EQ(one.output.find("adams-bashforth: body"), std::string::npos) << one.output;
  EXPECT_NE(contents(work() / "out/compare.json").find("\"blow_up\""), std::string::npos);
  EXPECT_TRUE(fs::exists(work() / "out/compare.png")) << one.errors;

  const Outcome all =
      run(command + laplace("3000"), "mpirun --quiet --bind-to none --oversubscribe -n 2 ");
  EXPECT_EQ(all.exit_code, 3) << all.errors;
  EXPECT_NE(all.output.find("adams-bashforth: body lead blew up at step "), std::string::npos)
      << all.output;
  EXPECT_TRUE(fs::exists(work() / "out/compare.png")) << all.errors;
}

TEST_F(Program, ProfileShowsTheTimeByPart) {
  const std::string arguments = "run " + quickstart + " --set run.time_limit=0.01 --force -o out";
  for (const std::string launch : {"", "mpirun --quiet --bind-to none --oversubscribe -n 2 "}) {
    EXPECT_EQ(run(arguments, launch).output.find("time by part"), std::string::npos);
    EXPECT_EQ(contents(work() / "out/summary.json").find("\"profile\""), std::string::npos);
    const Outcome outcome = run(arguments + " --profile", launch);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    for (const char* part :
         {"time by part", "\nfluid ", "\nboxes ", "\nlocating ", "\ninterpolation ", "\nbodies ",
          "\nspreading ", "\nexchange ", "\nwaiting ", "\noutput ", "\nwhole run "})
      EXPECT_NE(outcome.output.find(part), std::string::npos) << part << '\n' << outcome.output;
    EXPECT_NE(contents(work() / "out/summary.json").find("\"seconds_by_rank\""), std::string::npos);
  }
}

// Two that start further apart than the stop distance, half of a short channel, pass each other.
TEST_F(Program, PairInShearStartsBeyondTheStopDistance) {
  std::ofstream(work() / "shear.toml") << R"(
[channel]
nodes = 16
length = 3
reynolds = 0
side_walls = false
wall_velocity = [-5.0, 5.0]
[run]
time_limit = 2
[[body]]
name = "lead"
kind = "rigid"
radius = 0.3
x = 0.4
z = -0.8
[[body]]
name = "lag"
kind = "rigid"
radius = 0.3
x = -0.4
z = 0.8
)";
  const Outcome outcome = run("run shear.toml");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  const std::string summary = contents(work() / "runs/shear/summary.json");
  EXPECT_NE(summary.find("\"status\": \"stopped at dz\""), std::string::npos) << summary;
  EXPECT_NE(
      summary.find("\"|dz| has reached 1.5; the lagging particle has passed the leading one\""),
      std::string::npos)
      << summary;
}

TEST_F(Program, DoesNotOverwriteARunUnlessTold) {
  const std::string arguments =
      "run " DUCTILE_SCENARIO_DIR "/quickstart.toml --set run.time_limit=0.01 -o out";
  EXPECT_EQ(run(arguments).exit_code, 0);
  const std::string before = contents(work() / "out/trajectory.csv");
  EXPECT_EQ(run(arguments).exit_code, 2);
  EXPECT_EQ(contents(work() / "out/trajectory.csv"), before);
  EXPECT_EQ(run(arguments + " --set output.every=0.005 --force").exit_code, 0);
  EXPECT_NE(contents(work() / "out/trajectory.csv"), before);
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
