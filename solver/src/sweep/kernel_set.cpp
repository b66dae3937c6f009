// The kernels for one instruction set: compiled once for each. kernels.cpp picks one at run time.

#include <jobs/one_set-inl.h>
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sweep/kernel_set.cpp"  // NOLINT: Highway includes this file again for each set
#include <features/with_joints.h>
#include <features/with_restitution.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET == ATOLL_SET

#include "integrate/body_kernels-inl.h"
#include "sweep/contact_bounces-inl.h"
#include "sweep/contact_impulses-inl.h"
#include "sweep/contact_prepare-inl.h"
#include "sweep/contact_sweep-inl.h"
#include "sweep/joint_energy-inl.h"
#include "sweep/joint_rows-inl.h"
#include "sweep/joint_sweep-inl.h"
#include "sweep/kernel_sets.h"

HWY_BEFORE_NAMESPACE();
namespace atl::solver {
namespace HWY_NAMESPACE {

const Kernels& kernels() {
  static const Kernels table = {set_name(),
                                lanes,
                                &prepare,
                                &warm_start,
                                &find_fitting,
                                &fit_impulses,
                                &sweep,
                                with_restitution ? &find_approaches : nullptr,
                                &store_impulses,
                                &integrate_velocities,
                                &clear_corrections,
                                &integrate_positions,
                                with_joints ? &prepare_joints : nullptr,
                                with_joints ? &refresh_rows : nullptr,
                                with_joints ? &warm_start_joints : nullptr,
                                with_joints ? &sweep_joints : nullptr,
                                with_joints ? &find_work : nullptr};
  return table;
}

}  // namespace HWY_NAMESPACE

template <>
const Kernels* kernels_of_set<ATOLL_SET>() {
  return &HWY_NAMESPACE::kernels();
}

}  // namespace atl::solver
HWY_AFTER_NAMESPACE();

#endif  // HWY_TARGET == ATOLL_SET
