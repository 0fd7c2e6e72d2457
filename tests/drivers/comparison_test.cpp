#include "output/comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "support/temporary_directory.hpp"

namespace ductile::drivers {
namespace {

using suspension::BodySample;
using suspension::Sample;

using Path = std::function<Eigen::Vector3d(double time)>;

/// Samples of bodies on given paths, every `step` from 0 to `end`.
std::vector<Sample> samples(const std::vector<Path>& paths, double step, double end) {
  std::vector<Sample> list;
  for (int n = 0; n * step <= end * (1 + 1e-12); ++n) {
    Sample sample{n * step, {}};
    for (const Path& path : paths) {
      BodySample body;
      Eigen::Vector3d::Map(body.values.data()) = path(sample.time);
      sample.bodies.push_back(body);
    }
    list.push_back(sample);
  }
  return list;
}

// Interpolation of a straight line is exact but for round-off.
TEST(Comparison, DifferenceIsTheLargestWhileBothGoOn) {
  const std::vector<Path> first = {
      [](double t) { return Eigen::Vector3d(0.2 - 0.1 * t, 0.02 * t, 1 + 5 * t); },
      [](double t) { return Eigen::Vector3d(-0.2 + 0.1 * t, 0, 4 * t); }};
  // Off by 0.01 t in x of the first, by -0.02 t in y of the second, by 0.03 t in dz.
  const std::vector<Path> second = {
      [&](double t) -> Eigen::Vector3d { return first[0](t) + t * Eigen::Vector3d(0.01, 0, 0.1); },
      [&](double t) -> Eigen::Vector3d {
        return first[1](t) + t * Eigen::Vector3d(0, -0.02, 0.07);
      }};
  constexpr double round_off = 1e-14;  // of positions up to 10
  for (const double step : {0.1, 0.07}) {
    for (const auto& [end, until] : {std::pair(0.7, 0.7), std::pair(1.4, 1.0)}) {
      const Difference apart = difference(samples(first, 0.1, 1), samples(second, step, end));
      EXPECT_NEAR(apart.until, until, round_off);
      EXPECT_NEAR(apart.bodies.at(0).x, 0.01 * until, round_off);
      EXPECT_NEAR(apart.bodies.at(0).y, 0, round_off);
      EXPECT_NEAR(apart.bodies.at(1).x, 0, round_off);
      EXPECT_NEAR(apart.bodies.at(1).y, 0.02 * until, round_off);
      EXPECT_NEAR(apart.largest().x, 0.01 * until, round_off);
      EXPECT_NEAR(apart.largest().y, 0.02 * until, round_off);
      EXPECT_NEAR(apart.dz.value(), 0.03 * until, round_off);
    }
  }
}

// Halfway between two samples h apart, a chord of t^2 lies h^2/4 above it.
TEST(Comparison, InterpolatesLinearly) {
  const std::vector<Path> path = {[](double t) { return Eigen::Vector3d(t * t, 0, 0); }};
  const Difference apart = difference(samples(path, 0.1, 1), samples(path, 0.05, 1));
  EXPECT_NEAR(apart.largest().x, 0.25 * 0.1 * 0.1, 1e-15);
  EXPECT_FALSE(apart.dz.has_value());
  EXPECT_EQ(difference(samples(path, 0.1, 1), samples(path, 0.1, 1)).largest().x, 0);
  // Of a run that ended at once, nothing but the start.
  const Difference none = difference(samples(path, 0.1, 1), samples(path, 0.1, 0));
  EXPECT_EQ(none.until, 0);
  EXPECT_EQ(none.largest().x, 0);
}

RunProfile profile() {
  // fluid, boxes, locating, interpolation, bodies, spreading, exchange, waiting, output
  return {1000,
          {{4, 0.5, 0.25, 1, 2, 0.5, 0.25, 0.5, 7}, {4.5, 0.5, 0.25, 0.5, 1, 1, 0.25, 1, 7}},
          {26000, 25500}};
}

TEST(Comparison, CostOfAStepIsThatOfTheSlowestRankInEachPart) {
  const StepCost cost = step_cost(profile()).value();
  EXPECT_DOUBLE_EQ(cost.fluid, 4.5);
  EXPECT_DOUBLE_EQ(cost.interpolation, 1);
  EXPECT_DOUBLE_EQ(cost.bodies, 2);
  EXPECT_DOUBLE_EQ(cost.spreading, 1);
  EXPECT_DOUBLE_EQ(cost.step, 9);
  EXPECT_DOUBLE_EQ(cost.rest, 0.5);
  RunProfile apart = profile();
  apart.ranks[1][0] = 10;  // 14.5 in all, and 14 in the largest four parts
  EXPECT_DOUBLE_EQ(step_cost(apart)->rest, 0.5);
  apart.ranks[1] = {};
  apart.ranks[1][0] = 9;  // parts of different ranks, 12.5 in all, while the step takes 9
  EXPECT_DOUBLE_EQ(step_cost(apart)->rest, 0);
  EXPECT_FALSE(step_cost({0, {{}}, {}}).has_value());
}

/// A pair that comes through, and one that blows up.
std::vector<Contender> contenders() {
  std::vector<Contender> list(2);
  for (std::size_t n = 0; n < 2; ++n) {
    const double off = n == 0 ? 0 : 0.01;
    Contender& c = list[n];
    c.integrator = n == 0 ? "first" : "second";
    c.samples = samples({[off](double t) { return Eigen::Vector3d(0.2 + off * t, 0, 1 + t); },
                         [](double t) { return Eigen::Vector3d(-0.2, 0, t); }},
                        0.1, n == 0 ? 2 : 1);
    Summary& s = c.summary;
    s.scenario = "case";
    s.status = n == 0 ? RunStatus::decided : RunStatus::blew_up;
    if (n == 1) s.blow_up = BlowUp{500, "lag", 7, "it was too stiff"};
    s.verdict = Verdict{n == 0 ? PairClass::stable : PairClass::undecided, 0, ""};
    s.time = c.samples.back().time;
    s.steps = n == 0 ? 1000 : 500;
    s.dz = axial_distance(c.samples.back());
    s.profile = profile();
    if (n == 1) s.profile->steps = 500;
    for (const char* name : {"lead", "lag"}) {
      BodySummary body;
      body.name = name;
      body.position = c.samples.back().bodies[s.bodies.size()].position();
      body.capsule = CapsuleSummary{};
      body.capsule->volume_error_max = 0.001 * static_cast<double>(1 + s.bodies.size());
      body.capsule->strain_energy = 0.0125;
      if (n == 1) body.capsule->solver = {500, 1500, 6000, 100, 1};
      s.bodies.push_back(body);
    }
  }
  list[0].summary.warnings = {"mind the gap"};
  return list;
}

/// The words of the line that starts with `label`, from the label on.
std::string line(const std::string& text, const std::string& label) {
  std::istringstream in(text);
  for (std::string one; std::getline(in, one);) {
    if (!one.starts_with(label)) continue;
    std::istringstream words(one.substr(label.size()));
    std::string joined;
    for (std::string word; words >> word;) joined += (joined.empty() ? "" : " ") + word;
    return joined;
  }
  return "no line " + label;
}

TEST(Comparison, TableHasAColumnForEach) {
  const std::string text = table(contenders());
  EXPECT_EQ(line(text, " "), "first second") << text;
  EXPECT_EQ(line(text, "outcome"), "decided blew up");
  EXPECT_EQ(line(text, "verdict"), "stable -");
  EXPECT_EQ(line(text, "time at the end [W^2/nu]"), "2 1");
  EXPECT_EQ(line(text, "steps "), "1000 500");
  EXPECT_EQ(line(text, "  lead"), "(0.2000, 0.0000, 3.000) (0.2100, 0.0000, 2.000)");
  EXPECT_EQ(line(text, "  in x"), "- 0.01");
  EXPECT_EQ(line(text, "  in y"), "- 0");
  EXPECT_EQ(line(text, "  until [W^2/nu]"), "- 1");
  EXPECT_EQ(line(text, "largest volume error"), "0.002 0.002");
  EXPECT_EQ(line(text, "  membrane"), "2 4");
  EXPECT_EQ(line(text, "  rest"), "0.5 1");
  EXPECT_EQ(line(text, "  all, of first"), "1.00 2.00");
  // Of one of the two capsules, in one of the 500 steps; totals are of both.
  EXPECT_EQ(line(text, "  Newton"), "- 3.00");
  EXPECT_EQ(line(text, "  Krylov"), "- 12.00");
  EXPECT_EQ(line(text, "tangents assembled"), "- 200");
  EXPECT_EQ(line(text, "steps cut"), "- 2");
  EXPECT_EQ(line(text, "second: "), "body lag blew up at step 500: it was too stiff");
  EXPECT_EQ(line(text, "first: "), "warning: mind the gap");
  auto mixed = contenders();
  for (Contender& c : mixed) c.summary.bodies[1].capsule.reset();
  EXPECT_EQ(line(table(mixed), "  bodies"), "2 4");
  EXPECT_EQ(line(table(mixed), "  Newton"), "- 3.00");
}

TEST(Comparison, JsonHasTheNumbersInFull) {
  const testing_support::TemporaryDirectory temporary;
  const std::filesystem::path& directory = temporary.path();
  std::ofstream(directory / "compare.json") << to_json(contenders());
  std::ofstream(directory / "read.py") << R"(
import json, math, sys
c = json.load(open(sys.argv[1], encoding='utf-8'))
assert (c['scenario'], c['reference'], c['bodies_part']) == ('case', 'first', 'membrane')
first, second = c['runs']
assert first['integrator'] == first['directory'] == 'first'
assert (first['status'], second['status']) == ('decided', 'blew up')
assert 'blow_up' not in first
assert second['blow_up'] == {'step': 500, 'body': 'lag', 'vertex': 7, 'place_W': None,
                             'reason': 'it was too stiff', 'likely_cause': ''}
assert (first['verdict'], first['steps'], second['time_W2_over_nu']) == ('stable', 1000, 1)
assert set(first['difference'].values()) == {0, 2}, first['difference']
assert math.isclose(second['difference']['x_W'], 0.01) and second['difference']['dz_W'] == 0
assert second['difference']['until_W2_over_nu'] == 1
lead, lag = second['bodies']
assert math.isclose(lead['x_difference_W'], 0.01) and lag['x_difference_W'] == 0
assert lag['volume_error_max'] == 0.002 and lag['strain_energy_over_ks_a2'] == 0.0125
assert lag['solver']['krylov_iterations_per_step'] == 12
assert 'solver' not in first['bodies'][0]
assert first['cost_per_step_ms'] == {'fluid': 4.5, 'interpolation': 1, 'bodies': 2, 'spreading': 1,
                                     'rest': 0.5, 'step': 9}
)";
  const std::string command = "/usr/bin/python3 '" + (directory / "read.py").string() + "' '" +
                              (directory / "compare.json").string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0) << to_json(contenders());
}

TEST(ProfileTable, ShowsEveryRankOfFewAndTheSpreadOfMany) {
  const std::string few = table(profile());
  EXPECT_EQ(line(few, "time by part"),
            "rank 0 [s] rank 1 [s] least [s] mean [s] most [s] most ms/step")
      << few;
  // Shares are of the whole run of that rank: 16 s each.
  EXPECT_EQ(line(few, "fluid"), "4.00 25.0% 4.50 28.1% 4.00 4.25 4.50 4.5000");
  EXPECT_EQ(line(few, "output"), "7.00 43.8% 7.00 43.8% 7.00 7.00 7.00 7.0000");
  EXPECT_EQ(line(few, "whole run"), "16.00 100.0% 16.00 100.0% 16.00 16.00 16.00 16.0000");
  EXPECT_NE(few.find("each rank sends 25.5 to 26.0 kB a step"), std::string::npos) << few;

  RunProfile one = profile();
  one.ranks.pop_back();
  EXPECT_EQ(line(table(one), "fluid"), "4.00 25.0% 4.0000");

  RunProfile many = profile();
  for (int n = 0; n < 6; ++n) many.ranks.push_back(profile().ranks[0]);
  EXPECT_EQ(line(table(many), "time by part"), "least [s] mean [s] most [s] share most ms/step");
  EXPECT_EQ(line(table(many), "fluid"), "4.00 4.06 4.50 25.4% 4.5000");
}

}  // namespace
}  // namespace ductile::drivers
