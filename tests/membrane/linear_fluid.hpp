// A fluid of a few lines for capsules: a linear flow in which each vertex drifts with its own
// force.
#pragma once

#include <petscsys.h>

#include <Eigen/Core>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "ductile/membrane/capsule.hpp"

namespace ductile::membrane::test {

/// u_i = flow + gradient (x_i - centre) + drag F_i, all of it times the length of a step, so that
/// steps can be refined.
struct LinearFluid {
  Eigen::Vector3d flow = Eigen::Vector3d::Zero();
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double drag = 0;
  double time_step = 1;

  void step(Capsule& capsule) const {
    std::vector<double> force(capsule.positions().size()), velocity = force, increment = force;
    const auto velocity_of = [&] {
      for (std::size_t k = 0; k < force.size(); k += 3) {
        using Eigen::Vector3d;
        Vector3d::Map(&velocity[k]) =
            time_step * (flow + gradient * (Vector3d::Map(&capsule.positions()[k]) - centre) +
                         drag * Vector3d::Map(&force[k]));
      }
    };
    const Response response = [&](std::span<const double> f, std::span<double> u) {
      for (std::size_t k = 0; k < f.size(); ++k) u[k] = time_step * drag * f[k];
    };
    capsule.predict_force(force);
    for (int round = 0; round < capsule.corrections(); ++round) {
      velocity_of();
      capsule.correct_force(velocity, response, increment);
      for (std::size_t k = 0; k < force.size(); ++k) force[k] += increment[k];
    }
    velocity_of();
    capsule.advance(velocity);
  }
};

/// PETSc options while this object lives; an empty value is none.
class PetscOptions {
 public:
  PetscOptions(std::initializer_list<std::pair<std::string, std::string>> options)
      : options_(options) {
    for (const auto& [name, value] : options_) {
      petsc_check(
          PetscOptionsSetValue(nullptr, name.c_str(), value.empty() ? nullptr : value.c_str()));
    }
  }
  PetscOptions(const PetscOptions&) = delete;
  PetscOptions& operator=(const PetscOptions&) = delete;
  ~PetscOptions() {
    for (const auto& [name, value] : options_)
      static_cast<void>(PetscOptionsClearValue(nullptr, name.c_str()));
  }

 private:
  std::vector<std::pair<std::string, std::string>> options_;
};

}  // namespace ductile::membrane::test
