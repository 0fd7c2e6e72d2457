// How the library refuses what is out of bounds.
#pragma once

#include <sstream>
#include <stdexcept>

namespace ductile::rigid {

template <class... Parts>
[[noreturn]] void reject(const Parts&... parts) {
  std::ostringstream message;
  message << "rigid: ";
  (message << ... << parts);
  throw std::invalid_argument(message.str());
}

}  // namespace ductile::rigid
