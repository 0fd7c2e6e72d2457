#include "assembly.hpp"

#include <utility>

#include "simulation.hpp"

namespace ductile::drivers {

Assembly::Assembly(const Scenario& scenario, const LatticeSetup& setup, MPI_Comm comm)
    : fluid_(make_fluid(scenario, setup, comm)) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks_);
  std::vector<coupling::Member> members;
  for (std::size_t b = 0; b < scenario.bodies.size(); ++b) {
    if (owner(b) != rank) continue;
    bodies_.push_back({b, make_body(scenario, setup, b)});
    members.push_back({static_cast<int>(b), &bodies_.back().body->markers()});
  }
  coupler_.emplace(fluid_, std::move(members), static_cast<int>(scenario.bodies.size()));
}

const ImmersedBody* Assembly::own(std::size_t body) const {
  for (const Owned& owned : bodies_) {
    if (owned.index == body) return owned.body.get();
  }
  return nullptr;
}

}  // namespace ductile::drivers
