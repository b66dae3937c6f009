// Compiles the kernel for pairs of boxes once for each instruction set, and picks one at run time. The sets are the
// solver's.

#include <hwy/detect_targets.h>
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "narrowphase/box_axes_kernels.cpp"  // NOLINT: Highway includes this file again for each set
#include <collision/narrowphase/box_axes.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <jobs/lanes-inl.h>

#include "narrowphase/box_axes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::collision {

#ifndef ATOLL_COLLISION_BOX_AXES_SET_
#define ATOLL_COLLISION_BOX_AXES_SET_
struct BoxAxesSet {
  const char* name;
  BoxAxesKernel find_box_axes;
};
#endif

namespace HWY_NAMESPACE {

const BoxAxesSet* box_axes_set() {
  static const BoxAxesSet set = {jobs::HWY_NAMESPACE::set_name(), &find_box_axes};
  return &set;
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atl::collision {

HWY_EXPORT(box_axes_set);

namespace {

const BoxAxesSet& set_of(std::int64_t target) {
  hwy::ChosenTarget chosen;
  chosen.Update(target);
  return *HWY_DISPATCH_TABLE(box_axes_set)[chosen.GetIndex()]();
}

}  // namespace

BoxAxesKernel find_box_axes_kernel(std::string_view name) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    const BoxAxesSet& set = set_of(target);
    if (set.name == name) return set.find_box_axes;
  }
  return nullptr;
}

BoxAxesKernel widest_box_axes_kernel() {
  static const BoxAxesKernel widest = set_of(hwy::SupportedAndGeneratedTargets().front()).find_box_axes;
  return widest;
}

}  // namespace atl::collision
#endif  // HWY_ONCE
