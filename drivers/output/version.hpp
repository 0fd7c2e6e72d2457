// Versions of the program and of what it is built from.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace ductile::drivers {

/// Name and version of the program, the compiler and the libraries, the program first; "kernel" is
/// the instruction set that the fluid runs on here.
std::vector<std::pair<std::string, std::string>> versions();

}  // namespace ductile::drivers
