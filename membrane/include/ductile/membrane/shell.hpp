// What the membrane's force is: energies, forces and their tangent from positions. How time
// advances is elsewhere (integrator.hpp).
#pragma once

#include <petscmat.h>
#include <petscvec.h>

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "ductile/instruction_set.hpp"
#include "ductile/membrane/petsc.hpp"
#include "ductile/surface/mesh.hpp"

namespace ductile::membrane {

class Force;

/// In-plane strain energy density W(I1, I2), I1 = l1^2 + l2^2 - 2, I2 = (l1 l2)^2 - 1, with l1 and
/// l2 the principal stretches; eqs. (8) and (9).
enum class StrainLaw {
  skalak,      ///< W = (k_s/12)(I1^2 + 2 I1 - 2 I2) + (k_a/12) I2^2, eq. (7); G_s = k_s/3
  neo_hookean  ///< W = (k_s/6)(I1 - 1 + 1/(I2 + 1)); G_s = k_s/3, k_a unused
};

/// Elastic moduli, lattice units.
struct Moduli {
  StrainLaw law = StrainLaw::skalak;
  double k_s = 0;  ///< shear modulus, force/length; the small-strain shear modulus is k_s/3
  double k_a = 0;  ///< area dilation modulus, force/length
  double k_b = 0;  ///< bending modulus, energy; eq. (10) literally: Helfrich's kappa is 1.5 k_b
  double k_v = 0;  ///< volume modulus, pressure
};

struct ShellOptions {
  /// theta0 = 0 for every edge (a membrane that is flat at rest) in place of the mesh's angles.
  bool flat_reference_angles = false;
  /// The mesh is a sheet with a rim, whose edges do not bend. It encloses nothing: k_v must be 0.
  bool open_sheet = false;
  /// Whose vectors force() computes with; it must be available. The same bits with each.
  InstructionSet instruction_set = best_instruction_set();
};

/// Energies of a shell, eqs. (7), (10) and (11).
struct Energies {
  double strain = 0;
  double bending = 0;
  double volume = 0;
  [[nodiscard]] double total() const { return strain + bending + volume; }
};

/// Area, volume, and volume centroid of a shell; `inertia` is the integral of x x^T over the
/// enclosed volume about that centroid (its eigenvalues give the equivalent ellipsoid's axes).
struct Shape {
  double area = 0;
  double volume = 0;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  /// Semi-axes of the ellipsoid with the same inertia, longest first.
  [[nodiscard]] Eigen::Vector3d semi_axes() const;
  /// Direction of that ellipsoid's shortest axis, either way: of length 1. None, 0, where two are
  /// the shortest: in their second moments equal within 1e-9.
  [[nodiscard]] Eigen::Vector3d shortest_axis() const;
  /// Taylor's deformation (L - B)/(L + B) of that ellipsoid, L its longest, B its shortest axis.
  [[nodiscard]] double taylor_deformation() const;
};

/// An elastic shell of P1 finite elements, unstressed in its reference mesh: its reference metric,
/// angles theta0 and volume V0 are those of the mesh as given. Positions and forces are sequential
/// PETSc vectors of 3n numbers, interlaced, block size 3. Its physics never changes; its calls,
/// and those of its copies, share work space, so one thread at a time. No call is collective beyond
/// PETSC_COMM_SELF. Sums run in the order of the mesh's triangles and are the same, to the last
/// bit, whenever repeated.
class Shell {
 public:
  /// Throws std::invalid_argument for a negative modulus, a mesh that is not closed (unless
  /// `open_sheet`) or not consistently oriented or inside out, or a degenerate triangle, naming it.
  Shell(const surface::Mesh& reference, const Moduli& moduli, const ShellOptions& options = {});

  [[nodiscard]] int vertex_count() const { return vertex_count_; }
  [[nodiscard]] const Moduli& moduli() const { return moduli_; }
  [[nodiscard]] const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }
  [[nodiscard]] double reference_volume() const { return reference_volume_; }
  /// Reference area of each vertex.
  [[nodiscard]] const std::vector<double>& vertex_areas() const { return vertex_areas_; }

  /// A new vector of the right size for positions, velocities or forces, all zero.
  [[nodiscard]] VecPtr create_vec() const { return membrane::create_vec(vertex_count_); }

  /// As the next two, throws std::invalid_argument if a vector is not of this shell's size.
  [[nodiscard]] Energies energies(Vec positions) const;
  /// force <- -dE/dx, the force that the membrane exerts on the fluid. (The paper's F = +dE/dx
  /// with the minus of its eq. (16) is the same.) Not finite where a triangle has collapsed.
  void force(Vec positions, Vec force) const;

  /// A new matrix for tangent(), all zero: MATSEQBAIJ of block size 3, both triangles, marked as
  /// symmetric. A vertex couples with itself, its neighbours, and the vertices that face it across
  /// an edge.
  [[nodiscard]] MatPtr create_tangent() const;
  /// tangent <- the Hessian d2E/dx2 = -dF/dx, less the volume energy's dense part, which
  /// volume_stiffness() gives: exact, symmetric to the last bit, indefinite where the membrane is
  /// compressed. Throws std::invalid_argument if `tangent` is not one that create_tangent() made.
  void tangent(Vec positions, Mat tangent) const;
  /// gradient <- g = dV/dx; returns c = k_v/V0, so that the whole Hessian is tangent + c g g^T. Of
  /// an open sheet both are zero.
  double volume_stiffness(Vec positions, Vec gradient) const;

  /// Only the area means anything for an open sheet.
  [[nodiscard]] Shape shape(Vec positions) const;
  /// 3n numbers; throws std::invalid_argument for another count.
  [[nodiscard]] Shape shape(std::span<const double> positions) const;

 private:
  // Reference state of a triangle with edges E1, E2 from its first vertex: the inverse a of the
  // metric G_ij = E_i . E_j, 1/det G, and the area.
  struct Element {
    double a11, a12, a22;
    double inverse_det;
    double area;
    std::array<int, 3> hinges;  // facing each vertex; a rim's edge has the number hinges_.size()
  };
  // Edge between two triangles: it runs from `tail` to `head` in the left one.
  struct Hinge {
    int left, right;
    int tail, head;
    double cos0, sin0;  // of theta0
  };
  struct Angle {
    double cos, sin;
    double inverse_length;  // of the edge
  };
  // Where blocks go in the tangent (shell_tangent.cpp).
  struct TangentPattern;

  void build_elements(const surface::Mesh& reference);
  void build_hinges(const ShellOptions& options);
  void make_force(InstructionSet set);
  // Fills normals_ and inverse_norms_; returns the enclosed volume.
  double update_normals(const double* x) const;
  // k_v (V - V0)/V0, or 0.
  double pressure(double volume) const;
  const TangentPattern& tangent_pattern() const;
  void add_hinge_tangents(const double* x, double p) const;
  void add_triangle_tangents(const double* x) const;
  void spread_tangent(double* values) const;
  // Signed, positive where the surface is convex; from the latest normals.
  Angle angle(const Hinge& hinge, const double* x) const;

  int vertex_count_;
  Moduli moduli_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<Element> elements_;
  std::vector<Hinge> hinges_;
  std::vector<double> vertex_areas_;
  double reference_volume_ = 0;
  bool open_sheet_;
  mutable std::shared_ptr<const TangentPattern> tangent_pattern_;  // made when first needed

  std::shared_ptr<Force> force_;
  // Work space: the normal e1 x e2 of each triangle and 1/|e1 x e2|; dE/dtheta over its length for
  // each edge, and a last one, 0, for a sheet's rim.
  mutable std::vector<Eigen::Vector3d> normals_;
  mutable std::vector<double> inverse_norms_;
  mutable std::vector<double> moments_;
  // Three columns of four; see shell_tangent.cpp.
  struct alignas(32) Block {
    double values[12];
  };
  mutable std::vector<Block> pair_blocks_;
};

}  // namespace ductile::membrane
