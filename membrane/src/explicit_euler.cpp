#include "explicit_euler.hpp"

namespace ductile::membrane {

void ExplicitEuler::predict_force(const State& state, Vec force) {
  shell_.force(state.positions.get(), force);
}

void ExplicitEuler::advance(const State& state, Vec fluid_velocity, Vec velocity) {
  petsc_check(VecPointwiseMult(velocity, mobility_, state.forces.get()));
  petsc_check(VecAXPY(velocity, 1.0, fluid_velocity));
}

}  // namespace ductile::membrane
