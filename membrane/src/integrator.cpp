#include "ductile/membrane/integrator.hpp"

#include <stdexcept>
#include <string>
#include <utility>

#include "adams_bashforth.hpp"
#include "explicit_euler.hpp"

namespace ductile::membrane {
namespace {

template <class Scheme>
std::unique_ptr<Integrator> make(const Shell& shell, Vec mobility) {
  return std::make_unique<Scheme>(shell, mobility);
}

constexpr std::pair<std::string_view, std::unique_ptr<Integrator> (*)(const Shell&, Vec)>
    schemes[] = {
        {"explicit-euler", make<ExplicitEuler>},
        {"adams-bashforth", make<AdamsBashforth>},
};

}  // namespace

void Integrator::correct_force(const State& /*state*/, Vec /*fluid_velocity*/,
                               const Response& /*response*/, Vec /*increment*/) {
  throw std::logic_error("this integrator makes no corrections");
}

IntegratorFactory make_integrator(std::string_view name) {
  std::string known;
  for (const auto& [scheme, factory] : schemes) {
    if (scheme == name) return factory;
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
