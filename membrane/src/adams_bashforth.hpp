// The second-order explicit scheme.
#pragma once

#include "ductile/membrane/integrator.hpp"

namespace ductile::membrane {

/// F = -dE/dx(x^n), w^n = u + eps F, v = (3 w^n - w^(n-1))/2; the first step is one of explicit
/// Euler. Second order where the fluid's velocity at t is: the markers' is then extrapolated to the
/// middle of the step. No corrections.
class AdamsBashforth final : public Integrator {
 public:
  AdamsBashforth(const Shell& shell, Vec mobility)
      : shell_(shell),
        mobility_(mobility),
        rate_(shell.create_vec()),
        before_(shell.create_vec()) {}

  static SchemeTraits traits() { return {.weights = {1.5, -0.5}, .cost = 1.05}; }

  void predict_force(const State& state, Vec force) override;
  void advance(const State& state, Vec fluid_velocity, Vec velocity) override;
  void accept() override;
  void save(const StateWriter& write) const override;
  void load(const StateReader& read) override;

 private:
  template <class Self, class Io>
  static void transfer_parts(Self& self, const Io& io);

  const Shell& shell_;
  Vec mobility_;
  VecPtr rate_, before_;  // w^n and w^(n-1)
  bool started_ = false;
};

}  // namespace ductile::membrane
