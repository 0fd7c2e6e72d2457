// What implicit schemes share: all but how they solve the equation of a substep.
#pragma once

#include "ductile/membrane/integrator.hpp"
#include "step_equation.hpp"

namespace ductile::membrane {

/// The scheme solves for the force of the step (see StepEquation) in each of two corrections: first
/// against the forces that other bodies are expected to exert, then against those that they have
/// found. The second solve also takes in what the response has missed of the fluid's density.
/// Capsules whose kernels overlap iterate on each other in this way (block Jacobi). The error of
/// that iteration changes sign with each round: stiff capsules were stable down to the smallest gap
/// with two rounds, but not with one or three. The second solve has nothing left to do far from
/// others.
///
/// `substeps` divide the step in that equation, and the fluid receives the mean of their forces.
/// The membrane then moves with the fluid's own velocity at theta = 1/2, for any number of them.
/// The solve starts from the force extrapolated from the two steps before. That is also what
/// predict_force() gives, so that other bodies feel it within the step.
class ImplicitStep : public Integrator {
 public:
  /// Throws std::invalid_argument for options out of bounds.
  ImplicitStep(const Shell& shell, Vec mobility, const IntegratorOptions& options);

  [[nodiscard]] int corrections() const override { return 2; }
  void predict_force(const State& state, Vec force) override;
  /// Throws SolveFailure.
  void correct_force(const State& state, Vec fluid_velocity, const Response& response,
                     Vec increment) override;
  void advance(const State& state, Vec fluid_velocity, Vec velocity) override;
  void accept() override;
  [[nodiscard]] SolveStatistics statistics() const override { return statistics_; }
  void save(const StateWriter& write) const override;
  void load(const StateReader& read) override;

 protected:
  /// unknown <- y of the substep that the equation has begun, from the guess in it; counts into
  /// statistics(). Throws SolveFailure.
  virtual void solve(Vec unknown) = 0;

  /// The defaults of a linear solver for the equation's operator; options come after.
  static void set_up(KSP ksp);
  /// |F| below which nothing can be told: round-off in the force is some 1e-14 k_s, and a capsule
  /// at rest has no force to be relative to.
  static double round_off(const Shell& shell);
  StepEquation& equation() { return equation_; }
  SolveStatistics& count() { return statistics_; }
  /// |F| of an unknown y, over all forces.
  double force_norm(Vec unknown);

  /// The tangent is kept until it is `lag` steps old, or somebody asks for a new one.
  [[nodiscard]] bool tangent_is_due() const { return stale_; }
  void renew_tangent() { stale_ = true; }
  void linearise(Vec unknown);

 private:
  void step(const State& state, const Response& response, int substeps);
  template <class Self, class Io>
  static void transfer_parts(Self& self, const Io& io);

  Vec mobility_;
  StepEquation equation_;
  int substeps_;
  int step_cuts_;
  PetscInt lag_ = 20;
  bool lumped_ = false;
  bool stale_ = true;
  PetscInt age_ = 0;  // steps since the tangent was assembled
  SolveStatistics statistics_;

  VecPtr last_, before_;  // F of the two steps before
  int steps_ = 0;         // of which so many are there
  VecPtr drift_;          // the fluid's velocity without the capsule's own force
  VecPtr unknown_;
  VecPtr start_;  // positions, of a substep
  VecPtr force_;  // of a substep; then of the step
  VecPtr mean_;
  VecPtr slip_;  // (2 theta - 1) R F
};

}  // namespace ductile::membrane
