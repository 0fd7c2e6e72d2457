#include "ductile/membrane/integrator.hpp"

#include <stdexcept>
#include <string>

#include "adams_bashforth.hpp"
#include "explicit_euler.hpp"
#include "implicit.hpp"
#include "semi_implicit.hpp"

namespace ductile::membrane {

std::span<const Scheme> schemes() {
  static const Scheme table[] = {
      scheme<ExplicitEuler>("explicit-euler"),  // stays the first: reference_scheme()
      scheme<AdamsBashforth>("adams-bashforth"),
      scheme<SemiImplicit>("semi-implicit"),
      scheme<Implicit>("implicit"),
  };
  return table;
}

void Integrator::correct_force(const State& /*state*/, Vec /*fluid_velocity*/,
                               const Response& /*response*/, Vec /*increment*/) {
  throw std::logic_error("this integrator makes no corrections");
}

const Scheme& reference_scheme() {
  return schemes().front();
}

std::vector<std::string_view> integrator_names() {
  std::vector<std::string_view> names;
  for (const Scheme& scheme : schemes()) names.push_back(scheme.name);
  return names;
}

const Scheme& find_scheme(std::string_view name) {
  std::string known;
  for (const Scheme& scheme : schemes()) {
    if (scheme.name == name) return scheme;
    known += known.empty() ? "" : ", ";
    known += scheme.name;
  }
  throw std::invalid_argument("unknown membrane integrator '" + std::string(name) +
                              "'; known: " + known);
}

IntegratorFactory make_integrator(const Scheme& scheme, const IntegratorOptions& options) {
  if (!(options.theta >= 0.5 && options.theta <= 1)) {
    throw std::invalid_argument("integrator: theta = " + std::to_string(options.theta) +
                                " must be from 0.5 (no slip) to 1 (most damping)");
  }
  if (options.substeps < 1) {
    throw std::invalid_argument("integrator: substeps = " + std::to_string(options.substeps) +
                                " must be at least 1");
  }
  if (options.step_cuts < 0 || options.step_cuts > 20) {
    throw std::invalid_argument("integrator: step_cuts = " + std::to_string(options.step_cuts) +
                                " must be from 0 (none) to 20");
  }
  return [make = scheme.make, options](const Shell& shell, Vec mobility) {
    return make(shell, mobility, options);
  };
}

IntegratorFactory make_integrator(std::string_view name, const IntegratorOptions& options) {
  return make_integrator(find_scheme(name), options);
}

}  // namespace ductile::membrane
