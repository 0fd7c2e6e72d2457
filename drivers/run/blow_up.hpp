// Where a run blew up, and why it may have.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/contacts.hpp"
#include "ductile/suspension/suspension.hpp"
#include "output/summary.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

/// What a run's warning of its Mach number begins with.
constexpr std::string_view too_fast = "too fast for the lattice";

/// The blow-up with its place and its likely cause: from the state that it has left, the contacts
/// of the run so far, and what has been warned of.
BlowUp explained(BlowUp blow_up, const Case& given,
                 const std::vector<suspension::SurfaceState>& surfaces,
                 const suspension::FluidState& fluid, const Contacts& contacts,
                 const std::vector<std::string>& warnings);

}  // namespace ductile::drivers
