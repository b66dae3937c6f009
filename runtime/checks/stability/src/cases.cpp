#include "cases.h"

namespace atl::stability {

const std::vector<StabilityCase>& stability_cases() {
  static const CaseList all = [] {
    CaseList cases;
    add_stacks(cases);
    add_masonry(cases);
    add_joints(cases);
    add_springs(cases);
    add_overlaps(cases);
    add_impacts(cases);
    add_spins(cases);
    add_friction(cases);
    add_scales(cases);
    return cases;
  }();
  return all;
}

}  // namespace atl::stability
