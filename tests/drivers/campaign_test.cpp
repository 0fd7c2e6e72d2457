#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "campaign/board.hpp"
#include "campaign/directory.hpp"
#include "campaign/engine.hpp"
#include "campaign/layout.hpp"
#include "campaign/sweep.hpp"
#include "campaign/watch.hpp"
#include "checks/disk.hpp"
#include "checks/read_case.hpp"
#include "output/file.hpp"
#include "output/process.hpp"
#include "output/run_directory.hpp"
#include "scenario/errors.hpp"
#include "scenario/writer.hpp"
#include "support/temporary_directory.hpp"

namespace ductile::drivers {
namespace {
namespace fs = std::filesystem;

std::vector<std::string> names(const Sweep& sweep) {
  std::vector<std::string> list;
  for (const SweptCase& swept : sweep.cases) list.push_back(swept.name);
  return list;
}

std::string refusal(const std::string& text) {
  try {
    static_cast<void>(parse_sweep(text, "c.toml"));
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

using Names = std::vector<std::string>;

TEST(Sweep, AxesMultiplyTheLastOneFastest) {
  const Sweep sweep = parse_sweep(R"(
scenario = "M2"
set.channel.nodes = 24
[set.body.lead]
x = 0.25
[[axis]]
key = "channel.reynolds"
values = [5, 10]
[[axis]]
key = "body.lag.x"
from = -0.4
to = 0.4
count = 5
)",
                                  "study/map.toml");
  EXPECT_EQ(sweep.name, "map");
  EXPECT_EQ(sweep.axes, (Names{"channel.reynolds", "body.lag.x"}));
  ASSERT_EQ(names(sweep),
            (Names{"reynolds_5_lag-x_-0.4", "reynolds_5_lag-x_-0.2", "reynolds_5_lag-x_0",
                   "reynolds_5_lag-x_0.2", "reynolds_5_lag-x_0.4", "reynolds_10_lag-x_-0.4",
                   "reynolds_10_lag-x_-0.2", "reynolds_10_lag-x_0", "reynolds_10_lag-x_0.2",
                   "reynolds_10_lag-x_0.4"}));
  const std::vector<ReadCase> cases = read_cases(sweep);
  for (std::size_t c = 0; c < cases.size(); ++c) {
    const Scenario& scenario = cases[c].given->scenario;
    EXPECT_EQ(scenario.channel.nodes, 24);
    EXPECT_EQ(scenario.channel.reynolds, c < 5 ? 5 : 10);
    EXPECT_EQ(scenario.bodies[0].x, 0.25);
    // The value that one would write, not its neighbour in binary.
    EXPECT_EQ(scenario.bodies[1].x, (std::vector<double>{-0.4, -0.2, 0, 0.2, 0.4})[c % 5]);
  }
}

TEST(Sweep, KeysOfOneAxisChangeTogether) {
  const Sweep zip = parse_sweep(R"(
scenario = "M2"
[[axis]]
keys = ["body.lead.laplace", "body.lag.laplace"]
values = [[10, 100], [100, 10], 50]
[[axis]]
keys = ["body.lead.radius", "body.lag.radius"]
from = 0.3
to = 0.4
count = 2
names = ["small", "large"]
)",
                                "c.toml");
  EXPECT_EQ(names(zip),
            (Names{"lead-laplace_10_lag-laplace_100_small", "lead-laplace_10_lag-laplace_100_large",
                   "lead-laplace_100_lag-laplace_10_small", "lead-laplace_100_lag-laplace_10_large",
                   "lead-laplace_50_small", "lead-laplace_50_large"}));
  const std::vector<ReadCase> cases = read_cases(zip);
  EXPECT_EQ(cases[0].given->scenario.bodies[0].laplace, 10);
  EXPECT_EQ(cases[0].given->scenario.bodies[1].laplace, 100);
  EXPECT_EQ(cases[5].given->scenario.bodies[0].laplace, 50);
  EXPECT_EQ(cases[5].given->scenario.bodies[1].laplace, 50);
  EXPECT_EQ(cases[5].given->scenario.bodies[1].radius, 0.4);
  EXPECT_EQ(cases[5].entry.values, (Names{"50", "50", "0.4", "0.4"}));
  // One of several keys is an axis like others.
  const Sweep one = parse_sweep(
      "scenario = \"M2\"\n[[axis]]\nkeys = [\"channel.reynolds\"]\nvalues = [[5], 6]\n", "c.toml");
  EXPECT_EQ(names(one), (Names{"reynolds_5", "reynolds_6"}));
  const Sweep arrays = parse_sweep(R"(
scenario = "M2"
[[axis]]
key = "channel.gravity"
values = [[0, 0.3, 1e-20]]
names = ["down"]
)",
                                   "c.toml");
  EXPECT_EQ(arrays.cases[0].values, Names{"[0, 0.3, 1e-20]"});
  EXPECT_EQ(read_cases(arrays)[0].given->scenario.channel.gravity[1], 0.3);
}

TEST(Sweep, SeveralScenariosAreAnAxisToo) {
  EXPECT_EQ(names(parse_sweep(R"(
scenario = ["M1", "B2"]
[[axis]]
key = "body.lag.x"
values = [0.5]
)",
                              "c.toml")),
            (Names{"M1_lag-x_0.5", "B2_lag-x_0.5"}));
  EXPECT_EQ(names(parse_sweep("scenario = \"M1\"", "c.toml")), Names{"M1"});
  const std::string file = DUCTILE_SCENARIO_DIR "/rigid.toml";
  const Sweep own = parse_sweep("scenario = \"rigid.toml\"", DUCTILE_SCENARIO_DIR "/c.toml");
  EXPECT_EQ(read_cases(own)[0].given->scenario, load_case(file).scenario);
}

TEST(Sweep, AComplaintSaysWhere) {
  const std::string head = "scenario = \"M1\"\n";
  EXPECT_EQ(refusal("[[axis]]\n"),
            "c.toml:1:1: scenario: is missing: name a pair of the paper, or a scenario file");
  EXPECT_EQ(
      refusal("scenario = \"M8\""),
      "c.toml:1:12: scenario = \"M8\": there is no file \"M8\", and no pair of that name; did "
      "you mean \"M1\"?");
  EXPECT_EQ(refusal(head + "axes = 1\n"), "c.toml:2:1: axes: unknown key; did you mean \"axis\"?");
  EXPECT_EQ(refusal(head + "[[axis]]\nkey = \"a.b\"\nvalues = []\n"),
            "c.toml:4:10: axis.values = []: must be an array, with an entry at least");
  EXPECT_EQ(refusal(head + "[[axis]]\nvalues = [1]\n"),
            "c.toml:2:1: axis: must have either key or keys");
  EXPECT_EQ(refusal(head + "[[axis]]\nkey = \"a.b\"\nvalues = [1]\nto = 3\n"),
            "c.toml:5:6: axis.to = 3: goes with from, not with values");
  EXPECT_EQ(refusal(head + "[[axis]]\nkey = \"a.b\"\nfrom = 1\nto = 3\ncount = 1\n"),
            "c.toml:6:9: axis.count = 1: must be a whole number from 2 to 10000");
  EXPECT_EQ(refusal(head + "[[axis]]\nkeys = [\"a.b\", \"a.c\"]\nvalues = [[1, 2], [3]]\n"),
            "c.toml:4:19: axis.values = [3]: must have 2 values, one for each of the keys");
  EXPECT_EQ(refusal(head + "set.a.b = 2\n[[axis]]\nkey = \"a.b\"\nvalues = [1]\n"),
            "c.toml:3:1: a.b: has a value already: name each key once");
  EXPECT_EQ(refusal(head + "[[axis]]\nkey = \"a.b\"\nvalues = [1, 1]\n"),
            "c.toml: two cases are called b_1: give their axis names of its own");
  EXPECT_EQ(refusal(head + "[[axis]]\nkey = \"a.b\"\nvalues = [1, 2]\nnames = [\"x\"]\n"),
            "c.toml:5:9: axis.names = [\"x\"]: must have 2 names, one for each value");
  std::string many = head;
  for (const std::string key : {"a.b", "a.c", "a.d"})
    many += "[[axis]]\nkey = \"" + key + "\"\nfrom = 1\nto = 100\ncount = 100\n";
  EXPECT_EQ(refusal(many), "c.toml: 1000000 cases: at most 10000 in a campaign");
}

TEST(Sweep, HasANameThatADirectoryMayHave) {
  const std::string text = "scenario = \"M1\"\n";
  EXPECT_EQ(parse_sweep(text, "a/Re-map.toml").name, "Re-map");
  EXPECT_EQ(parse_sweep(text, "...toml").name, "--");
  EXPECT_EQ(parse_sweep(text, "a b.toml").name, "a-b");
}

TEST(Sweep, WordsAreWordsInTheNamesOfCases) {
  const Sweep sweep = parse_sweep(
      "scenario = \"M3\"\n[[axis]]\nkey = \"rigid.slip\"\nvalues = [\"felt\", 0.0]\n", "c.toml");
  ASSERT_EQ(sweep.cases.size(), 2U);
  EXPECT_EQ(sweep.cases[0].name, "slip_felt");
  EXPECT_EQ(sweep.cases[1].name, "slip_0");
}

// A bad value is its case's; what all cases have in common is the file's.
TEST(Sweep, ACaseIsRefusedAlone) {
  const std::string head = "scenario = \"M1\"\n[[axis]]\nkey = \"channel.reynolds\"\n";
  const std::vector<ReadCase> cases =
      read_cases(parse_sweep(head + "values = [10, -1]\n", "c.toml"));
  EXPECT_TRUE(cases[0].given && cases[0].entry.refusal.empty());
  EXPECT_FALSE(cases[1].given);
  EXPECT_EQ(cases[1].entry.refusal,
            "c.toml:4:15: channel.reynolds = -1: must be a number from 0 to 1000");
  EXPECT_THROW(read_cases(parse_sweep(head + "values = [-2, -1]\n", "c.toml")), InputError);
}

class CampaignFiles : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((path_ / name).parent_path());
    write_atomically(path_ / name, text);
  }
  [[nodiscard]] std::string read(const std::string& name) const {
    std::ifstream in(path_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  testing_support::TemporaryDirectory temporary_;
  const fs::path& path_ = temporary_.path();
};

TEST_F(CampaignFiles, AreReadBack) {
  const CampaignDirectory directory(path_);
  const Campaign campaign{
      "study",
      {"a.b", "c"},
      {{"one", "M1", {"1", "\"x\""}, ""}, {"two", "M1", {"2", "\"y\""}, "no, \"never\""}}};
  directory.write(campaign);
  const Campaign again = directory.read();
  EXPECT_EQ(again.name, "study");
  EXPECT_EQ(again.axes, campaign.axes);
  ASSERT_EQ(again.cases.size(), 2U);
  EXPECT_EQ(again.cases[1].values, campaign.cases[1].values);
  EXPECT_EQ(again.cases[1].refusal, "no, \"never\"");
  for (const std::string text :
       {"", "[]", "{\"campaign\": 1}",
        "{\"campaign\": \"a\", \"axes\": [],"
        "\"cases\": [{\"case\": \"../x\", \"scenario\": \"M1\", \"values\": []}]}"}) {
    write("campaign.json", text);
    EXPECT_THROW(static_cast<void>(directory.read()), InputError) << text;
  }
  EXPECT_THROW(static_cast<void>(CampaignDirectory(path_ / "none").read()), InputError);
}

// What came of a case is told by its files alone, so that it does not matter who has run it.
TEST_F(CampaignFiles, TellHowCasesEnded) {
  const Campaign campaign{"study",
                          {"channel.reynolds"},
                          {{"a", "M1", {"5"}, ""},
                           {"b", "M1", {"6"}, ""},
                           {"c", "M1", {"7"}, ""},
                           {"d", "M1", {"8"}, ""},
                           {"e", "M1", {"9"}, ""},
                           {"f", "M1", {"-1"}, "f.toml:1:2: bad, too \"bad\""}}};
  write("cases/a/summary.json", R"({"status": "decided", "verdict": "stable", "verdict_reason":
    "dz rests", "verdict_time": 47, "dz_W": 1.25, "dz_limit_W": 1.5, "dz_limit_error_W": null, "time_W2_over_nu": 60, "steps": 12345,
    "warnings": ["x", "y"], "bodies": [
    {"name": "lead", "position_W": [0.1, 0, 12], "velocity_nu_over_W": [0, 0, 4],
     "x_settled": true, "x_limit_W": 0.11, "x_limit_error_W": 0.001, "deformation": 0.05}]})");
  write("cases/b/summary.json", R"({"status": "blew up", "blow_up": {"reason": "too fast"}})");
  write("cases/c/summary.json", R"({"status": "walltime", "time_W2_over_nu": 3})");
  write("cases/d/failed.txt", "cannot write x: No space left on device\nmore\n");
  write("cases/e/trajectory.csv", "t\n");
  const CampaignDirectory directory(path_);
  const std::vector<CaseState> expected = {CaseState::ended,      CaseState::ended,
                                           CaseState::walltime,   CaseState::failed,
                                           CaseState::unfinished, CaseState::refused};
  for (std::size_t c = 0; c < expected.size(); ++c)
    EXPECT_EQ(directory.result(campaign.cases[c]).state, expected[c]) << campaign.cases[c].name;
  directory.gather(campaign);
  EXPECT_EQ(
      read("campaign.csv"),
      "case,scenario,channel.reynolds,state,verdict,verdict_time[W^2/nu],t[W^2/"
      "nu],dz[W],dz_limit[W],dz_limit_error[W],"
      "steps,warnings,lead_x[W],lead_y[W],lead_z[W],lead_vz[nu/W],lead_x_settled[1],"
      "lead_x_limit[W],lead_x_limit_error[W],lead_volume_error_max[1],lead_deformation[1],"
      "lead_strain_energy[k_s*a^2],reason\n"
      "a,M1,5,decided,stable,47,60,1.25,1.5,,12345,2,0.1,0,12,4,true,0.11,0.001,,0.05,,dz rests\n"
      "b,M1,6,blew up,,,,,,,,,,,,,,,,,,,too fast\n"
      "c,M1,7,walltime,,,3,,,,,,,,,,,,,,,,\n"
      "d,M1,8,failed,,,,,,,,,,,,,,,,,,,cannot write x: No space left on device\n"
      "e,M1,9,unfinished,,,,,,,,,,,,,,,,,,,\n"
      "f,M1,-1,refused,,,,,,,,,,,,,,,,,,,\"f.toml:1:2: bad, too \"\"bad\"\"\"\n");
}

// Layouts are the same twice; another limit lets a case go on, another system is refused.
TEST_F(CampaignFiles, AreLaidOutAgain) {
  const CampaignDirectory directory(path_ / "out");
  const auto lay = [&](const std::string& more, bool force) {
    const Sweep sweep = parse_sweep("scenario = \"M1\"\n" + more, "c.toml");
    lay_out(directory, sweep, read_cases(sweep), "text", force);
  };
  lay("", false);
  const std::string scenario = read("out/cases/M1/scenario.toml");
  EXPECT_EQ(load_case(path_ / "out/cases/M1/scenario.toml").scenario,
            parse_case(scenario, "M1.toml").scenario);
  EXPECT_EQ(read("out/campaign.toml"), "text");
  write("out/cases/M1/summary.json", R"({"status": "decided"})");
  write("out/cases/M1/trajectory.csv", "rows");
  lay("", false);
  EXPECT_EQ(read("out/cases/M1/scenario.toml"), scenario);
  EXPECT_TRUE(fs::exists(path_ / "out/cases/M1/summary.json"));
  lay("set.run.time_limit = 99.0\n", false);
  EXPECT_FALSE(fs::exists(path_ / "out/cases/M1/summary.json"));
  // What the end does not depend on lets it be, and so does another comment in the file.
  write("out/cases/M1/summary.json", R"({"status": "decided"})");
  write("out/cases/M1/scenario.toml", "# other words\n" + read("out/cases/M1/scenario.toml"));
  lay("set.run.time_limit = 99.0\nset.run.checkpoint_every = 3.0\n", false);
  EXPECT_TRUE(fs::exists(path_ / "out/cases/M1/summary.json"));
  // A run that blew up does so again.
  write("out/cases/M1/summary.json", R"({"status": "blew up"})");
  lay("set.run.time_limit = 98.0\n", false);
  EXPECT_TRUE(fs::exists(path_ / "out/cases/M1/summary.json"));
  lay("set.run.time_limit = 99.0\n", false);
  EXPECT_EQ(read("out/cases/M1/trajectory.csv"), "rows");
  EXPECT_NE(read("out/cases/M1/scenario.toml").find("time_limit = 99.0"), std::string::npos);
  EXPECT_THROW(lay("set.channel.nodes = 30\n", false), InputError);
  EXPECT_EQ(read("out/cases/M1/trajectory.csv"), "rows");
  lay("set.channel.nodes = 30\n", true);
  EXPECT_FALSE(fs::exists(path_ / "out/cases/M1/trajectory.csv"));
}

// A case that another process has in hand keeps its limits, by which that one ends it, and so do
// all.
TEST_F(CampaignFiles, AreLeftToTheProcessThatRunsThem) {
  const CampaignDirectory directory(path_ / "out");
  const auto lay = [&](const std::string& limit) {
    const Sweep sweep =
        parse_sweep("scenario = [\"M1\", \"M2\"]\nset.run.time_limit = " + limit + '\n', "c.toml");
    lay_out(directory, sweep, read_cases(sweep), limit, false);
  };
  lay("98.0");
  write("out/cases/M1/summary.json", R"({"status": "time limit"})");
  const std::string before = read("out/cases/M1/scenario.toml");
  {
    const DirectoryLock held(path_ / "out/cases/M2", "run");
    EXPECT_NO_THROW(lay("98.0"));
    EXPECT_THROW(lay("99.0"), InputError);
  }
  EXPECT_TRUE(fs::exists(path_ / "out/cases/M1/summary.json"));
  EXPECT_EQ(read("out/cases/M1/scenario.toml"), before);
  EXPECT_EQ(read("out/campaign.toml"), "98.0");
  lay("99.0");
  EXPECT_FALSE(fs::exists(path_ / "out/cases/M1/summary.json"));
}

// A layout that was killed half-way goes on: what shows first is the index. Cases that wait take
// the scenario that the file has now.
TEST_F(CampaignFiles, AreLaidOutToTheEnd) {
  const CampaignDirectory directory(path_ / "out");
  const auto lay = [&](const std::string& nodes) {
    const Sweep sweep =
        parse_sweep("scenario = [\"M1\", \"M2\"]\nset.channel.nodes = " + nodes + '\n', "c.toml");
    return lay_out(directory, sweep, read_cases(sweep), "text", false);
  };
  write("out/cases", "in the way");
  EXPECT_THROW(lay("30"), OutputError);
  EXPECT_EQ(directory.read().cases.size(), 2U);
  EXPECT_FALSE(fs::exists(directory.file()));
  fs::remove(path_ / "out/cases");
  lay("30");
  fs::remove_all(path_ / "out/cases/M2");
  lay("32");
  for (const char* name : {"M1", "M2"}) {
    EXPECT_EQ(load_case(directory.run(name) / "scenario.toml").scenario.channel.nodes, 32) << name;
  }
}

// A watch that sees the rows in pieces judges as the judge that saw them all.
TEST_F(CampaignFiles, RowsAreJudgedAsTheyCome) {
  PairJudge judge(10);
  std::string text = "t[W^2/nu],lead_x[W],lead_vx[nu/W],lag_x[W],dz[W]\n";
  for (int n = 0; n <= 1600; ++n) {
    const double t = 0.05 * n;
    const double dz = 1.5 + 0.5 * std::exp(-t / 10) * std::cos(0.6 * t);
    judge.update(t, dz, 0.3, -0.3);
    text += fmt::format("{},0.3,0,-0.3,{}\n", t, dz);
  }
  RunWatch watch(path_ / "rows.csv", 10);
  watch.look();
  EXPECT_FALSE(watch.time());
  std::ofstream out(path_ / "rows.csv", std::ios::binary);
  for (std::size_t at = 0; at < text.size(); at += 777) {
    out << text.substr(at, 777) << std::flush;
    watch.look();
  }
  EXPECT_EQ(watch.time(), 80.0);
  EXPECT_EQ(watch.verdict().pair_class, judge.verdict().pair_class);
  EXPECT_EQ(watch.verdict().time, judge.verdict().time);
  EXPECT_EQ(to_string(judge.verdict().pair_class), "damped");
}

TEST(Engine, TakesTheLongestFirst) {
  EXPECT_EQ(expected_span({1, 2, 3, 4, 5}, 1), 15);
  EXPECT_EQ(expected_span({1, 2, 3, 4, 5}, 2), 8);
  EXPECT_EQ(expected_span({1, 1, 1, 5}, 2), 5);
  EXPECT_EQ(expected_span({}, 3), 0);
}

TEST_F(CampaignFiles, AProcessTellsItsEnd) {
  const auto ending = [&](const std::string& script, int sent) {
    Process process({"sh", "-c", script}, {"PATH=/bin:/usr/bin", "WORD=hello"}, path_ / "said");
    if (sent != 0) process.signal(sent);
    for (;;)
      if (const auto end = process.ended()) return *end;
  };
  EXPECT_EQ(ending("echo $WORD; exit 7", 0).code, 7);
  EXPECT_EQ(read("said"), "hello\n");
  EXPECT_EQ(ending("sleep 60", SIGTERM).signal, SIGTERM);
  EXPECT_THROW(Process({"no-such-program"}, {"PATH=/bin"}, path_ / "said"), OutputError);
  EXPECT_THROW(Process({"true"}, {"PATH=/bin"}, path_ / "none" / "said"), OutputError);
}

// Off a terminal the counts alone, at intervals that double.
TEST_F(CampaignFiles, TheBoardIsQuietOffATerminal) {
  std::FILE* out = std::fopen((path_ / "board").c_str(), "w");
  Board board(out, false, 80);
  const BoardCounts counts{20, 7, 11, 840.0};
  for (int second = 0; second <= 100; ++second)
    board.show(second, {{"a", 1, 2, 3, "", 4}, {}}, counts);
  board.tell("a: decided");
  std::fclose(out);
  const std::string line =
      "7 of 20 cases have ended, 2 under way, 11 waiting; about 14 min 00 s left\n";
  EXPECT_EQ(read("board"), line + line + line + "a: decided\n");
}

// Of what is written the rows' digits vary; the test of a whole run is in program_test.cpp.
TEST(Disk, CountsWhatIsWritten) {
  const std::string file = DUCTILE_SCENARIO_DIR "/quickstart.toml";
  const Case plain =
      load_case(file, {{"output.every", "100000.0", ""}, {"output.surfaces_every", "0.0", ""}});
  const double nodes = static_cast<double>(plain.plan.node_count());
  EXPECT_GT(disk_needed(plain), 2 * 4 * 19 * nodes);
  EXPECT_LT(disk_needed(plain), 1.1 * 2 * 4 * 19 * nodes);
  const Case fields = load_case(file, {{"output.every", "100000.0", ""},
                                       {"output.surfaces_every", "0.0", ""},
                                       {"output.field_every", "1.0", ""},
                                       {"run.time_limit", "9.0", ""}});
  const double ten = disk_needed(fields) - disk_needed(plain);
  EXPECT_NEAR(ten, 10 * 16 * nodes, 0.2 * 160 * nodes);
}

}  // namespace
}  // namespace ductile::drivers
