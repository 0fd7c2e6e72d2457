// Numbers without order, the same in every run.
#pragma once

#include <cstddef>
#include <random>
#include <vector>

namespace ductile::testing_support {

/// So many numbers, evenly distributed from `low` to `high`.
inline std::vector<double> random_numbers(std::size_t count, double low, double high,
                                          unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(low, high);
  std::vector<double> v(count);
  for (double& x : v) x = number(random);
  return v;
}

}  // namespace ductile::testing_support
