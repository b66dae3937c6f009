#pragma once

#include <collision/contacts/refresh.h>
#include <collision/narrowphase/box_axes.h>

#include <string_view>

namespace atl::collision {

/// The wide kernels for one instruction set; the same bits on each.
struct NarrowphaseKernels {
  const char* name;

  /// Writes the geometry of the contacts to their manifolds, moved as their shapes have since these were computed:
  /// exact for fixed features. With `all` every lane; else only those that may be recycled, which have drifted less
  /// than the tolerances and whose speculative margin is covered by the one that they were computed with. Returns these
  /// lanes' bits. Contacts without points write nothing. Impulses and materials stay. Only lanes below `count` are
  /// written.
  unsigned (*refresh)(const RefreshBlock& block, std::size_t count, bool all);

  /// Finds the relative poses and separating axes of pairs of boxes.
  BoxAxesKernel find_box_axes;
};

/// The sets that this machine runs, by the solver's names for them. Null if it lacks one.
const NarrowphaseKernels* find_narrowphase_kernels(std::string_view name);

}  // namespace atl::collision
