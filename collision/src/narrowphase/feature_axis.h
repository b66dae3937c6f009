#pragma once

#include "narrowphase/convex_axis.h"

namespace atl::collision {

/// Turns an axis of two solids to the best for the features that it names, of the solids themselves: for rims, sides
/// and points in closed form, or by Newton's method in one angle. The witness lies on the second's surface. False, and
/// nothing changed, where the features make no such contact (a face, two rims, lines that run along each other), or
/// where the best axis that they have isn't one of the solids, or isn't near the one given. Of cylinders and cones the
/// features become those that need no core: a vertex for a rim, a face for the side.
bool settle_on_features(const SolidPair& pair, const Polytope& first, const Polytope& second, LocalAxis& axis);

/// Whether a face that isn't the one that meets may part overlapping solids better than the axis by more than `slack`
/// (m), as in find_axis(). Of cylinders and cones: the caps, and the side where it is nearest to the contact.
bool face_may_be_better(const SolidPair& pair, const Polytope& first, const Polytope& second, const LocalAxis& axis,
                        double slack);

/// PackedAxis of an axis so settled; and the axis of the same features for the solids as they lie now, if it is still
/// the best near by and no face may part them better. Builds the cores but of cylinders and cones.
std::uint32_t packed_features(const LocalAxis& axis);
bool find_on_last_features(const SolidPair& pair, const KnownAxis& known, Core& first, Core& second, LocalAxis& axis);

}  // namespace atl::collision
