// Compiles the kernels once for each instruction set, and picks one at run time.

// The sets worth their compile time: each left out is within a few percent of one kept.
#include <hwy/detect_targets.h>
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels.cpp"  // NOLINT: Highway includes this file again for each set
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <jobs/with_joints.h>
#include <jobs/with_restitution.h>

#include "body_kernels-inl.h"
#include "contact_impulses-inl.h"
#include "contact_prepare-inl.h"
#include "contact_sweep-inl.h"
#include "joint_sweep-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {

const Kernels* kernels() {
  static const Kernels table = {set_name(),
                                lanes,
                                &prepare,
                                &warm_start,
                                &sweep,
                                with_restitution ? &restitute : nullptr,
                                &store_impulses,
                                &integrate_velocities,
                                &clear_corrections,
                                &integrate_positions,
                                with_joints ? &prepare_joints : nullptr,
                                with_joints ? &warm_start_joints : nullptr,
                                with_joints ? &sweep_joints : nullptr};
  return &table;
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace atl::solver {

HWY_EXPORT(kernels);

namespace {

// A dispatch state of our own: Highway's is one for the process, and every world may choose for itself.
const Kernels* kernels_for(std::int64_t target) {
  hwy::ChosenTarget chosen;
  chosen.Update(target);
  return HWY_DISPATCH_TABLE(kernels)[chosen.GetIndex()]();
}

}  // namespace

const std::vector<const Kernels*>& available_kernels() {
  static const std::vector<const Kernels*> available = [] {
    std::vector<const Kernels*> found;
    // Lower bits stand for better sets.
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) found.push_back(kernels_for(target));
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
#endif  // HWY_ONCE
