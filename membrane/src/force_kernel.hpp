// The loops over a shell's triangles and edges that give its force, for each instruction set.
#pragma once

#include <cstddef>

#include "ductile/instruction_set.hpp"

namespace ductile::membrane {

/// Four numbers of a vertex or of a triangle: x y z and one more.
struct alignas(32) Four {
  double of[4];
};

/// The reference state of a shell, an array for each number. Arrays are filled up to a multiple of
/// four triangles or edges with copies of the last.
struct ForceElements {
  std::size_t triangles;
  const int* vertex[3];
  const int* edge[3];  ///< that faces each vertex; a rim's has a moment that stays 0
  const double* a11;   ///< the inverse of the metric, 1/det G and the area
  const double* a12;
  const double* a22;
  const double* inverse_det;
  const double* area;

  std::size_t edges;
  const int* left;  ///< the triangle on either side
  const int* right;
  const int* tail;  ///< vertices
  const int* head;
  const double* cos0;
  const double* sin0;
};

/// W1 and W2 of the strain energy density, as strain_density() in shell_math.hpp has them, are
///   (k_s (I1 + 1), k_a I2 - k_s)/6 by Skalak's law, (k_s, -k_s/(I2 + 1)^2)/6 of a neo-Hookean
///   shell.
struct ForceModuli {
  bool skalak;
  double k_s;
  double k_a;
  double bending;  ///< sqrt(3) k_b
};

/// The same bits with each instruction set. Positions and forces are of each vertex, the fourth
/// number any; `normal` is e1 x e2 of each triangle and 1/|e1 x e2|.
struct ForceKernel {
  /// normal <- those at the positions, up to a multiple of four; returns six times the volume that
  /// they enclose, from the first vertex.
  double (*normals)(const ForceElements& elements, const Four* position, Four* normal);
  /// moment <- (dE/dtheta)/l of each edge, up to a multiple of four.
  void (*moments)(const ForceElements& elements, double bending, const Four* position,
                  const Four* normal, double* moment);
  /// Adds -dE/dx of strain, bending and the pressure p = dE_v/dV to the force.
  void (*forces)(const ForceElements& elements, const ForceModuli& moduli, double pressure,
                 const Four* position, const Four* normal, const double* moment, Four* force);
};

/// force_kernel.cpp, compiled once for each of them.
namespace baseline {
const ForceKernel& force_kernel();
}
namespace avx2 {
const ForceKernel& force_kernel();
}
namespace avx512 {
const ForceKernel& force_kernel();
}

/// `set` must be available.
const ForceKernel& force_kernel(InstructionSet set);

}  // namespace ductile::membrane
