// Where a fluid feels a surface whose markers push it through Peskin's kernel, by theory
// (doc/equations.md, "Where a surface is felt"). All lengths in lattice spacings.
#pragma once

#include "ductile/fluid/fluid.hpp"
#include "ductile/membrane/shell.hpp"
#include "ductile/surface/shape.hpp"

namespace ductile::suspension {

/// The collision's magic parameter, (tau - 1/2)(tau_odd - 1/2), (tau - 1/2)^2 of bgk.
double magic_of(const fluid::Options& fluid);

/// How far inside of a shape's surface markers that stand for it must lie. A sphere held in a
/// straining Stokes flow then has the stresslet (20/3) pi eta a^3 E of one of radius a: about 0.408
/// + 1.43/a at tau = 1, for a below 3 that of 3, at most 1 and a/2. Any other shape: 0.408, the
/// limit of flat surfaces, as its curvature varies; or less, so that two sheets of it stay apart.
/// Either grows by 0.4 (1/4 - magic), which is measured. A slip as of FeltPlace leaves less to do.
double felt_retraction(const surface::Shape& shape, const fluid::Options& fluid, double slip = 0);

/// Where the markers of a rigid body lie, and how far the fluid slips along them.
struct FeltPlace {
  double retraction = 0;  ///< how far inside of the surface
  double slip = 0;        ///< velocity per force per area, both along the surface, in dx/eta
};
/// A sphere held in a Stokes flow then has the stresslet and the octupole that it should have at
/// any radius from 3 on, and others within 1 to 2%: without slip the octupole is 8% too large at a
/// = 4.8. Any other shape: felt_retraction(), without slip. By the magic parameter as
/// felt_retraction().
FeltPlace felt_place(const surface::Shape& shape, const fluid::Options& fluid);

/// What to multiply the moduli of a sphere's membrane with, `retraction` inside of its surface, so
/// that the surface deforms in a weak shear flow as theory says of a membrane on it. The kernel
/// takes from the fluid's answer to tangential forces, so that the force that holds a membrane in
/// shape is to a lesser part pressure and to a larger part tangential. 1 without retraction, of
/// no stiffness, and of any shape that is no sphere. `moduli` tell the law and k_a/k_s.
double felt_modulus_factor(const surface::Shape& shape, double retraction,
                           const membrane::Moduli& moduli, const fluid::Options& fluid);

}  // namespace ductile::suspension
