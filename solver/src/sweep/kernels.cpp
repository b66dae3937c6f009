// Picks the kernels of one instruction set at run time. Each set's are compiled in a unit of their own: kernel_set.cpp.

#include <hwy/targets.h>

#include "sweep/kernel_sets.h"

namespace atl::solver {
namespace {

struct CompiledSet {
  std::int64_t set;
  const Kernels* (*kernels)();
};

// Best first.
constexpr CompiledSet compiled_sets[] = {
#if HWY_ARCH_X86
    {HWY_AVX3, &kernels_of_set<HWY_AVX3>},
    {HWY_AVX2, &kernels_of_set<HWY_AVX2>},
    {HWY_SSE4, &kernels_of_set<HWY_SSE4>},
#elif HWY_ARCH_ARM_A64
    {HWY_NEON, &kernels_of_set<HWY_NEON>},
#endif
    {HWY_BASELINE_SCALAR, &kernels_of_set<HWY_BASELINE_SCALAR>},
};

}  // namespace

const std::vector<const Kernels*>& available_kernels() {
  static const std::vector<const Kernels*> available = [] {
    const std::int64_t supported = hwy::SupportedTargets() | HWY_BASELINE_SCALAR;
    std::vector<const Kernels*> found;
    for (const CompiledSet& compiled : compiled_sets) {
      if (supported & compiled.set) found.push_back(compiled.kernels());
    }
    return found;
  }();
  return available;
}

const Kernels* find_kernels(std::string_view name) {
  for (const Kernels* kernels : available_kernels()) {
    if (kernels->name == name) return kernels;
  }
  return nullptr;
}

}  // namespace atl::solver
