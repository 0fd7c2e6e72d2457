// The judge of pairs on fifty thousand synthetic histories: how often it is wrong, how often it
// says nothing, and whether the limits that it states are met.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "drivers/synthetic_pairs.hpp"

namespace ductile::drivers {
namespace {

constexpr int kinds = static_cast<int>(kind_names.size());

/// The i-th history.
SyntheticPair history(int i) {
  Dice dice(static_cast<std::uint64_t>(i));
  return random_pair(static_cast<Kind>(i % kinds), dice);
}

Verdict judged(const SyntheticPair& p, double interval) {
  PairJudge judge;
  for (int i = 0; i * interval <= p.end && !judge.verdict().decided(); ++i) {
    const double t = i * interval;
    judge.update(t, p.dz(t), p.x(0, t), p.x(1, t));
  }
  return judge.verdict();
}

bool right(const SyntheticPair& p, const Verdict& v) {
  const std::vector<PairClass> list = right_verdicts(p, v.time);
  return !v.decided() || std::find(list.begin(), list.end(), v.pair_class) != list.end();
}

bool goes_away(Kind kind) {
  return kind >= Kind::parts && kind <= Kind::leaves;
}

std::string describe(std::size_t i, const SyntheticPair& p, const Verdict& v) {
  return fmt::format("history {} ({}), every {:.2f}: {} at t = {:.2f}, {}; departed by {:.2f}", i,
                     kind_names[static_cast<std::size_t>(p.kind)], p.interval,
                     to_string(v.pair_class), v.time, v.reason, departure(p, v.time));
}

struct Row {
  std::array<int, 5> verdicts{};
  int wrong = 0;
  int early = 0;  // called stable or damped before it had left by a pronounced swing
  int clear = 0;  // long and with little noise
  int clear_and_decided = 0;
  std::vector<double> times;

  [[nodiscard]] double median() {
    if (times.empty()) return 0;
    std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2),
                     times.end());
    return times[times.size() / 2];
  }
};

void print(std::array<Row, kinds>& rows) {
  fmt::print("{:12}{:>10}{:>8}{:>8}{:>9}{:>10}{:>7}{:>7}{:>14}{:>15}\n", "", "undecided", "stable",
             "damped", "bounded", "unstable", "wrong", "early", "median time", "clear decided");
  for (std::size_t k = 0; k < kinds; ++k) {
    Row& r = rows[k];
    const auto& n = r.verdicts;
    fmt::print("{:12}{:10}{:8}{:8}{:9}{:10}{:7}{:7}{:14.1f}{:>15}\n", kind_names[k], n[0], n[1],
               n[2], n[3], n[4], r.wrong, r.early, r.median(),
               fmt::format("{} of {}", r.clear_and_decided, r.clear));
  }
}

/// Fifty thousand histories and their verdicts.
class SyntheticPairs : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    for (int i = 0; i < 50000; ++i) {
      pairs_.push_back(history(i));
      verdicts_.push_back(judged(pairs_.back(), pairs_.back().interval));
    }
  }
  static void TearDownTestSuite() {
    pairs_.clear();
    verdicts_.clear();
  }
  static std::vector<SyntheticPair> pairs_;
  static std::vector<Verdict> verdicts_;
};
std::vector<SyntheticPair> SyntheticPairs::pairs_;
std::vector<Verdict> SyntheticPairs::verdicts_;

// "Clear" histories are longer than 100 units and have little noise.
TEST_F(SyntheticPairs, AreRarelyMisjudged) {
  std::array<Row, kinds> rows;
  int wrong = 0;
  int at_rest = 0;  // among the wrong: called stable or damped, and going away
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const SyntheticPair& p = pairs_[i];
    const Verdict& v = verdicts_[i];
    Row& row = rows[static_cast<std::size_t>(p.kind)];
    ++row.verdicts[static_cast<std::size_t>(v.pair_class)];
    if (p.clean && p.end > 100) {
      ++row.clear;
      row.clear_and_decided += v.decided() ? 1 : 0;
    }
    if (v.decided()) row.times.push_back(v.time);
    const bool rest = v.pair_class == PairClass::stable || v.pair_class == PairClass::damped;
    if (!right(p, v)) {
      ++row.wrong;
      ++wrong;
      fmt::print("wrong: {}\n", describe(i, p, v));
      at_rest += goes_away(p.kind) && rest ? 1 : 0;
    } else if (goes_away(p.kind) && rest) {
      ++row.early;
    }
  }
  print(rows);
  EXPECT_LE(wrong, 100);
  // A drift that slows down as an approach does cannot be told from one.
  EXPECT_LE(at_rest, 5);
  // A judge that says nothing makes no mistakes either.
  const std::array<double, 7> latest_median{41, 55, 65, 50, 55, 75, 40};
  for (std::size_t k = 0; k < latest_median.size(); ++k) {
    EXPECT_GE(rows[k].clear_and_decided, 0.9 * rows[k].clear) << kind_names[k];
    EXPECT_LE(rows[k].median(), latest_median[k]) << kind_names[k];
  }
  // What begins to go away only just before a look cannot be told from rest, but little else is.
  for (const Kind kind : {Kind::grows, Kind::shrinks, Kind::wanders}) {
    const auto k = static_cast<std::size_t>(kind);
    EXPECT_LE(rows[k].early, 125) << kind_names[k];
  }
}

TEST_F(SyntheticPairs, AreJudgedAlikeAtAnySampling) {
  int compared = 0;
  int alike = 0;
  for (std::size_t i = 0; i < 360; ++i) {
    const SyntheticPair& p = pairs_[i];
    const Verdict fine = judged(p, 0.05);
    if (fine.time > p.end - 10) continue;  // the end of the run comes before a coarser one's look
    for (const double interval : {0.2, 0.83, 2.0}) {
      const Verdict v = judged(p, interval);
      EXPECT_TRUE(v.pair_class == fine.pair_class || !v.decided())
          << interval << ": " << describe(i, p, v) << " but " << describe(i, p, fine);
      ++compared;
      alike += v.decided() && std::abs(v.time - fine.time) <= interval + rules::look_interval;
    }
  }
  fmt::print("{} of {} verdicts fall at the time of the finest sampling's\n", alike, compared);
  EXPECT_GE(alike, 0.95 * compared);
}

TEST_F(SyntheticPairs, HaveTheirLimitsWithinTheStatedErrors) {
  std::array<int, 2> within{};  // exponential, and by a power of time
  std::array<int, 2> stated{};
  double error = 0;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const SyntheticPair& p = pairs_[i];
    if (p.kind > Kind::approaches || !verdicts_[i].decided()) continue;
    UniformSeries dz;
    for (int k = 0; k * p.interval <= p.end; ++k) dz.add(k * p.interval, p.dz(k * p.interval));
    const Outlook o = outlook(dz, UniformSeries::steps(verdicts_[i].time), rules::distance).value();
    const std::size_t by_power = p.decays[0].power > 0 ? 1 : 0;
    ++stated[by_power];
    within[by_power] += std::abs(o.limit - p.limit) <= o.error ? 1 : 0;
    error += o.error;
  }
  fmt::print(
      "limits within their errors: {} of {}, and {} of {} that are approached by a power of "
      "time; mean error {:.3f}\n",
      within[0], stated[0], within[1], stated[1], error / (stated[0] + stated[1]));
  EXPECT_GE(within[0], 0.99 * stated[0]);
  EXPECT_GE(within[1], 0.85 * stated[1]);
}

}  // namespace
}  // namespace ductile::drivers
