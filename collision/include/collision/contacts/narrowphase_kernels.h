#pragma once

#include <collision/contacts/refresh.h>
#include <collision/narrowphase/box_axes.h>

#include <string_view>

namespace atl::collision {

/// The wide kernels for one instruction set; the same bits on each.
struct NarrowphaseKernels {
  const char* name;

  /// Writes the geometry of the contacts to their manifolds, moved as their shapes have since they were captured:
  /// exact for fixed features. With `fresh` all lanes (those captured just now); else only those that have drifted
  /// less than the tolerances and whose speculative margin still covers what was captured. Returns these lanes'
  /// bits. Contacts without points write nothing. Impulses and materials stay. Only lanes below `count` are written.
  unsigned (*refresh)(const RefreshBlock& block, std::size_t count, bool fresh);

  /// How pairs of boxes lie to each other.
  void (*find_box_axes)(const BoxBlock& block, BoxAxes& axes);
};

/// The sets that this machine runs, by the solver's names for them. Null if it lacks one.
const NarrowphaseKernels* find_narrowphase_kernels(std::string_view name);

/// Those of the widest set that this machine runs.
const NarrowphaseKernels& widest_narrowphase_kernels();

}  // namespace atl::collision
