// Gaps as the bodies are now.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "ductile/suspension/gaps.hpp"
#include "ductile/suspension/plan.hpp"

namespace ductile::suspension {

class GapFinder {
 public:
  /// Keeps a reference to the plan, and the triangles of its bodies' meshes.
  explicit GapFinder(const Plan& plan);

  /// All gaps smaller than `reach` lattice spacings: of bodies with walls, with other bodies and
  /// their periodic images, and with their own images. `positions`:
  /// Body::inner_positions() of every body.
  [[nodiscard]] std::vector<Gap> below(double reach,
                                       const std::vector<std::vector<double>>& positions) const;

 private:
  // How far the surfaces of two bodies lie outside of their markers, together.
  [[nodiscard]] double outside(std::size_t a, std::size_t b) const {
    return plan_.bodies[a].retraction() + plan_.bodies[b].retraction();
  }

  using Triangles = std::vector<std::array<int, 3>>;
  struct Surface;

  void add_walls(const Surface& body, double reach, std::vector<Gap>& gaps) const;
  void add_bodies(const Surface& a, const Surface& b, double reach, std::vector<Gap>& gaps) const;

  const Plan& plan_;
  std::vector<std::shared_ptr<const Triangles>> triangles_;  // shared by meshes of one frequency
};

}  // namespace ductile::suspension
