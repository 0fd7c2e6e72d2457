// A scenario run by a test: the program's own set-up, without its files.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bodies.hpp"
#include "ductile/coupling/coupler.hpp"
#include "scenario.hpp"
#include "simulation.hpp"
#include "units.hpp"

namespace ductile::test {

/// On one rank.
class Channel {
 public:
  explicit Channel(const std::string& toml)
      : scenario_(drivers::parse_scenario(toml, "test.toml")),
        setup_(drivers::lattice_setup(scenario_)),
        fluid_(drivers::make_fluid(scenario_, setup_, MPI_COMM_SELF)) {
    std::vector<coupling::Member> members;
    for (std::size_t b = 0; b < scenario_.bodies.size(); ++b) {
      bodies_.push_back(drivers::make_body(scenario_, setup_, b));
      members.push_back({static_cast<int>(b), &bodies_.back()->markers()});
    }
    coupler_ =
        std::make_unique<coupling::Coupler>(fluid_, members, static_cast<int>(members.size()));
  }

  /// Runs until `time`, in W^2/nu. Throws coupling::BodyFailure.
  void run(double time) {
    while (fluid_.time() < setup_.steps(time)) coupler_->step();
  }
  [[nodiscard]] drivers::BodySample sample(std::size_t body) const {
    return bodies_.at(body)->sample();
  }
  /// [nu/W]
  [[nodiscard]] double largest_velocity() const {
    return setup_.velocity(Eigen::Vector3d(0, 0, setup_.u_max)).z();
  }

 private:
  drivers::Scenario scenario_;
  drivers::LatticeSetup setup_;
  fluid::Fluid fluid_;
  std::vector<std::unique_ptr<drivers::ImmersedBody>> bodies_;
  std::unique_ptr<coupling::Coupler> coupler_;
};

}  // namespace ductile::test
