#pragma once

#include <atoll/report.h>
#include <collision/contacts/narrowphase_kernels.h>
#include <jobs/arena.h>
#include <solver/sweep/kernels.h>

namespace atl {

class ContactRules;

/// A step as its phases see it; under a force law, one substep of it.
struct StepContext {
  int substeps;
  bool ends_step;  ///< else more substeps follow
  jobs::Arena& arena;
  const solver::Kernels& kernels;
  const collision::NarrowphaseKernels& narrowphase_kernels;
  ContactRules* rules;  ///< null while nobody has a say in contacts
  StepReport& report;   ///< what the phases did
};

}  // namespace atl
