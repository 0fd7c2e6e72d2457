// A scenario run by a test: the program's own set-up, without its files.
#pragma once

#include <string>

#include "checks/read_case.hpp"
#include "ductile/suspension/suspension.hpp"

namespace ductile::test {

/// On one rank.
class Channel {
 public:
  explicit Channel(const std::string& toml)
      : suspension_(drivers::parse_case(toml, "test.toml").plan, MPI_COMM_SELF) {}

  /// Runs until `time`, in W^2/nu. Throws coupling::BodyFailure.
  void run(double time) {
    const std::int64_t end = suspension_.plan().units.lattice_steps(time);
    while (suspension_.steps() < end) suspension_.step();
  }
  [[nodiscard]] suspension::BodySample sample(std::size_t body) const {
    return suspension::sample(suspension_.own(body)->observe());
  }
  /// [nu/W]
  [[nodiscard]] double largest_velocity() const {
    return suspension_.plan().units.velocity(suspension_.plan().u_max);
  }

 private:
  suspension::Suspension suspension_;
};

}  // namespace ductile::test
