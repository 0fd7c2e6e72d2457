#include "adams_bashforth.hpp"

#include <utility>

#include "state.hpp"

namespace ductile::membrane {

void AdamsBashforth::predict_force(const State& state, Vec force) {
  shell_.force(state.positions.get(), force);
}

void AdamsBashforth::advance(const State& state, Vec fluid_velocity, Vec velocity) {
  petsc_check(VecPointwiseMult(rate_.get(), mobility_, state.forces.get()));
  petsc_check(VecAXPY(rate_.get(), 1.0, fluid_velocity));
  petsc_check(VecCopy(rate_.get(), velocity));
  if (started_) petsc_check(VecAXPBY(velocity, -0.5, 1.5, before_.get()));
}

void AdamsBashforth::accept() {
  std::swap(rate_, before_);
  started_ = true;
}

template <class Self, class Io>
void AdamsBashforth::transfer_parts(Self& self, const Io& io) {
  transfer(io, "before", self.before_);
  transfer(io, "started", self.started_);
}
void AdamsBashforth::save(const StateWriter& write) const {
  transfer_parts(*this, write);
}
void AdamsBashforth::load(const StateReader& read) {
  transfer_parts(*this, read);
}

}  // namespace ductile::membrane
