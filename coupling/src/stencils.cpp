#include "ductile/coupling/stencils.hpp"

#include <algorithm>
#include <cmath>

#include "ductile/coupling/kernel.hpp"
#include "stencil_kernel.hpp"

namespace ductile::coupling {
namespace {

template <class Number>
PatchField<Number> field_of(const fluid::Patch& patch, const std::array<Number*, 3>& component) {
  return {{patch.begin[0], patch.begin[1], patch.begin[2]},
          {patch.size[0], patch.size[1], patch.size[2]},
          patch.pitch,
          fluid::Patch::pad,
          {component[0], component[1], component[2]}};
}

}  // namespace

const StencilKernel& stencil_kernel([[maybe_unused]] fluid::InstructionSet set) {
#ifdef DUCTILE_X86
  if (set == fluid::InstructionSet::avx512) return avx512::stencil_kernel();
  if (set == fluid::InstructionSet::avx2) return avx2::stencil_kernel();
#endif
  return baseline::stencil_kernel();
}

Stencils::Stencils(fluid::InstructionSet set) : kernel_(&stencil_kernel(set)) {}

void Stencils::locate(std::span<const double> positions) {
  markers_.resize(positions.size() / 3);
  for (std::size_t m = 0; m < markers_.size(); ++m) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Weights w = weights(positions[3 * m + axis]);
      markers_[m].base[axis] = w.base;
      std::copy(w.phi.begin(), w.phi.end(), markers_[m].phi[axis]);
    }
  }
}

void Stencils::spread(std::span<const double> force, fluid::Patch& patch, int period) const {
  auto& f = patch.force;
  kernel_->spread(markers_.data(), markers_.size(), force.data(),
                  field_of<double>(patch, {f[0].data(), f[1].data(), f[2].data()}), period);
}

void Stencils::interpolate(const fluid::Patch& patch, int period, std::span<double> partial) const {
  const auto& u = patch.velocity;
  kernel_->interpolate(markers_.data(), markers_.size(),
                       field_of<const double>(patch, {u[0].data(), u[1].data(), u[2].data()}),
                       period, partial.data());
}

MarkerResponse::MarkerResponse(fluid::InstructionSet set) : kernel_(&stencil_kernel(set)) {}

void MarkerResponse::locate(std::span<const double> positions) {
  const std::size_t count = positions.size() / 3;
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  for (std::size_t n = 0; n < positions.size(); ++n) {
    const int base = floor_of(positions[n]) - 1;
    low[n % 3] = n < 3 ? base : std::min(low[n % 3], base);
    high[n % 3] = n < 3 ? base : std::max(high[n % 3], base);
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    size_[axis] = static_cast<std::size_t>(high[axis] - low[axis]) + 4;
  grid_.resize(4 * size_[0] * size_[1] * size_[2]);

  markers_.resize(count);
  for (std::size_t m = 0; m < count; ++m) {
    const Weights x = weights(positions[3 * m]);
    const Weights y = weights(positions[3 * m + 1]);
    const Weights z = weights(positions[3 * m + 2]);
    const auto offset = [&](const Weights& w, std::size_t axis) {
      return static_cast<std::size_t>(w.base - low[axis]);
    };
    markers_[m].corner = (offset(x, 0) * size_[1] + offset(y, 1)) * size_[2] + offset(z, 2);
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) markers_[m].across[4 * i + j] = x.phi[i] * y.phi[j];
    }
    std::copy(z.phi.begin(), z.phi.end(), markers_[m].along);
  }
}

void MarkerResponse::apply(std::span<const double> force, std::span<double> velocity) const {
  std::fill(grid_.begin(), grid_.end(), 0.0);
  kernel_->respond(markers_.data(), markers_.size(), size_.data(), force.data(), grid_.data(),
                   velocity.data());
}

}  // namespace ductile::coupling
