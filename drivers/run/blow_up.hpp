// Where a run blew up, and why it may have.
#pragma once

#include <string>
#include <vector>

#include "analysis/contacts.hpp"
#include "ductile/suspension/suspension.hpp"
#include "output/summary.hpp"
#include "scenario/plan.hpp"

namespace ductile::drivers {

/// The blow-up with its place and its likely cause: from the state that it has left, the contacts
/// of the run so far, and what was warned of before the run.
BlowUp explained(BlowUp blow_up, const Case& given,
                 const std::vector<suspension::SurfaceState>& surfaces,
                 const suspension::FluidState& fluid, const Contacts& contacts,
                 const std::vector<std::string>& warnings);

}  // namespace ductile::drivers
