// The precisions in which a fluid may store and compute.
#pragma once

#include <array>

#include "ductile/fluid/fluid.hpp"

namespace ductile::test {

struct Precisions {
  const char* name;
  fluid::Precision storage;
  fluid::Precision arithmetic;

  void choose(fluid::Options& options) const {
    options.storage = storage;
    options.arithmetic = arithmetic;
  }
  [[nodiscard]] bool all_double() const { return storage == fluid::Precision::double_precision; }
  [[nodiscard]] bool all_single() const { return arithmetic == fluid::Precision::single_precision; }
};

inline constexpr std::array<Precisions, 3> precisions = {
    {{"double", fluid::Precision::double_precision, fluid::Precision::double_precision},
     {"single_storage", fluid::Precision::single_precision, fluid::Precision::double_precision},
     {"single", fluid::Precision::single_precision, fluid::Precision::single_precision}}};

}  // namespace ductile::test
