// What tests look at behind the fluid's interface.
#pragma once

#include <vector>

#include "ductile/fluid/fluid.hpp"
#include "fluid_impl.hpp"

namespace ductile::test {

inline std::vector<fluid::Patch>& patches(fluid::Fluid& fluid) {
  return fluid::Inside::of(fluid).patches_;
}

}  // namespace ductile::test
