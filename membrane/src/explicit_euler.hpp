// The paper's scheme: the force of the positions at t, and a step with the fluid.
#pragma once

#include "ductile/membrane/integrator.hpp"

namespace ductile::membrane {

/// F = -dE/dx(x^n), v = u + eps F; first order, no corrections.
class ExplicitEuler final : public Integrator {
 public:
  ExplicitEuler(const Shell& shell, Vec mobility) : shell_(shell), mobility_(mobility) {}

  static SchemeTraits traits() { return {.weights = {1}, .cost = 1}; }

  void predict_force(const State& state, Vec force) override;
  void advance(const State& state, Vec fluid_velocity, Vec velocity) override;

 private:
  const Shell& shell_;
  Vec mobility_;
};

}  // namespace ductile::membrane
