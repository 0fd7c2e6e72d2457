// The force of a shell, four triangles at a time.
#pragma once

#include <span>
#include <vector>

#include "ductile/instruction_set.hpp"
#include "force_kernel.hpp"

namespace ductile::membrane {

/// What Shell::force() computes with: a shell's reference state as the kernel wants it, and its
/// work space.
class Force {
 public:
  struct Triangle {
    int vertex[3];
    int edge[3];  ///< that faces each vertex; a rim's edge has the number of edges
    double a11, a12, a22, inverse_det, area;
  };
  struct Edge {
    int left, right, tail, head;
    double cos0, sin0;
  };
  Force(std::span<const Triangle> triangles, std::span<const Edge> edges, int vertices,
        InstructionSet set);

  /// From the positions, 3n numbers; returns the volume that the shell encloses.
  double start(const double* positions);
  /// force <- -dE/dx at the positions of start(), 3n numbers, under the pressure dE_v/dV.
  void finish(const ForceModuli& moduli, double pressure, double* force);

 private:
  [[nodiscard]] ForceElements elements() const;

  const ForceKernel* kernel_;
  std::size_t triangles_;
  std::size_t edges_;
  std::vector<int> vertex_[3];
  std::vector<int> edge_[3];
  std::vector<double> a11_, a12_, a22_, inverse_det_, area_;
  std::vector<int> left_, right_, tail_, head_;
  std::vector<double> cos0_, sin0_;
  std::vector<Four> position_, normal_, force_;
  std::vector<double> moment_;  // that of a rim's edge, 0, after the edges'
};

}  // namespace ductile::membrane
