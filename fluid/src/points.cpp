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

// `set` is available.
template <class Number>
const StencilKernel<Number>& stencil_kernel([[maybe_unused]] InstructionSet set) {
#ifdef DUCTILE_X86
  if (set == InstructionSet::avx512) return avx512::stencil_kernel<Number>();
  if (set == InstructionSet::avx2) return avx2::stencil_kernel<Number>();
#endif
  return baseline::stencil_kernel<Number>();
}

}  // namespace

class Points::Impl {
 public:
  Impl(FluidImpl& fluid, int box)
      : fluid_(fluid), box_(fluid.holder_.at(static_cast<std::size_t>(box))) {}

  void locate(std::span<const double> positions) {
    count_ = positions.size() / 3;
    x_.assign(positions.begin(), positions.end());
    part_.clear();
    part_x_.clear();
    split_ = 0;
    for (std::size_t m = 0; m < count_; ++m) {
      assert(contains(fluid_.boxes_[static_cast<std::size_t>(box_)], nodes(m), fluid_.period()));
      if (in_one_patch(m)) continue;
      part_.push_back(m);
      part_x_.insert(part_x_.end(), &x_[3 * m], &x_[3 * m] + 3);
      if (!whole(m)) ++split_;
    }
  }
  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] bool whole(std::size_t m) const {
    return within(first_node(x_[3 * m + 2]), 4, fluid_.slab_, fluid_.period());
  }
  [[nodiscard]] std::size_t split() const { return split_; }
  void add_force(const double* force) {
    for (Patch& patch : fluid_.patches_) {
      if (patch.box != box_) continue;
      std::visit(
          [&]<class Number>(LocalFields<Number>& local) {
            auto& f = local.force;
            kernel<Number>().spread(
                x_.data(), count_, force,
                field_of<Number>(patch, {f[0].data(), f[1].data(), f[2].data()}), fluid_.period());
          },
          patch.local);
    }
  }
  void velocities(double* velocity, double* partial) const {
    part_sums_.assign(12 * part_.size(), 0.0);
    for (const Patch& patch : fluid_.patches_) {
      if (patch.box != box_) continue;
      std::visit(
          [&]<class Number>(const LocalFields<Number>& local) {
            const auto& u = local.velocity;
            const auto field =
                field_of<const Number>(patch, {u[0].data(), u[1].data(), u[2].data()});
            const StencilKernel<Number>& loops = kernel<Number>();
            loops.interpolate(x_.data(), count_, field, fluid_.period(), velocity);
            if (part_.empty()) return;
            loops.interpolate_planes(part_x_.data(), part_.size(), field, fluid_.period(),
                                     part_sums_.data());
          },
          patch.local);
    }
    for (std::size_t n = 0; n < part_.size(); ++n) {
      const double* sums = &part_sums_[12 * n];
      if (whole(part_[n])) {
        for (std::size_t axis = 0; axis < 3; ++axis)
          velocity[3 * part_[n] + axis] = sum_of_planes(sums + 4 * axis);
      } else {
        partial = std::copy_n(sums, 12, partial);
      }
    }
  }

 private:
  template <class Number>
  [[nodiscard]] const StencilKernel<Number>& kernel() const {
    return stencil_kernel<Number>(*fluid_.options_.instruction_set);
  }
  [[nodiscard]] bool in_one_patch(std::size_t m) const {
    const int first = first_image(first_node(x_[3 * m + 2]), fluid_.period());
    return std::any_of(fluid_.patches_.begin(), fluid_.patches_.end(), [&](const Patch& patch) {
      return patch.box == box_ && within(first, 4, patch.planes(), 0);
    });
  }
  [[nodiscard, maybe_unused]] Box nodes(std::size_t m) const {
    Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int first = first_node(x_[3 * m + axis]);
      box[axis] = {first, first + 4};
    }
    return box;
  }

  FluidImpl& fluid_;
  int box_;  // of FluidImpl::boxes_
  std::size_t count_ = 0;
  std::vector<double> x_;
  std::vector<std::size_t> part_;  // points whose planes are not all in one patch
  std::vector<double> part_x_;     // theirs
  mutable std::vector<double> part_sums_;
  std::size_t split_ = 0;
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
std::size_t Points::split() const {
  return impl_->split();
}
void Points::velocities(std::span<double> velocity, std::span<double> partial) const {
  assert(velocity.size() == 3 * size() && partial.size() == 12 * split());
  impl_->velocities(velocity.data(), partial.data());
}

}  // namespace ductile::fluid
