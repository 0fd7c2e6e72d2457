// A suspension: fluid and bodies, coupled, each body on the rank that owns it. This is what the
// program's loop steps, and what a driver of one's own links:
//
//     suspension::Suspension suspension(plan, MPI_COMM_WORLD);
//     while (suspension.time() < 10) suspension.step();
//     const suspension::Sample end = suspension.sample();   // on rank 0
//
// It reads and writes no file, prints nothing, and leaves signals and global state alone. MPI and
// PETSc must be up.
#pragma once

#include <mpi.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "ductile/coupling/coupler.hpp"
#include "ductile/fluid/fluid.hpp"
#include "ductile/fluid/mpi.hpp"
#include "ductile/suspension/body.hpp"
#include "ductile/suspension/gaps.hpp"
#include "ductile/suspension/plan.hpp"
#include "ductile/suspension/sample.hpp"

namespace ductile::suspension {

class Films;
class GapFinder;

/// A body's surface at one instant: 3n numbers each, x y z of every vertex of BodyPlan::mesh().
struct SurfaceState {
  std::vector<double> position;  ///< [W]; z not wrapped
  std::vector<double> velocity;  ///< [nu/W]
  std::vector<double> force;     ///< on the fluid [rho nu^2]; empty of a rigid body
};

/// The whole fluid at one instant: node (i, j, k) at [(i ny + j) nz + k]. Velocities are in the
/// frame at rest.
struct FluidState {
  double way = 0;                ///< of the lattice along z since the start [W]
  std::vector<double> density;   ///< [rho]
  std::vector<double> velocity;  ///< [nu/W]; three such arrays, one a component
};

/// Every member but the plain getters is collective.
class Suspension {
 public:
  /// Keeps a copy of the plan. Throws std::invalid_argument on every rank: for a plan that
  /// contradicts itself (Plan::check), as fluid::Fluid, and with the body's name for whatever keeps
  /// its owner from making it; fluid::MpiFailure.
  Suspension(Plan plan, MPI_Comm comm);
  ~Suspension();
  Suspension(const Suspension&) = delete;
  Suspension& operator=(const Suspension&) = delete;

  [[nodiscard]] const Plan& plan() const { return plan_; }
  /// Its own, which returns errors instead of aborting: for fluid::mpi_check.
  [[nodiscard]] MPI_Comm comm() const { return comm_.get(); }
  [[nodiscard]] int rank() const { return comm_.rank(); }
  [[nodiscard]] int ranks() const { return comm_.size(); }
  /// As owners() has it.
  [[nodiscard]] int owner(std::size_t body) const { return owners_[body]; }
  /// The body if this rank owns it, else null.
  [[nodiscard]] const Body* own(std::size_t body) const;

  /// One time step of fluid and bodies, coupling/body.hpp. Throws coupling::BodyFailure.
  void step();
  [[nodiscard]] std::int64_t steps() const { return fluid_.time(); }
  /// [W^2/nu]
  [[nodiscard]] double time() const { return plan_.units.time(steps()); }
  /// fluid::Fluid::finite()
  [[nodiscard]] bool finite() { return fluid_.finite(); }

  /// What follows is on rank 0 alone; other ranks get empty lists.
  [[nodiscard]] Sample sample();
  [[nodiscard]] std::vector<membrane::SolveStatistics> solvers() const;
  [[nodiscard]] std::vector<SurfaceState> surfaces() const;
  [[nodiscard]] FluidState fields();
  /// All gaps smaller than `reach` lattice spacings, as the bodies are now: of each with the walls,
  /// with the others (their nearest images) and with its own images.
  [[nodiscard]] std::vector<Gap> gaps(double reach);

  /// Where this rank's time has gone.
  [[nodiscard]] const coupling::Profile& profile() const { return coupler_->profile(); }
  void reset_profile() { coupler_->reset_profile(); }

  /// Calls rank 0's `write` with a name and numbers for all that determines the future: of the
  /// fluid "fluid/time", "fluid/lattice" and populations of the whole lattice (see
  /// fluid::Fluid::save), of every body "body/NAME/...", and "films/..." if there are any. The same
  /// to the last bit on any number of ranks. Between steps only. What `write` throws passes through
  /// there, the other ranks throw std::runtime_error.
  void save(const StateWriter& write);
  /// Takes over what a suspension of the same plan has saved, on any number of ranks; what follows
  /// is the same to the last bit as there. Rank 0's `read` fills the numbers of a name. What it
  /// throws passes through there, the other ranks throw std::runtime_error; the suspension is then
  /// good for nothing but another load().
  void load(const StateReader& read);

 private:
  void make_bodies();
  void lubricate();
  void steer();

  struct Owned {
    std::size_t index;
    std::unique_ptr<Body> body;
  };

  Plan plan_;
  fluid::Communicator comm_;
  std::vector<int> owners_;
  fluid::Fluid fluid_;
  std::unique_ptr<Films> films_;  // none if there are not two spheres that have them
  std::vector<Owned> bodies_;
  std::optional<coupling::Coupler> coupler_;
  std::unique_ptr<GapFinder> gap_finder_;  // rank 0's, once asked for
};

}  // namespace ductile::suspension
