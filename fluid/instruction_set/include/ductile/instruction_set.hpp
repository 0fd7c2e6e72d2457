// The instruction sets that kernels, the innermost loops, are compiled for; one is chosen as the
// program runs.
#pragma once

#include <string_view>

namespace ductile {

/// From the narrowest to the widest vectors. `baseline` is what the compiler takes for granted.
enum class InstructionSet { baseline, avx2, avx512 };

/// Whether this program has the kernels for it and this machine can run it.
bool available(InstructionSet set);
/// The widest one available.
InstructionSet best_instruction_set();
/// "baseline", "AVX2", "AVX-512".
std::string_view name(InstructionSet set);

}  // namespace ductile
