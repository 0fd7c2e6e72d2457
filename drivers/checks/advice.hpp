// What a user should know of a case before running it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/stability.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

/// Seconds that a run may spend on predictions before its first step.
constexpr double patience_of_a_run = 20;

/// What a user should know before trusting the run, one line each. Predicts the stability of
/// capsules whose integrator has a limit, which takes a moment, as far as `models`, the case's,
/// have the time; without them `patience` seconds at most.
std::vector<std::string> warnings(const Case& given, StabilityModels& models);
std::vector<std::string> warnings(const Case& given, double patience = patience_of_a_run);

/// What the lattice or a default has made of the scenario that is not as the paper or the user has
/// it, one line each: a smaller volume modulus, lengths rounded to whole nodes.
std::vector<std::string> notes(const Case& given);

/// What there is to say of the scheme that a capsule has: "the cheapest that is stable here".
std::string judgement(const membrane::Scheme& scheme, const StabilityModel& model);

/// A warning if the capsule's scheme is not to be relied on, else "".
std::string stability_warning(const membrane::Scheme& scheme, const StabilityModel& model);

/// "21% of the limit of explicit-euler (shear 10%, bending 1%, volume 21%)"
std::string percentages(const StabilityLoad& load, std::string_view integrator);

/// "21.3 MB"
std::string size_text(double bytes);

}  // namespace ductile::drivers
