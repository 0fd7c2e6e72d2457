// A scenario run by a test: the program's own set-up, without its files.
#pragma once

#include <string>

#include "assembly.hpp"
#include "scenario.hpp"
#include "units.hpp"

namespace ductile::test {

/// On one rank.
class Channel {
 public:
  explicit Channel(const std::string& toml)
      : scenario_(drivers::parse_scenario(toml, "test.toml")),
        setup_(drivers::lattice_setup(scenario_)),
        assembly_(scenario_, setup_, MPI_COMM_SELF) {}

  /// Runs until `time`, in W^2/nu. Throws coupling::BodyFailure.
  void run(double time) {
    while (assembly_.fluid().time() < setup_.steps(time)) assembly_.coupler().step();
  }
  [[nodiscard]] drivers::BodySample sample(std::size_t body) const {
    return assembly_.own(body)->sample();
  }
  /// [nu/W]
  [[nodiscard]] double largest_velocity() const {
    return setup_.velocity(Eigen::Vector3d(0, 0, setup_.u_max)).z();
  }

 private:
  drivers::Scenario scenario_;
  drivers::LatticeSetup setup_;
  drivers::Assembly assembly_;
};

}  // namespace ductile::test
