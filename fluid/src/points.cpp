#include "ductile/fluid/points.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <vector>

#include "ductile/fluid/delta.hpp"
#include "fluid_impl.hpp"
#include "layout.hpp"
#include "stencil_kernel.hpp"

namespace ductile::fluid {
namespace {

template <class Number>
PatchField<Number> field_of(const Patch& patch, const std::array<Number*, 3>& component) {
  return {{patch.begin[0], patch.begin[1], patch.begin[2]},
          {patch.size[0], patch.size[1], patch.size[2]},
          patch.pitch,
          Patch::pad,
          {component[0], component[1], component[2]}};
}

}  // namespace

const StencilKernel& stencil_kernel([[maybe_unused]] InstructionSet set) {
#ifdef DUCTILE_X86
  if (set == InstructionSet::avx512) return avx512::stencil_kernel();
  if (set == InstructionSet::avx2) return avx2::stencil_kernel();
#endif
  return baseline::stencil_kernel();
}

class Points::Impl {
 public:
  Impl(FluidImpl& fluid, int box)
      : fluid_(fluid),
        box_(fluid.holder_.at(static_cast<std::size_t>(box))),
        kernel_(stencil_kernel(*fluid.options_.instruction_set)) {}

  void locate(std::span<const double> positions) {
    stencils_.resize(positions.size() / 3);
    for (std::size_t m = 0; m < stencils_.size(); ++m) {
      Stencil& stencil = stencils_[m];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const Weights w = weights(positions[3 * m + axis]);
        stencil.base[axis] = w.base;
        std::copy(w.phi.begin(), w.phi.end(), stencil.phi[axis]);
      }
      assert(
          contains(fluid_.boxes_[static_cast<std::size_t>(box_)], nodes(stencil), fluid_.period()));
    }
  }
  [[nodiscard]] std::size_t size() const { return stencils_.size(); }
  [[nodiscard]] bool whole(std::size_t m) const {
    return within(stencils_[m].base[2], 4, fluid_.slab_, fluid_.period());
  }
  void add_force(const double* force) {
    for (Patch& patch : fluid_.patches_) {
      if (patch.box != box_) continue;
      auto& f = patch.force;
      kernel_.spread(stencils_.data(), stencils_.size(), force,
                     field_of<double>(patch, {f[0].data(), f[1].data(), f[2].data()}),
                     fluid_.period());
    }
  }
  void velocities(double* partial) const {
    std::fill_n(partial, 12 * stencils_.size(), 0.0);
    for (const Patch& patch : fluid_.patches_) {
      if (patch.box != box_) continue;
      const auto& u = patch.velocity;
      kernel_.interpolate(stencils_.data(), stencils_.size(),
                          field_of<const double>(patch, {u[0].data(), u[1].data(), u[2].data()}),
                          fluid_.period(), partial);
    }
  }

 private:
  [[maybe_unused]] static Box nodes(const Stencil& stencil) {
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box[axis] = {stencil.base[axis], stencil.base[axis] + 4};
    }
    return box;
  }

  FluidImpl& fluid_;
  int box_;  // of FluidImpl::boxes_
  const StencilKernel& kernel_;
  std::vector<Stencil> stencils_;
};

Points::Points(Fluid& fluid, int box) : impl_(std::make_unique<Impl>(Inside::of(fluid), box)) {}
Points::~Points() = default;
Points::Points(Points&&) noexcept = default;
Points& Points::operator=(Points&&) noexcept = default;

void Points::locate(std::span<const double> positions) {
  impl_->locate(positions);
}
std::size_t Points::size() const {
  return impl_->size();
}
bool Points::whole(std::size_t m) const {
  return impl_->whole(m);
}
void Points::add_force(std::span<const double> force) {
  assert(force.size() == 3 * size());
  impl_->add_force(force.data());
}
void Points::velocities(std::span<double> partial) const {
  assert(partial.size() == 12 * size());
  impl_->velocities(partial.data());
}

}  // namespace ductile::fluid
