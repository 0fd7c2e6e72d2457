// The worked example of doc/integrators.md, "Write your own": copy this file beside
// explicit_euler.hpp.
#pragma once

#include "ductile/membrane/integrator.hpp"

namespace ductile::membrane {

/// Explicit Euler that looks once where it is going: the fluid receives the mean of the forces at
/// the positions before the step and at those that the first of them leads to (Heun's method). One
/// correction; second order in a fluid that answers at once; no system to solve.
class Heun final : public Integrator {
 public:
  Heun(const Shell& shell, Vec mobility)
      : shell_(shell), mobility_(mobility), reached_(shell.create_vec()) {}

  // Measured, see doc/integrators.md.
  static SchemeTraits traits() { return {.reach = 0.85, .cost = 2}; }

  [[nodiscard]] int corrections() const override { return 1; }

  void predict_force(const State& state, Vec force) override {
    shell_.force(state.positions.get(), force);
  }

  void correct_force(const State& state, Vec fluid_velocity, const Response& /*response*/,
                     Vec increment) override {
    // x^n + u + eps F, u being the fluid's velocity with F in.
    advance(state, fluid_velocity, reached_.get());
    petsc_check(VecAXPY(reached_.get(), 1, state.positions.get()));
    shell_.force(reached_.get(), increment);
    petsc_check(VecAXPBY(increment, -0.5, 0.5, state.forces.get()));
  }

  void advance(const State& state, Vec fluid_velocity, Vec velocity) override {
    petsc_check(VecPointwiseMult(velocity, mobility_, state.forces.get()));
    petsc_check(VecAXPY(velocity, 1, fluid_velocity));
  }

 private:
  const Shell& shell_;
  Vec mobility_;
  VecPtr reached_;
};

}  // namespace ductile::membrane
