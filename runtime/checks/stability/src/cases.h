#pragma once

#include "checks/stability/suite.h"

namespace atl::stability {

using CaseList = std::vector<StabilityCase>;

void add_stacks(CaseList& cases);    ///< towers, ladders of mass, pyramids and walls
void add_masonry(CaseList& cases);   ///< what stands by balance and friction: cards, arches, planks, dominoes
void add_joints(CaseList& cases);    ///< chains, nets and bridges under heavy loads
void add_springs(CaseList& cases);   ///< contacts and joints stiffer than a step can follow
void add_overlaps(CaseList& cases);  ///< what starts or is pressed inside something else
void add_impacts(CaseList& cases);   ///< fast and lossless ones
void add_spins(CaseList& cases);     ///< fast rotation, slender bodies
void add_friction(CaseList& cases);  ///< from none to more than any load exhausts, and Painleve's rod
void add_scales(CaseList& cases);    ///< steps, gravity, sizes and places

}  // namespace atl::stability
