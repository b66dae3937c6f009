// Compiles the kernels once for each instruction set, and picks one at run time. The sets are the solver's.

#include <hwy/detect_targets.h>
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "contacts/narrowphase_kernels.cpp"  // NOLINT: Highway includes this file again for each set
#include <collision/contacts/narrowphase_kernels.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "contacts/refresh_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::collision {
namespace HWY_NAMESPACE {

const NarrowphaseKernels* narrowphase_kernels() {
  static const NarrowphaseKernels table = {jobs::HWY_NAMESPACE::set_name(), &refresh,
                                           find_box_axes_kernel(jobs::HWY_NAMESPACE::set_name())};
  return &table;
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atl::collision {

HWY_EXPORT(narrowphase_kernels);

namespace {

const NarrowphaseKernels& kernels_of(std::int64_t target) {
  hwy::ChosenTarget chosen;
  chosen.Update(target);
  return *HWY_DISPATCH_TABLE(narrowphase_kernels)[chosen.GetIndex()]();
}

}  // namespace

const NarrowphaseKernels* find_narrowphase_kernels(std::string_view name) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    const NarrowphaseKernels& kernels = kernels_of(target);
    if (kernels.name == name) return &kernels;
  }
  return nullptr;
}

}  // namespace atl::collision
#endif  // HWY_ONCE
