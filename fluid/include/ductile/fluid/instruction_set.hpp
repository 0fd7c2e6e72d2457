// The instruction sets that the fluid's kernel is compiled for; one is chosen when a fluid is made.
#pragma once

#include <string_view>

namespace ductile::fluid {

/// From the narrowest to the widest vectors. `baseline` is what the compiler takes for granted.
enum class InstructionSet { baseline, avx2, avx512 };

/// Whether this program has the kernel for it and this machine can run it.
bool available(InstructionSet set);
/// The widest one available.
InstructionSet best_instruction_set();
/// "baseline", "AVX2", "AVX-512".
std::string_view name(InstructionSet set);

}  // namespace ductile::fluid
