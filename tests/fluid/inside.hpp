// What tests look at behind the fluid's interface.
#pragma once

#include <cstddef>
#include <variant>
#include <vector>

#include "ductile/fluid/fluid.hpp"
#include "fluid_impl.hpp"

namespace ductile::test {

inline std::vector<fluid::Patch>& patches(fluid::Fluid& fluid) {
  return fluid::Inside::of(fluid).patches_;
}

/// Nodes of a patch's arrays, those of the padding too.
inline std::size_t nodes_of(const fluid::Patch& patch) {
  return std::visit([](const auto& local) { return local.force[0].size(); }, patch.local);
}
inline double force_of(const fluid::Patch& patch, std::size_t axis, std::size_t node) {
  return std::visit([&](const auto& local) -> double { return local.force[axis][node]; },
                    patch.local);
}
inline double velocity_of(const fluid::Patch& patch, std::size_t axis, std::size_t node) {
  return std::visit([&](const auto& local) -> double { return local.velocity[axis][node]; },
                    patch.local);
}
/// As of read_velocity(); a density that weighs nothing is 1.
inline double momentum_of(const fluid::Patch& patch, std::size_t axis, std::size_t node) {
  return std::visit([&](const auto& local) -> double { return local.momentum[axis][node]; },
                    patch.local);
}
inline double density_of(const fluid::Patch& patch, std::size_t node) {
  return std::visit(
      [&](const auto& local) -> double { return local.density.empty() ? 1 : local.density[node]; },
      patch.local);
}
inline void set_force(fluid::Patch& patch, std::size_t axis, std::size_t node, double value) {
  std::visit(
      [&]<class Number>(fluid::LocalFields<Number>& local) {
        local.force[axis][node] = static_cast<Number>(value);
      },
      patch.local);
}
inline void set_velocity(fluid::Patch& patch, std::size_t axis, std::size_t node, double value) {
  std::visit(
      [&]<class Number>(fluid::LocalFields<Number>& local) {
        local.velocity[axis][node] = static_cast<Number>(value);
      },
      patch.local);
}

}  // namespace ductile::test
