// A scenario put together: its fluid, its bodies on the ranks that own them, and their coupling.
#pragma once

#include <mpi.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "bodies.hpp"
#include "ductile/coupling/coupler.hpp"
#include "ductile/fluid/fluid.hpp"
#include "scenario.hpp"
#include "units.hpp"

namespace ductile::drivers {

/// The fluid of a scenario, in its initial state. Collective.
fluid::Fluid make_fluid(const Scenario& scenario, const LatticeSetup& setup, MPI_Comm comm);

/// Body b belongs to rank b modulo the number of ranks.
class Assembly {
 public:
  /// Collective. `scenario` and `setup` must outlive it.
  Assembly(const Scenario& scenario, const LatticeSetup& setup, MPI_Comm comm);

  [[nodiscard]] fluid::Fluid& fluid() { return fluid_; }
  [[nodiscard]] const fluid::Fluid& fluid() const { return fluid_; }
  [[nodiscard]] coupling::Coupler& coupler() { return *coupler_; }
  [[nodiscard]] int owner(std::size_t body) const {
    return static_cast<int>(body % static_cast<std::size_t>(ranks_));
  }
  /// The body if this rank owns it, else null.
  [[nodiscard]] const ImmersedBody* own(std::size_t body) const;

 private:
  int ranks_ = 1;
  fluid::Fluid fluid_;
  struct Owned {
    std::size_t index;
    std::unique_ptr<ImmersedBody> body;
  };
  std::vector<Owned> bodies_;
  std::optional<coupling::Coupler> coupler_;
};

}  // namespace ductile::drivers
