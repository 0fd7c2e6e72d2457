#include "ductile/coupling/stencils.hpp"

#include <algorithm>
#include <cstring>

#include "ductile/coupling/kernel.hpp"

namespace ductile::coupling {
namespace {

// Four planes of one row at a time.
using Lanes = double __attribute__((vector_size(32)));

Lanes load(const double* p) {
  Lanes v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
void store(double* p, Lanes v) {
  std::memcpy(p, &v, sizeof v);
}

// Calls f(k) for each offset k of a stencil's first plane in the patch, -3 <= k < size. Where z is
// periodic the patch may meet the stencil at both of its ends.
template <class F>
void for_images(int base, const fluid::Patch& patch, int period, const F& f) {
  int k = base - patch.begin[2];
  if (period > 0) {
    k = (k + 3) % period;
    if (k < 0) k += period;
    k -= 3;
    if (k < 0 && k + period < patch.size[2]) f(k + period);
  }
  if (k >= -3 && k < patch.size[2]) f(k);
}

}  // namespace

void Stencils::locate(std::span<const double> positions) {
  markers_.resize(positions.size() / 3);
  for (std::size_t m = 0; m < markers_.size(); ++m) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Weights w = weights(positions[3 * m + axis]);
      markers_[m].base[axis] = w.base;
      markers_[m].phi[axis] = w.phi;
    }
  }
}

void Stencils::spread(std::span<const double> force, fluid::Patch& patch, int period) const {
  for (std::size_t m = 0; m < markers_.size(); ++m) {
    const Marker& marker = markers_[m];
    for_images(marker.base[2], patch, period, [&](int k) {
      const Lanes z = load(marker.phi[2].data());
      const Lanes fx = z * force[3 * m];
      const Lanes fy = z * force[3 * m + 1];
      const Lanes fz = z * force[3 * m + 2];
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
          const double w = marker.phi[0][static_cast<std::size_t>(i)] *
                           marker.phi[1][static_cast<std::size_t>(j)];
          const std::ptrdiff_t n =
              patch.at(marker.base[0] - patch.begin[0] + i, marker.base[1] - patch.begin[1] + j, k);
          double* x = patch.force[0].data() + n;
          double* y = patch.force[1].data() + n;
          double* zz = patch.force[2].data() + n;
          store(x, load(x) + w * fx);
          store(y, load(y) + w * fy);
          store(zz, load(zz) + w * fz);
        }
      }
    });
  }
}

void Stencils::interpolate(const fluid::Patch& patch, int period, std::span<double> partial) const {
  for (std::size_t m = 0; m < markers_.size(); ++m) {
    const Marker& marker = markers_[m];
    for_images(marker.base[2], patch, period, [&](int k) {
      Lanes ux{};
      Lanes uy{};
      Lanes uz{};
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
          const double w = marker.phi[0][static_cast<std::size_t>(i)] *
                           marker.phi[1][static_cast<std::size_t>(j)];
          const std::ptrdiff_t n =
              patch.at(marker.base[0] - patch.begin[0] + i, marker.base[1] - patch.begin[1] + j, k);
          ux += w * load(patch.velocity[0].data() + n);
          uy += w * load(patch.velocity[1].data() + n);
          uz += w * load(patch.velocity[2].data() + n);
        }
      }
      const Lanes z = load(marker.phi[2].data());
      double* sum = &partial[12 * m];
      store(sum, load(sum) + z * ux);
      store(sum + 4, load(sum + 4) + z * uy);
      store(sum + 8, load(sum + 8) + z * uz);
    });
  }
}

MarkerResponse::MarkerResponse(std::span<const double> positions) {
  stencils_.locate(positions);
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t m = 0; m < stencils_.size(); ++m) {
      const int base = stencils_[m].base[axis];
      low[axis] = m == 0 ? base : std::min(low[axis], base);
      high[axis] = m == 0 ? base + 4 : std::max(high[axis], base + 4);
    }
    patch_.begin[axis] = low[axis];
    patch_.size[axis] = high[axis] - low[axis];
  }
  patch_.pitch = patch_.size[2] + 2 * fluid::Patch::pad;
  const auto count = static_cast<std::size_t>(patch_.size[0] * patch_.size[1] * patch_.pitch);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    patch_.force[axis].resize(count);
    patch_.velocity[axis].resize(count);
  }
}

void MarkerResponse::apply(std::span<const double> force, std::span<double> velocity) const {
  for (auto& f : patch_.force) std::fill(f.begin(), f.end(), 0.0);
  stencils_.spread(force, patch_, 0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::transform(patch_.force[axis].begin(), patch_.force[axis].end(),
                   patch_.velocity[axis].begin(), [](double f) { return 0.5 * f; });
  }
  std::vector<double> partial(4 * velocity.size(), 0.0);
  stencils_.interpolate(patch_, 0, partial);
  for (std::size_t n = 0; n < velocity.size(); ++n) {
    const double* p = &partial[4 * n];
    velocity[n] = ((p[0] + p[1]) + p[2]) + p[3];
  }
}

}  // namespace ductile::coupling
