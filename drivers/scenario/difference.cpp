#include "scenario/difference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "scenario/writer.hpp"

namespace ductile::drivers {

std::optional<std::string> difference(const Scenario& before, const Scenario& now) {
  Scenario then = before;
  then.run = now.run;
  if (then == now) return std::nullopt;
  if (then.bodies.size() != now.bodies.size())
    return fmt::format("{} bodies where the run has {}", now.bodies.size(), then.bodies.size());
  const auto a = parameters(then);
  const auto b = parameters(now);
  for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n) {
    if (a[n].first != b[n].first)
      return fmt::format("{} where the run has {}", b[n].first, a[n].first);
    if (a[n].second != b[n].second)
      return fmt::format("{} = {} where the run has {}", b[n].first, b[n].second, a[n].second);
  }
  return fmt::format("{} keys where the run has {}", b.size(), a.size());
}

}  // namespace ductile::drivers
