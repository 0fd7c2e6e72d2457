// libFuzzer's way into one of the inputs: DUCTILE_FUZZ_INPUT is its name.
#include <cstddef>
#include <cstdint>

#include "fuzz/inputs.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ductile::drivers::fuzz::DUCTILE_FUZZ_INPUT({reinterpret_cast<const char*>(data), size});
  return 0;
}
