#include "ductile/coupling/stencils.hpp"

#include <algorithm>
#include <cmath>
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

void MarkerResponse::locate(std::span<const double> positions) {
  const std::size_t count = positions.size() / 3;
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  for (std::size_t n = 0; n < positions.size(); ++n) {
    const int base = static_cast<int>(std::floor(positions[n])) - 1;
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
    markers_[m].along = z.phi;
  }
}

void MarkerResponse::apply(std::span<const double> force, std::span<double> velocity) const {
  // Two nodes at a time.
  using Two = double __attribute__((vector_size(64)));
  const auto get = [](const double* p) {
    Two v;
    std::memcpy(&v, p, sizeof v);
    return v;
  };
  const auto row = [this](const Marker& marker, std::size_t i, std::size_t j) {
    return grid_.data() + 4 * (marker.corner + (i * size_[1] + j) * size_[2]);
  };

  std::fill(grid_.begin(), grid_.end(), 0.0);
  for (std::size_t m = 0; m < markers_.size(); ++m) {
    const Marker& marker = markers_[m];
    const Lanes f = {force[3 * m], force[3 * m + 1], force[3 * m + 2], 0};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        double* node = row(marker, i, j);
        const Lanes g = marker.across[4 * i + j] * f;
        // A node at a time: what the marker before has just stored is then loaded as it was stored.
        for (std::size_t k = 0; k < 4; ++k)
          store(node + 4 * k, load(node + 4 * k) + marker.along[k] * g);
      }
    }
  }
  for (std::size_t m = 0; m < markers_.size(); ++m) {
    const Marker& marker = markers_[m];
    Two first{};
    Two second{};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        const double* node = row(marker, i, j);
        const double w = marker.across[4 * i + j];
        first += w * get(node);
        second += w * get(node + 8);
      }
    }
    const auto& p = marker.along;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      velocity[3 * m + axis] =
          0.5 * (((p[0] * first[axis] + p[1] * first[4 + axis]) + p[2] * second[axis]) +
                 p[3] * second[4 + axis]);
    }
  }
}

}  // namespace ductile::coupling
