// A scenario: what a run computes, in the paper's non-dimensional units. Lengths are in W, the
// channel's half-width along x, times in W^2/nu, velocities in nu/W, densities in rho.
//
// The keys of the TOML file are the members below, by the same names; keys.cpp holds their bounds,
// units and descriptions.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "ductile/fluid/fluid.hpp"
#include "ductile/membrane/shell.hpp"
#include "ductile/suspension/plan.hpp"

namespace ductile::drivers {

enum class Symmetry { none, y };
enum class BodyKind { capsule, rigid };
/// What the fluid's lattice moves with along z.
enum class LatticeFrame { walls, bodies };

/// Nodes that a channel may have across.
constexpr int most_nodes = 4096;

/// [channel]: |x| < 1, |y| < half_width_y, periodic along z.
struct ChannelOptions {
  int nodes = 36;
  fluid::Boundary walls = fluid::Boundary::halfway;
  bool side_walls = true;
  Symmetry symmetry = Symmetry::none;
  double half_width_y = 1;
  double length = 12;
  double reynolds = 10;
  std::array<double, 2> wall_velocity{0, 0};
  std::array<double, 3> gravity{0, 0, 0};
  suspension::Start start = suspension::Start::developed;
  bool operator==(const ChannelOptions&) const = default;
};

/// [fluid]
struct FluidOptions {
  double tau = 1;
  fluid::Collision collision = fluid::Collision::bgk;
  double magic = 3.0 / 16.0;
  /// Unless told, compressible where bodies move on the lattice (keys.cpp).
  fluid::Equilibrium equilibrium = fluid::Equilibrium::incompressible;
  LatticeFrame frame = LatticeFrame::bodies;
  fluid::Precision storage = fluid::Precision::single_precision;     ///< doc/precision.md
  fluid::Precision arithmetic = fluid::Precision::single_precision;  ///< unless told, the storage's
  bool operator==(const FluidOptions&) const = default;
};

/// [membrane]: of every capsule that does not say otherwise.
struct MembraneOptions {
  membrane::StrainLaw law = membrane::StrainLaw::skalak;
  double area_ratio = 2;
  double bending = 2.87e-3;
  double volume_modulus = 75000;
  double mobility = 1e-3;
  /// Nothing is "felt": what default_retraction() says. A body's has a value once it is read.
  std::optional<double> retraction;
  std::string integrator = "explicit-euler";
  double theta = 0.5;
  int substeps = 1;
  int step_cuts = 0;
  double edge = 1.2;
  int frequency = 0;
  bool operator==(const MembraneOptions&) const = default;
};

/// [rigid]: of every rigid body that does not say otherwise.
struct RigidOptions {
  int iterations = 5;
  double memory = 0;
  std::optional<double> retraction;  ///< as a membrane's
  std::optional<double> slip;        ///< alike
  double roughness = rigid::usual_roughness;
  suspension::Interior interior = suspension::Interior::fluid;
  double edge = 1.2;
  int frequency = 0;
  bool operator==(const RigidOptions&) const = default;
};

/// [[body]]. `membrane` counts for capsules, `rigid` and `density_ratio` for rigid bodies alone;
/// their keys stand directly in [[body]].
struct BodyOptions {
  std::string name;
  BodyKind kind = BodyKind::capsule;
  std::string shape = "sphere";  ///< one of surface::shape_names()
  double radius = 0.4;
  double x = 0;
  double y = 0;
  double z = 0;
  std::array<double, 3> rotation_axis{0, 1, 0};
  double rotation_angle = 0;  ///< degrees
  double laplace = 0;         ///< capsules; required in the file
  double density_ratio = 1;   ///< rigid bodies
  MembraneOptions membrane;
  RigidOptions rigid;
  bool operator==(const BodyOptions&) const = default;
};

/// [run]: all that may be another when a run goes on.
struct RunLimits {
  double time_limit = 60;
  double stop_distance = 10;
  bool until_decided = true;
  bool stop_at_contact = true;
  double checkpoint_every = 10;  ///< minutes; 0: none before the end
  double patience = 10;          ///< minutes; 0: endless
  bool operator==(const RunLimits&) const = default;
};

/// [output]: sampling intervals, in W^2/nu; 0 is off.
struct OutputOptions {
  double every = 0.05;
  double surfaces_every = 0.5;
  double field_every = 0;
  bool operator==(const OutputOptions&) const = default;
};

/// An entry of [petsc]: an option of PETSc without its dash, and its value as PETSc reads it; empty
/// for one that takes none.
struct PetscOption {
  std::string name;
  std::string value;
  bool operator==(const PetscOption&) const = default;
};

struct Scenario {
  std::string name;
  ChannelOptions channel;
  FluidOptions fluid;
  MembraneOptions membrane;
  RigidOptions rigid;
  std::vector<BodyOptions> bodies;
  RunLimits run;
  OutputOptions output;
  std::vector<PetscOption> petsc;  ///< in the order of their names
  bool operator==(const Scenario&) const = default;
};

}  // namespace ductile::drivers
