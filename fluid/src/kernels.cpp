// The kernel that is compiled for each instruction set.
#include "kernel.hpp"

namespace ductile::fluid {

template <class Real, class T>
const Kernel<Real, T>& kernel(InstructionSet set, bool compressible) {
#ifdef DUCTILE_X86
  if (set == InstructionSet::avx512) return avx512::kernel<Real, T>(compressible);
  if (set == InstructionSet::avx2) return avx2::kernel<Real, T>(compressible);
#endif
  return baseline::kernel<Real, T>(compressible);
}

template const Kernel<double, double>& kernel<double, double>(InstructionSet set,
                                                              bool compressible);
template const Kernel<float, double>& kernel<float, double>(InstructionSet set, bool compressible);
template const Kernel<float, float>& kernel<float, float>(InstructionSet set, bool compressible);

}  // namespace ductile::fluid
