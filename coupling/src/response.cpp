#include "response.hpp"

#include <algorithm>

#include "ductile/fluid/delta.hpp"

namespace ductile::coupling {

using fluid::Weights;
using fluid::weights;

const ResponseKernel& response_kernel([[maybe_unused]] InstructionSet set) {
#ifdef DUCTILE_X86
  if (set == InstructionSet::avx512) return avx512::response_kernel();
  if (set == InstructionSet::avx2) return avx2::response_kernel();
#endif
  return baseline::response_kernel();
}

MarkerResponse::MarkerResponse(fluid::Mirror mirror, InstructionSet set)
    : mirror_(mirror), kernel_(&response_kernel(set)) {}

void MarkerResponse::locate(std::span<const double> positions, double share) {
  share_ = share;
  const std::size_t count = positions.size() / 3;
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  for (std::size_t n = 0; n < positions.size(); ++n) {
    const int base = fluid::first_node(positions[n]);
    low[n % 3] = n < 3 ? base : std::min(low[n % 3], base);
    high[n % 3] = n < 3 ? base : std::max(high[n % 3], base);
  }
  low_y_ = low[1];
  if (mirror_ != fluid::Mirror::none) {
    // Room for the images of the nodes below the plane.
    high[1] = std::max(high[1], fluid::image(mirror_, low[1]) - 3);
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
  kernel_->spread(markers_.data(), markers_.size(), size_.data(), force.data(), grid_.data());
  fold();
  kernel_->gather(markers_.data(), markers_.size(), size_.data(), grid_.data(), velocity.data());
}

// The fluid's share of the force, with its image in a mirror plane.
void MarkerResponse::fold() const {
  if (mirror_ == fluid::Mirror::none || (share_ == 1 && low_y_ > 0)) return;
  const auto row = [&](std::size_t i, int y) {
    return &grid_[4 * (i * size_[1] + static_cast<std::size_t>(y - low_y_)) * size_[2]];
  };
  const int end = low_y_ + static_cast<int>(size_[1]);
  for (std::size_t i = 0; i < size_[0]; ++i) {
    for (int y = std::max(0, low_y_); y < end; ++y) {
      const int image = fluid::image(mirror_, y);
      double* high = row(i, y);
      double* low = image >= low_y_ ? row(i, image) : nullptr;
      for (std::size_t n = 0; n < 4 * size_[2]; ++n) {
        const double sign = n % 4 == 1 ? -1 : 1;
        const double sum = share_ * (low ? high[n] + sign * low[n] : high[n]);
        high[n] = sum;
        if (low) low[n] = sign * sum;
      }
    }
  }
}

}  // namespace ductile::coupling
