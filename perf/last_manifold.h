#pragma once

#include <collision/narrowphase/collide.h>

namespace atl::collision {

/// What is known of a contact when the pair is looked at again, of its manifold: what collide() takes on entry.
inline Manifold as_last(const Manifold& found) {
  Manifold last;
  last.axis = found.axis;
  last.known = found.count > 0;
  last.normal = found.normal;
  last.reference_is_second = found.reference_is_second;
  for (int i = 0; i < found.count; ++i) {
    last.middle += found.points[static_cast<std::size_t>(i)].position / found.count;
  }
  return last;
}

}  // namespace atl::collision
