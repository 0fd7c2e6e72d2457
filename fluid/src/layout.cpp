#include "layout.hpp"

#include <algorithm>

namespace ductile::fluid {
namespace {

bool overlap(const Range& a, const Range& b) {
  return a.begin < b.end && b.begin < a.end;
}
Range join(const Range& a, const Range& b) {
  return {std::min(a.begin, b.begin), std::max(a.end, b.end)};
}

// Joins b to a if they overlap in any periodic image.
bool try_join(Box& a, const Box& b, int period) {
  if (!overlap(a[0], b[0]) || !overlap(a[1], b[1])) return false;
  for (const int image : {-1, 0, 1}) {
    if (image != 0 && period == 0) continue;
    const Range z = {b[2].begin + image * period, b[2].end + image * period};
    if (!overlap(a[2], z)) continue;
    a = {join(a[0], b[0]), join(a[1], b[1]), join(a[2], z)};
    if (period > 0 && a[2].size() >= period) a[2] = {0, period};
    a = wrapped(a, period);
    return true;
  }
  return false;
}

}  // namespace

int first_image(int plane, int period) {
  if (period == 0 || (plane >= 0 && plane < period)) return plane;
  const int r = plane % period;
  return r < 0 ? r + period : r;
}

Box wrapped(Box box, int period) {
  if (period > 0) {
    const int begin = first_image(box[2].begin, period);
    box[2] = {begin, begin + box[2].size()};
  }
  return box;
}

std::vector<Box> merged(std::span<const Box> boxes, int period) {
  std::vector<Box> result;
  for (const Box& box : boxes) {
    Box grown = wrapped(box, period);
    for (std::size_t n = 0; n < result.size();) {
      if (try_join(grown, result[n], period)) {
        result.erase(result.begin() + static_cast<std::ptrdiff_t>(n));
        n = 0;  // the larger box may now overlap those passed before
      } else {
        ++n;
      }
    }
    result.push_back(grown);
  }
  return result;
}

bool contains(const Box& outer, const Box& inner, int period) {
  for (const std::size_t axis : {0U, 1U}) {
    if (inner[axis].begin < outer[axis].begin || inner[axis].end > outer[axis].end) return false;
  }
  return within(inner[2].begin, inner[2].size(), outer[2], period);
}

bool touches(int first, int count, Range slab, int period) {
  if (period == 0) return overlap({first, first + count}, slab);
  return first_image(first - slab.begin, period) < slab.size() ||
         first_image(slab.begin - first, period) < count;
}

bool within(int first, int count, Range slab, int period) {
  if (period == 0) return first >= slab.begin && first + count <= slab.end;
  if (slab.size() == period) return true;
  return first_image(first - slab.begin, period) + count <= slab.size();
}

}  // namespace ductile::fluid
