// Films between the rigid spheres of a suspension.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "ductile/rigid/lubrication.hpp"
#include "ductile/suspension/plan.hpp"

namespace ductile::suspension {

/// Those with slip, for which rigid::Lubrication holds, all of them known to every rank.
class Films {
 public:
  /// Null if there are fewer than two such spheres.
  static std::unique_ptr<Films> make(const Plan& plan);

  /// Indices of the spheres among the plan's bodies.
  [[nodiscard]] const std::vector<std::size_t>& bodies() const { return bodies_; }
  [[nodiscard]] rigid::Lubrication& lubrication() { return lubrication_; }

 private:
  Films(std::vector<std::size_t> bodies, rigid::Lubrication lubrication);

  std::vector<std::size_t> bodies_;
  rigid::Lubrication lubrication_;
};

}  // namespace ductile::suspension
