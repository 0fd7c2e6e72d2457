#include "ductile/fluid/instruction_set.hpp"

#include "kernel.hpp"

namespace ductile::fluid {

bool available(InstructionSet set) {
  if (set == InstructionSet::baseline) return true;
#ifdef DUCTILE_X86
  // The builtin asks the processor and whether the operating system keeps the registers.
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") == 0 || __builtin_cpu_supports("fma") == 0) return false;
  if (set == InstructionSet::avx2) return true;
  return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
         __builtin_cpu_supports("avx512dq") != 0;
#else
  return false;
#endif
}

InstructionSet best_instruction_set() {
  for (const InstructionSet set : {InstructionSet::avx512, InstructionSet::avx2}) {
    if (available(set)) return set;
  }
  return InstructionSet::baseline;
}

std::string_view name(InstructionSet set) {
  switch (set) {
    case InstructionSet::avx512:
      return "AVX-512";
    case InstructionSet::avx2:
      return "AVX2";
    case InstructionSet::baseline:
      break;
  }
  return "baseline";
}

template <class Real, class T>
const Kernel<Real>& kernel(InstructionSet set, bool compressible) {
#ifdef DUCTILE_X86
  if (set == InstructionSet::avx512) return avx512::kernel<Real, T>(compressible);
  if (set == InstructionSet::avx2) return avx2::kernel<Real, T>(compressible);
#endif
  return baseline::kernel<Real, T>(compressible);
}

template const Kernel<double>& kernel<double, double>(InstructionSet set, bool compressible);
template const Kernel<float>& kernel<float, double>(InstructionSet set, bool compressible);
template const Kernel<float>& kernel<float, float>(InstructionSet set, bool compressible);

}  // namespace ductile::fluid
