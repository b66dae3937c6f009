#pragma once

#include <collision/contacts/contact.h>

namespace atl::collision {

/// Impulses of an old manifold, by what identifies its points.
struct OldPoints {
  int count = 0;
  std::array<FeatureId, max_points> ids;
  std::array<float, max_points> impulses;
  std::array<Vector3, max_points> positions;  ///< m, reference frame
  bool reference_is_second = false;

  static OldPoints of(const Contact& contact, const ContactManifold& manifold);
};

struct PointMatches {
  int by_id = 0;
  int missed = 0;  ///< points of a pair that had some before, without an old point of the same id
};

/// Hands impulses on to the points of a recomputed manifold: by feature id first, then, among what is left, from the
/// nearest old point within `reach` (m). New points start at zero.
PointMatches match_points(const OldPoints& old, const Manifold& recomputed, double reach, ContactManifold& manifold);

}  // namespace atl::collision
