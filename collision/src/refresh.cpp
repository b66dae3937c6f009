// Compiles the kernels once for each instruction set, and picks one at run time. The sets are the solver's.

#include <hwy/detect_targets.h>
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "refresh.cpp"  // NOLINT: Highway includes this file again for each set
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "refresh_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::collision {
namespace HWY_NAMESPACE {

const RefreshKernels* refresh_kernels() {
  static const RefreshKernels table = {jobs::HWY_NAMESPACE::set_name(), &refresh};
  return &table;
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atl::collision {

HWY_EXPORT(refresh_kernels);

const RefreshKernels* find_refresh_kernels(std::string_view name) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::ChosenTarget chosen;
    chosen.Update(target);
    const RefreshKernels* kernels = HWY_DISPATCH_TABLE(refresh_kernels)[chosen.GetIndex()]();
    if (kernels->name == name) return kernels;
  }
  return nullptr;
}

}  // namespace atl::collision
#endif  // HWY_ONCE
