#include "ductile/membrane/integrator.hpp"

#include <cmath>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "adams_bashforth.hpp"
#include "explicit_euler.hpp"
#include "implicit.hpp"
#include "semi_implicit.hpp"

namespace ductile::membrane {
namespace {

using Factory = std::unique_ptr<Integrator> (*)(const Shell&, Vec, const IntegratorOptions&);

template <class Scheme>
std::unique_ptr<Integrator> make(const Shell& shell, Vec mobility,
                                 const IntegratorOptions& options) {
  if constexpr (std::is_constructible_v<Scheme, const Shell&, Vec, const IntegratorOptions&>) {
    return std::make_unique<Scheme>(shell, mobility, options);
  } else {
    return std::make_unique<Scheme>(shell, mobility);
  }
}

constexpr std::pair<std::string_view, Factory> schemes[] = {
    {"explicit-euler", make<ExplicitEuler>},
    {"adams-bashforth", make<AdamsBashforth>},
    {"semi-implicit", make<SemiImplicit>},
    {"implicit", make<Implicit>},
};

}  // namespace

void Integrator::correct_force(const State& /*state*/, Vec /*fluid_velocity*/,
                               const Response& /*response*/, Vec /*increment*/) {
  throw std::logic_error("this integrator makes no corrections");
}

IntegratorFactory make_integrator(std::string_view name, const IntegratorOptions& options) {
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
  std::string known;
  for (const auto& [scheme, factory] : schemes) {
    if (scheme == name) {
      return [factory = factory, options](const Shell& shell, Vec mobility) {
        return factory(shell, mobility, options);
      };
    }
    known += known.empty() ? "" : ", ";
    known += scheme;
  }
  throw std::invalid_argument("unknown membrane integrator '" + std::string(name) +
                              "'; known: " + known);
}

std::vector<std::string_view> integrator_names() {
  std::vector<std::string_view> names;
  for (const auto& [scheme, factory] : schemes) names.push_back(scheme);
  return names;
}

}  // namespace ductile::membrane
