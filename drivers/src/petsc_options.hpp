// The scenario's [petsc]: options for the solvers.
#pragma once

#include "scenario.hpp"

namespace ductile::drivers {

/// Gives PETSc the scenario's options on this rank, for all solvers made from now on. Throws
/// membrane::PetscFailure.
void set_petsc_options(const Scenario& scenario);

/// Sets the options and lets each integrator of the scenario take a step with a small capsule in a
/// still fluid, so that an option that PETSc does not understand is the user's to mend before a
/// run. Does nothing without options. Throws InputError.
void try_petsc_options(const Scenario& scenario);

}  // namespace ductile::drivers
