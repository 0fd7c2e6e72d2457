// From a document to a scenario.
#pragma once

#include "scenario/document.hpp"
#include "scenario/scenario.hpp"

namespace ductile::drivers {

/// The scenario that the document describes, all defaults in; without `name` in it, it is called
/// after the file's stem. Sees to keys, types and the bounds of each value by itself; whether
/// values go together is for checks/validation.hpp to say. Throws InputError.
Scenario parse_scenario(const Document& document);

}  // namespace ductile::drivers
