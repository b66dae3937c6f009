#pragma once

#include <collision/narrowphase/gauss_map_descent.h>
#include <collision/narrowphase/manifold.h>
#include <collision/shapes/pose.h>
#include <collision/shapes/shape.h>

namespace atl::collision {

/// Two solids in the frame of the first.
struct SolidPair {
  const Shape& first;
  const Shape& second;
  Vector3 position;  ///< m, of the second
  Matrix3 rotation;  ///< its axes, as columns

  double size() const { return first.inner_radius < second.inner_radius ? first.inner_radius : second.inner_radius; }
  /// The separation of the solids (m) along a unit direction from the first to the second.
  double separation_along(const Vector3& normal) const;
  /// True if one of the two is a cylinder or a cone.
  bool has_round() const;
  /// Tells if one is an ellipsoid or a tapered capsule.
  bool has_smooth() const { return is_smooth(first.kind) || is_smooth(second.kind); }
};

/// The axis that the search starts from: that of the pair's last manifold.
struct KnownAxis {
  bool exists = false;
  Vector3 normal = Vector3::Zero();  ///< from the first to the second, frame of the first
  Vector3 point = Vector3::Zero();   ///< m, in the middle of the contact, frame of the first
  std::uint32_t features = 0;        ///< the features of that axis, as in Manifold::axis; 0: unknown
};

/// The direction that parts two solids best; where they overlap deeply perhaps but a good one. Builds the cores
/// (polytope.h), which the features found are those of. The separation is exact along the normal; the normal is
/// so too, but for cylinders and cones, which see refine_axis().
///
/// A pair that touches is followed from its known axis. A pair without one is FCL's to decide, unless a walk from the
/// line of centres finds it apart by more than `margin` (m), and how far. Where FCL finds no contact there is none.
/// Its axis names the features that meet. It is refuted where the solids don't lie along it as deep as FCL says, or
/// where a face near by parts them better: FCL's refinement starts from the line of centres, which in a wide slab leads
/// to its far sides (Narrowphase::Repaired).
struct AxisSearch {
  Narrowphase by = Narrowphase::ClosedForm;
  bool touches = false;
  LocalAxis axis;  ///< set if they are no farther apart than the margin
  double gap = 0;  ///< m, where they don't touch: at least so far apart, if it is known
};
AxisSearch find_axis(const SolidPair& pair, double margin, const KnownAxis& known, Core& first, Core& second);

/// Manifold::axis of two solids: the reference face by its number and whose it is, two edges that cross, or, where one
/// is round, what meets, see settle_on_features().
enum class AxisOf : std::uint32_t { None, FaceOfFirst, FaceOfSecond, Edges, Features };
struct PackedAxis {
  AxisOf of = AxisOf::None;
  int number = 0;         ///< of the face, or the edge or the feature of the first
  int second_number = 0;  ///< of the edge or the feature of the second

  constexpr std::uint32_t packed() const {
    return static_cast<std::uint32_t>(of) << 28 | static_cast<std::uint32_t>(second_number) << 14 |
           static_cast<std::uint32_t>(number);
  }
  static constexpr PackedAxis unpacked(std::uint32_t axis) {
    return {static_cast<AxisOf>(axis >> 28), static_cast<int>(axis & 0x3fff), static_cast<int>(axis >> 14 & 0x3fff)};
  }
};

/// The part of a cylinder or a cone that a feature of its polygonal core approximates.
enum class RoundFeature { UpperRim, LowerRim, Apex, Side, Cap };
RoundFeature round_feature(const Shape& shape, const Polytope& core, const Feature& feature);

/// Turns the axis found to the best for cylinders and cones themselves, within 0.05 degrees. Nothing to do for
/// other shapes. Looks first where the shapes are known to have touched. Whether it ends on features that settle, see
/// settle_on_features().
bool refine_axis(const SolidPair& pair, const KnownAxis& known, Core& first, Core& second, LocalAxis& axis);

/// Turns an axis of two solids to the best for the features that it names, of the solids themselves: for rims, sides
/// and points in closed form, or by Newton's method in one angle. The witness lies on the second's surface. False, and
/// nothing changed, where the features make no such contact (a face, two rims, lines that run along each other), or
/// where the best axis that they have isn't one of the solids, or isn't near the one given. Of cylinders and cones the
/// features become those that need no core: a vertex for a rim, a face for the side.
bool settle_on_features(const SolidPair& pair, const Polytope& first, const Polytope& second, LocalAxis& axis);

/// True if a face other than the one that meets may part overlapping solids better than the axis, by more than `slack`
/// (m); see find_axis(). For cylinders and cones, the faces are the caps, and the side at its nearest to the contact.
bool face_may_be_better(const SolidPair& pair, const Polytope& first, const Polytope& second, const LocalAxis& axis,
                        double slack);

/// PackedAxis of an axis so settled; and the axis of the same features for the solids as they lie now, if it is still
/// the best near by and no face may part them better. Builds the cores but of cylinders and cones.
std::uint32_t packed_features(const LocalAxis& axis);
bool find_on_last_features(const SolidPair& pair, const KnownAxis& known, Core& first, Core& second, LocalAxis& axis);

}  // namespace atl::collision
