#include "petsc_options.hpp"

#include <fmt/format.h>
#include <petscsys.h>

#include <set>
#include <string>
#include <vector>

#include "ductile/membrane/capsule.hpp"
#include "errors.hpp"

namespace ductile::drivers {
namespace {

// A slightly inflated sphere in a fluid that lets each vertex drift with its own force.
void take_a_step(const MembraneOptions& options) {
  constexpr double drag = 0.1;
  const surface::Mesh reference = surface::icosphere(2, 4);
  const surface::Mesh inflated = surface::icosphere(2, 4.001);
  membrane::CapsuleOptions capsule_options;
  capsule_options.viscosity = 1;
  capsule_options.integrator = membrane::make_integrator(options.integrator);
  membrane::Capsule capsule(reference, inflated.vertices, {.k_s = 0.1, .k_a = 0.2},
                            capsule_options);
  std::vector<double> force(capsule.positions().size());
  std::vector<double> velocity(force.size());
  std::vector<double> increment(force.size());
  const auto drift = [](std::span<const double> f, std::span<double> v) {
    for (std::size_t k = 0; k < f.size(); ++k) v[k] = drag * f[k];
  };
  capsule.predict_force(force);
  for (int round = 0; round < capsule.corrections(); ++round) {
    drift(force, velocity);
    capsule.correct_force(velocity, drift, increment);
    for (std::size_t k = 0; k < force.size(); ++k) force[k] += increment[k];
  }
}

}  // namespace

void set_petsc_options(const Scenario& scenario) {
  for (const auto& [name, value] : scenario.petsc) {
    membrane::petsc_check(PetscOptionsSetValue(nullptr, ("-" + name).c_str(),
                                               value.empty() ? nullptr : value.c_str()));
  }
  // PetscFinalize() prints the log; to have one takes a start.
  PetscBool log = PETSC_FALSE;
  membrane::petsc_check(PetscOptionsHasName(nullptr, nullptr, "-log_view", &log));
  if (log == PETSC_TRUE) membrane::petsc_check(PetscLogDefaultBegin());
}

void try_petsc_options(const Scenario& scenario) {
  if (scenario.petsc.empty()) return;
  try {
    set_petsc_options(scenario);
    std::set<std::string> tried;
    for (const BodyOptions& body : scenario.bodies) {
      if (body.kind == BodyKind::capsule && tried.insert(body.membrane.integrator).second)
        take_a_step(body.membrane);
    }
  } catch (const membrane::SolveFailure&) {
    // The options are understood; whether they serve is for the run to tell.
  } catch (const membrane::PetscFailure& failure) {
    throw InputError(fmt::format("[petsc]: {}; mend the option or remove it", failure.what()));
  } catch (const std::invalid_argument& refused) {
    throw InputError(fmt::format("[petsc]: {}", refused.what()));
  }
}

}  // namespace ductile::drivers
