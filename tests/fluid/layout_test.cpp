#include "layout.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

namespace {

using namespace ductile::fluid;

// Random boxes: merged ones are disjoint, hold the old ones, and do not depend on their order.
TEST(Layout, MergedBoxesAreDisjointAndHoldAll) {
  std::mt19937 random(7);
  const auto between = [&](int low, int high) {
    return std::uniform_int_distribution<int>(low, high)(random);
  };
  for (int trial = 0; trial < 300; ++trial) {
    const int period = trial % 2 == 0 ? 40 : 0;
    std::vector<Box> boxes;
    for (int n = between(1, 8); n > 0; --n) {
      Box b;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const int begin = axis == 2 && period > 0 ? between(-100, 100) : between(0, 30);
        b[axis] = {begin, begin + between(4, 9)};
      }
      boxes.push_back(b);
    }
    const auto key = [](const Box& b) {
      return std::array<int, 6>{b[0].begin, b[0].end, b[1].begin, b[1].end, b[2].begin, b[2].end};
    };
    const auto sorted = [&](const std::vector<Box>& list) {
      std::vector<std::array<int, 6>> keys;
      keys.reserve(list.size());
      for (const Box& b : list) keys.push_back(key(b));
      std::sort(keys.begin(), keys.end());
      return keys;
    };
    const std::vector<Box> result = merged(boxes, period);
    for (const Box& b : boxes) {
      EXPECT_EQ(std::count_if(result.begin(), result.end(),
                              [&](const Box& outer) { return contains(outer, b, period); }),
                1);
    }
    for (std::size_t a = 0; a < result.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        bool meet = true;
        for (const std::size_t axis : {0U, 1U}) {
          meet = meet && result[a][axis].begin < result[b][axis].end &&
                 result[b][axis].begin < result[a][axis].end;
        }
        meet = meet && touches(result[a][2].begin, result[a][2].size(), result[b][2], period);
        EXPECT_FALSE(meet);
      }
    }
    std::shuffle(boxes.begin(), boxes.end(), random);
    EXPECT_EQ(sorted(merged(boxes, period)), sorted(result));
  }
}

TEST(Layout, TouchesAndWithinAgreeWithCounting) {
  for (const int period : {0, 10}) {
    for (int first = -14; first < 25; ++first) {
      for (int count = 1; count <= 10; ++count) {
        for (const Range slab : {Range{0, 3}, {3, 7}, {7, 10}, {0, 10}}) {
          int inside = 0;
          for (int p = first; p < first + count; ++p) {
            const int plane = period > 0 ? ((p % period) + period) % period : p;
            inside += plane >= slab.begin && plane < slab.end ? 1 : 0;
          }
          EXPECT_EQ(touches(first, count, slab, period), inside > 0);
          EXPECT_EQ(within(first, count, slab, period), inside == count);
        }
      }
    }
  }
}

}  // namespace
