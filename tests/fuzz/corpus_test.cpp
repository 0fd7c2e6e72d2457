// What fuzzers have found worth keeping, and damage to a checkpoint, byte by byte.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "fuzz/inputs.hpp"
#include "output/checkpoint.hpp"
#include "support/temporary_directory.hpp"

namespace ductile::drivers {
namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void feed(const fs::path& directory, void (*input)(std::string_view)) {
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(directory)) {
    if (!entry.is_regular_file()) continue;
    SCOPED_TRACE(entry.path().string());
    EXPECT_NO_THROW(input(contents(entry.path())));
    ++count;
  }
  EXPECT_GT(count, 5U) << directory;
}

TEST(Corpus, OfScenariosIsReadOrRefused) {
  feed(fs::path(DUCTILE_CORPUS) / "scenario", fuzz::scenario);
  feed(DUCTILE_SCENARIO_DIR, fuzz::scenario);
}

TEST(Corpus, OfCommandLinesIsReadOrRefused) {
  feed(fs::path(DUCTILE_CORPUS) / "command_line", fuzz::command_line);
}

TEST(Corpus, OfCampaignsIsReadOrRefused) {
  feed(fs::path(DUCTILE_CORPUS) / "campaign", fuzz::campaign);
  feed(fs::path(DUCTILE_SCENARIO_DIR) / "paper", fuzz::campaign);
}

TEST(Corpus, OfCheckpointsIsRefused) {
  feed(fs::path(DUCTILE_CORPUS) / "checkpoint", fuzz::checkpoint);
}

class CheckpointFile : public testing::Test {
 protected:
  void write(double seed) const {
    NewCheckpoint checkpoint(file_);
    std::vector<double> numbers(20);
    for (std::size_t n = 0; n < numbers.size(); ++n)
      numbers[n] = std::sin(seed + static_cast<double>(n));
    checkpoint.put("scenario", std::string_view("name = \"x\"\n"));
    checkpoint.put("record/steps", std::vector<double>{3, -0.0});
    checkpoint.put("record/frames", std::vector<double>{});
    checkpoint.put("state/fluid/time", std::vector<double>{seed});
    checkpoint.put("state/fluid/f00", numbers);
    checkpoint.commit(before_);
  }
  [[nodiscard]] std::string refusal() const {
    try {
      const Checkpoint whole(file_);
    } catch (const CheckpointError& error) {
      return error.what();
    }
    return "";
  }
  void put(const std::string& bytes) const {
    std::ofstream(file_, std::ios::binary | std::ios::trunc) << bytes;
  }

  testing_support::TemporaryDirectory temporary_;
  fs::path directory_ = temporary_.path();
  fs::path file_ = directory_ / "checkpoint.h5";
  fs::path before_ = directory_ / "checkpoint-before.h5";
};

TEST_F(CheckpointFile, GivesBackEveryBit) {
  write(1);
  const std::string first = contents(file_);
  write(0.1);
  EXPECT_EQ(contents(before_), first);
  EXPECT_FALSE(fs::exists(directory_ / "checkpoint.h5.part"));
  const Checkpoint whole(file_);
  EXPECT_EQ(whole.text("scenario"), "name = \"x\"\n");
  EXPECT_EQ(whole.numbers("state/fluid/time"), std::vector{0.1});
  const std::vector<double> steps = whole.numbers("record/steps");
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_TRUE(steps[1] == 0 && std::signbit(steps[1]));
  EXPECT_TRUE(whole.numbers("record/frames").empty());
  std::vector<double> numbers(20);
  whole.read("state/fluid/f00", numbers);
  for (std::size_t n = 0; n < numbers.size(); ++n)
    EXPECT_EQ(numbers[n], std::sin(0.1 + static_cast<double>(n)));
  // In single precision where that loses nothing, and nowhere else.
  EXPECT_EQ(Checkpoint(before_).numbers("state/fluid/time"), std::vector{1.0});
  std::vector<double> fewer(19);
  EXPECT_THROW(whole.read("state/fluid/f00", fewer), CheckpointError);
  EXPECT_THROW(whole.read("state/fluid/f01", numbers), CheckpointError);
  EXPECT_THROW(static_cast<void>(whole.numbers("scenario")), CheckpointError);
  EXPECT_THROW(static_cast<void>(whole.text("state")), CheckpointError);
}

TEST_F(CheckpointFile, IsNotWrittenOfWhatIsNotFinite) {
  write(1);
  const std::string good = contents(file_);
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    NewCheckpoint checkpoint(file_);
    EXPECT_THROW(checkpoint.put("state/x", std::vector<double>{1, bad}), NotFinite);
  }
  EXPECT_EQ(contents(file_), good);
  EXPECT_FALSE(fs::exists(directory_ / "checkpoint.h5.part"));
}

// Every bit of it in turn, and 1000 places at which it may end.
TEST_F(CheckpointFile, IsRefusedIfAnyBitIsAnother) {
  write(1);
  const std::string good = contents(file_);
  EXPECT_EQ(refusal(), "");
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ (1 << (at % 8)));
    put(bad);
    EXPECT_NE(refusal(), "") << "byte " << at;
  }
  for (std::size_t n = 0; n < 1000; ++n) {
    put(good.substr(0, n * good.size() / 1000));
    EXPECT_NE(refusal(), "") << n;
  }
  put(good + '\0');
  EXPECT_NE(refusal().find("is damaged"), std::string::npos);
  put(good);
  EXPECT_EQ(refusal(), "");
}

TEST_F(CheckpointFile, SaysWhatIsWrongWithIt) {
  write(1);
  const std::string good = contents(file_);
  const std::string own = "format " + std::to_string(checkpoint_format);
  const std::string next = "format " + std::to_string(checkpoint_format + 1);
  std::string other = good;
  other.replace(other.find(own), own.size(), next);
  put(other);
  EXPECT_EQ(refusal(), file_.string() + " is of " + next + ", and this program knows " + own +
                           ": go on with the version of ductile that wrote it");
  put("x,y\n1,2\n");
  EXPECT_EQ(refusal(), file_.string() + " is no checkpoint of ductile");
  put(good.substr(0, good.size() - 100));
  EXPECT_NE(refusal().find(" bytes"), std::string::npos) << refusal();
  // Not there is not damaged.
  fs::remove(file_);
  EXPECT_THROW(Checkpoint whole(file_), OutputError);
}

}  // namespace
}  // namespace ductile::drivers
