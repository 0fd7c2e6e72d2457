// The boxes in which points act: what is kept of them on this rank.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ductile/fluid/delta.hpp"
#include "fluid_impl.hpp"
#include "layout.hpp"

namespace ductile::fluid {
namespace {

// (momentum + half force)/density of one row, a density that is not given being 1.
template <class Number>
void divide(const Number* momentum, const Number* force, Number half, const Number* density,
            int count, Number* velocity) {
  if (density == nullptr) {
#ifdef __clang__
#pragma clang loop vectorize(assume_safety)
#else
#pragma GCC ivdep
#endif
    for (int k = 0; k < count; ++k) velocity[k] = momentum[k] + half * force[k];
  } else {
#ifdef __clang__
#pragma clang loop vectorize(assume_safety)
#else
#pragma GCC ivdep
#endif
    for (int k = 0; k < count; ++k) velocity[k] = (momentum[k] + half * force[k]) / density[k];
  }
}

}  // namespace

Box FluidImpl::domain() const {
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int wall = options_.boundary[axis] == Boundary::regularized ? 1 : 0;
    box[axis] = {wall, options_.nodes[axis] - wall};
  }
  if (options_.mirror != Mirror::none) box[1].begin = image(box[1].end - 1);
  return box;
}

Box FluidImpl::with_image(Box box) const {
  if (options_.mirror != Mirror::none && box[1].begin < 0) {
    box[1].end = std::max(box[1].end, image(box[1].begin) + 1);
  }
  return box;
}

Box FluidImpl::box_around(const Box& reach) const {
  // How far the points may move before they leave the box: a node across the channel, two along it.
  constexpr std::array<int, 3> margin = {1, 1, 2};
  const Box allowed = domain();
  Box box = reach;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box[axis].begin -= margin[axis];
    box[axis].end += margin[axis];
    if (axis == 2 && period() > 0) {
      box[axis].end = box[axis].begin + std::min(box[axis].size(), period());
    } else {
      box[axis].begin = std::max(box[axis].begin, allowed[axis].begin);
      box[axis].end = std::min(box[axis].end, allowed[axis].end);
    }
  }
  return with_image(box);
}

// Every node is to be in one patch at most, so boxes that overlap become one.
void FluidImpl::place_boxes(std::span<const Box> boxes) {
  const Box allowed = domain();
  std::vector<Box> asked;
  for (const Box& box : boxes) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool wraps = axis == 2 && period() > 0;
      if (box[axis].size() < 1 || (wraps && box[axis].size() > period()) ||
          (!wraps &&
           (box[axis].begin < allowed[axis].begin || box[axis].end > allowed[axis].end))) {
        reject("box of nodes " + std::to_string(box[axis].begin) + " to " +
               std::to_string(box[axis].end) + " along " + std::string(1, "xyz"[axis]) +
               " is not inside the fluid");
      }
    }
    asked.push_back(with_image(box));
  }
  boxes_ = merged(asked, period());
  holder_.clear();
  for (const Box& box : asked) {
    const auto holder = std::find_if(boxes_.begin(), boxes_.end(), [&](const Box& outer) {
      return contains(outer, box, period());
    });
    holder_.push_back(static_cast<int>(holder - boxes_.begin()));
  }
  patches_.clear();
  for (std::size_t b = 0; b < boxes_.size(); ++b) place_patches(static_cast<int>(b));
  list_met();
}

// Several parts of a box lie on this rank where the box runs round the periodic end.
void FluidImpl::place_patches(int index) {
  const Box& box = boxes_[static_cast<std::size_t>(index)];
  const int nz = options_.nodes[2];
  // Periodic images of the slab that the box may meet.
  const int first = static_cast<int>(std::floor(static_cast<double>(box[2].begin) / nz));
  for (int image = first; image * nz < box[2].end; ++image) {
    const int begin = std::max(box[2].begin, slab_.begin + image * nz);
    const int end = std::min(box[2].end, slab_.end + image * nz);
    if (begin >= end) continue;
    Patch patch;
    patch.box = index;
    patch.begin = {box[0].begin, box[1].begin, begin - image * nz};
    patch.size = {box[0].size(), box[1].size(), end - begin};
    patch.pitch = patch.size[2] + 2 * Patch::pad;
    const auto count = static_cast<std::size_t>(patch.size[0] * patch.size[1] * patch.pitch);
    if (options_.arithmetic == Precision::single_precision) patch.local = LocalFields<float>{};
    std::visit(
        [&](auto& local) {
          for (auto* vectors : {&local.force, &local.velocity}) {
            for (auto& values : *vectors) values.assign(count, 0);
          }
        },
        patch.local);
    patches_.push_back(std::move(patch));
  }
}

bool FluidImpl::touches(int rank, const Box& box) const {
  return fluid::touches(box[2].begin, box[2].size(), slab(rank), period());
}

void FluidImpl::reached(int rank, std::span<const double> positions, std::vector<int>& points,
                        std::vector<std::size_t>& split) const {
  const Range planes = slab(rank);
  points.clear();
  split.clear();
  for (std::size_t m = 0; m < positions.size() / 3; ++m) {
    const int first = first_node(positions[3 * m + 2]);
    if (!fluid::touches(first, 4, planes, period())) continue;
    if (!within(first, 4, planes, period())) split.push_back(points.size());
    points.push_back(static_cast<int>(m));
  }
}

void FluidImpl::list_met() {
  const std::size_t columns = column(options_.nodes[0], 0);
  std::vector<std::vector<std::size_t>> met(columns);
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    const Patch& patch = patches_[p];
    for (int i = 0; i < patch.size[0]; ++i) {
      for (int j = std::max(0, -patch.begin[1]); j < patch.size[1]; ++j) {
        met[column(patch.begin[0] + i, patch.begin[1] + j)].push_back(p);
      }
    }
  }
  first_met_ = {0};
  met_.clear();
  for (auto& of_column : met) {
    std::sort(of_column.begin(), of_column.end(), [&](std::size_t a, std::size_t b) {
      return patches_[a].begin[2] < patches_[b].begin[2];
    });
    met_.insert(met_.end(), of_column.begin(), of_column.end());
    first_met_.push_back(met_.size());
  }
}

void FluidImpl::drop_force() {
  for (Patch& patch : patches_) {
    std::visit(
        [](auto& local) {
          for (auto& force : local.force) std::fill(force.begin(), force.end(), 0);
        },
        patch.local);
  }
}

// Where force has an image, the two are added up above the plane, and nothing is left below: done
// again it changes nothing, so force may be added in between.
void FluidImpl::fold_force() {
  if (options_.mirror == Mirror::none) return;
  for (Patch& patch : patches_) {
    std::visit([&](auto& local) { fold(patch, local.force); }, patch.local);
  }
}

template <class Number>
void FluidImpl::fold(const Patch& patch, std::array<std::vector<Number>, 3>& force) const {
  for (int i = 0; i < patch.size[0]; ++i) {
    for (int y = patch.begin[1]; y < 0; ++y) {
      const std::ptrdiff_t low = patch.at(i, y - patch.begin[1], 0);
      const std::ptrdiff_t high = patch.at(i, image(y) - patch.begin[1], 0);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const Number sign = axis == 1 ? -1 : 1;
        Number* f = force[axis].data();
        for (int k = 0; k < patch.size[2]; ++k) f[high + k] += sign * f[low + k];
        std::fill_n(f + low - Patch::pad, patch.pitch, Number{0});
      }
    }
    if (const auto first = row_on_plane(patch, i)) {
      std::fill_n(&force[1][*first], patch.pitch, Number{0});
    }
  }
}

void FluidImpl::double_force_on_plane() {
  if (options_.mirror != Mirror::on_node) return;
  for (Patch& patch : patches_) {
    std::visit(
        [&](auto& local) {
          for (int i = 0; i < patch.size[0]; ++i) {
            const auto first = row_on_plane(patch, i);
            if (!first) continue;
            for (const std::size_t axis : {0, 2}) {
              auto* f = &local.force[axis][*first];
              for (std::ptrdiff_t n = 0; n < patch.pitch; ++n) f[n] *= 2;
            }
          }
        },
        patch.local);
  }
}

// Where the row of nodes begins that is its own image, padding included.
std::optional<std::size_t> FluidImpl::row_on_plane(const Patch& patch, int i) const {
  const int j = -patch.begin[1];
  if (options_.mirror != Mirror::on_node || j < 0 || j >= patch.size[1]) return std::nullopt;
  return static_cast<std::size_t>(patch.at(i, j, -Patch::pad));
}

void FluidImpl::fill_image_of_velocity(Patch& patch) const {
  if (options_.mirror == Mirror::none) return;
  std::visit([&](auto& local) { fill_image(patch, local.velocity); }, patch.local);
}

template <class Number>
void FluidImpl::fill_image(const Patch& patch, std::array<std::vector<Number>, 3>& vectors) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Number sign = axis == 1 ? -1 : 1;
    for (int i = 0; i < patch.size[0]; ++i) {
      for (int y = patch.begin[1]; y < 0; ++y) {
        const Number* from = vectors[axis].data() + patch.at(i, image(y) - patch.begin[1], 0);
        Number* to = vectors[axis].data() + patch.at(i, y - patch.begin[1], 0);
        for (int k = 0; k < patch.size[2]; ++k) to[k] = sign * from[k];
      }
    }
  }
}

void FluidImpl::update_velocity() {
  fold_force();
  for (Patch& patch : patches_) {
    std::visit(
        [&](auto& local) {
          make_moments(local);
          update(patch, local);
        },
        patch.local);
    fill_image_of_velocity(patch);
  }
}

template <class Number>
void FluidImpl::update(const Patch& patch, LocalFields<Number>& local) const {
  for (int i = 0; i < patch.size[0]; ++i) {
    for (int j = std::max(0, -patch.begin[1]); j < patch.size[1]; ++j) {
      const std::ptrdiff_t first = patch.at(i, j, 0);
      // On a mirror plane the image's force is still to be added.
      const auto on_plane = row_on_plane(patch, i);
      const Number half = on_plane == static_cast<std::size_t>(first - Patch::pad) ? 1 : 0.5;
      const Number* density = local.density.empty() ? nullptr : local.density.data() + first;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        divide(local.momentum[axis].data() + first, local.force[axis].data() + first, half, density,
               patch.size[2], local.velocity[axis].data() + first);
      }
    }
  }
}

}  // namespace ductile::fluid
