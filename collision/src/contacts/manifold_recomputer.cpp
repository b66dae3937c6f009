#include "contacts/manifold_recomputer.h"

#include <collision/contacts/match_points.h>
#include <collision/shapes/shape.h>
#include <features/with_meshes.h>
#include <jobs/assert.h>

#include <algorithm>
#include <utility>

#include "contacts/pair_motion.h"

namespace atl::collision {
namespace {

// A new point that matches no old one by id takes over the impulse of one that lies this near, as part of the
// smaller shape's inner radius.
constexpr double match_distance = 0.04;

// By the inner radius of a solid: how far around it triangles are looked for, where none touches it, so that it can be
// left alone for some steps; and how far off they have to be for that to be worth it.
constexpr double surface_gap_share = 1;
constexpr double min_surface_gap = 0.1;
// How far around the ball that a solid lies in they are looked for first: as far as it gets in some steps, in radii
// from the least to the most. And how far turning by 1 rad counts as bringing the ball nearer, in radii: it doesn't,
// but a surface that is turned by hand (put_elsewhere) has to show.
constexpr double ball_gap_steps = 4;
constexpr double min_ball_gap = 0.5;
constexpr double max_ball_gap = 1.2;
constexpr double ball_radius_part = 1e-3;
static_assert(ball_radius_part * put_elsewhere > max_ball_gap);

// The incident box's pose in the frame of the reference box, for one lane.
Pose incident_in_reference(const BoxAxes& axes, std::size_t lane, bool reference_is_second) {
  const auto position = [&](std::size_t i) { return axes.position[i][lane]; };
  const auto turn = [&](std::size_t i) { return axes.orientation[i][lane]; };
  Pose second{{position(0), position(1), position(2)}, {turn(3), turn(0), turn(1), turn(2)}};
  if (!reference_is_second) return second;
  return relative(second, {Vector3::Zero(), Quaternion::Identity()});
}

// A manifold that starts with what is known of the pair's last one. Two that were apart have none: what isn't in the
// first cache line of theirs isn't read.
Manifold manifold_after_last(const Contact& contact, bool swapped) {
  Manifold manifold;
  if (contact.gap > 0) return manifold;
  manifold.axis = contact.axis;
  manifold.known = contact.count > 0;
  if (!manifold.known) return manifold;
  manifold.reference_is_second = contact.reference_is_second != swapped;
  const auto& [x, y, z] = contact.normal;
  manifold.normal = Vector3(x, y, z).normalized();
  manifold.middle = Vector3(contact.centre_reference[0], contact.centre_reference[1], contact.centre_reference[2]);
  return manifold;
}

bool are_boxes(const ColliderTable& colliders, Pair pair) {
  return colliders.shape[pair.first].kind == ShapeKind::Box && colliders.shape[pair.second].kind == ShapeKind::Box;
}

bool has_surface(const ColliderTable& colliders, Pair pair) {
  return is_surface(colliders.shape[pair.first].kind) || is_surface(colliders.shape[pair.second].kind);
}

// The tolerance for recycling a manifold, see Contact. A sphere's is recomputed faster than it could be recycled.
float tolerance_of(const ColliderTable& colliders, Pair pair, const Manifold& manifold) {
  const auto is = [&](auto... kinds) {
    const ShapeKind first = colliders.shape[pair.first].kind;
    const ShapeKind second = colliders.shape[pair.second].kind;
    return ((first == kinds || second == kinds) || ...);
  };
  if (is(ShapeKind::Sphere)) return manifold.count > 0 ? 0 : flat_tolerance;
  const bool rolls = manifold.count < 3 && is(ShapeKind::Capsule, ShapeKind::Cylinder, ShapeKind::Cone,
                                              ShapeKind::Ellipsoid, ShapeKind::TaperedCapsule);
  return rolls && manifold.count > 0 ? round_tolerance : flat_tolerance;
}

// m: no point of those of the two that may turn is farther from its shape's origin.
double radius_of(const ContactUpdateInput& input, Pair pair) {
  const ColliderTable& colliders = input.colliders;
  const auto radius = [&](std::uint32_t collider) {
    if (is_surface(colliders.shape[collider].kind) && input.mobility[colliders.body[collider]] == 0) return 0.0;
    return colliders.shape[collider].bounding_radius;
  };
  return std::max(radius(pair.first), radius(pair.second));
}

constexpr auto surface_parts = static_cast<std::size_t>(max_surface_manifolds);

// Which manifold each part of a solid and a surface gets, or -1: manifolds go to the parts that had the most similar
// normals, what is left to any. `old_part(part)` gives the contact as it was.
template <typename OldPart>
std::array<int, surface_parts> assign_to_parts(const SurfaceManifolds& found, const OldPart& old_part) {
  std::array<int, surface_parts> manifold_of;
  manifold_of.fill(-1);
  ATL_ASSERT(found.count >= 0 && found.count <= max_surface_manifolds, found.count);
  std::array<bool, surface_parts> assigned = {};
  const auto assign_best = [&](double min_cosine) {
    for (int m = 0; m < found.count; ++m) {
      if (assigned[static_cast<std::size_t>(m)]) continue;
      double best = min_cosine;
      std::size_t chosen = surface_parts;
      for (std::size_t part = 0; part < surface_parts; ++part) {
        if (manifold_of[part] >= 0) continue;
        const Contact& old = old_part(part);
        const Vector3 normal(old.normal[0], old.normal[1], old.normal[2]);
        const Manifold& manifold = found.manifolds[static_cast<std::size_t>(m)];
        const bool is_like = old.count > 0 && old.material == manifold.material;
        const double cosine = is_like ? normal.dot(manifold.normal) : -1.0;
        if (cosine < best || (chosen != surface_parts && cosine == best)) continue;
        best = cosine;
        chosen = part;
      }
      if (chosen == surface_parts) continue;
      manifold_of[chosen] = m;
      assigned[static_cast<std::size_t>(m)] = true;
    }
  };
  assign_best(0.9);   // the same face as before
  assign_best(-2.0);  // whatever is left
  if constexpr (jobs::with_asserts) {
    for (std::size_t m = 0; m < static_cast<std::size_t>(found.count); ++m) ATL_ASSERT(assigned[m], m, found.count);
  }
  return manifold_of;
}

}  // namespace

void ManifoldRecomputer::run() {
  for (std::size_t i = 0; i < range_.stale_count; ++i) {
    const std::uint32_t entry = range_.stale[i];
    // Parts are recomputed together, by the first of them that is stale.
    if (range_.status[entry] != ContactStatus::Stale) continue;
    ++range_.counts.recomputed;
    const Pair pair = range_.contact(entry).pair;
    if (with_meshes && has_surface(input_.colliders, pair)) {
      const std::size_t first = entry - range_.contact(entry).part;
      ATL_ASSERT(first >= range_.begin && range_.contact(first + surface_parts - 1).pair == pair, entry, first);
      recompute_surface_parts(first);
      for (std::size_t part = 0; part < surface_parts; ++part) range_.record_points(first + part);
    } else if (are_boxes(input_.colliders, pair)) {
      if (box_pairs_.add(entry)) recompute_boxes();
    } else {
      recompute(entry);
      range_.record_points(entry);
    }
  }
  recompute_boxes();
  refresh_replaced();
}

// Stores what the narrowphase found, and hands impulses on.
void ManifoldRecomputer::replace(std::size_t entry, const Manifold& manifold, const Pose& incident, double margin) {
  Contact& contact = range_.contact(entry);
  const std::uint32_t slot = range_.cache.order()[entry];
  ContactManifold& stored = range_.cache.manifolds[slot];
  if (manifold.count == 0) {
    forget_impulses(stored);
  } else {
    const OldPoints old = OldPoints::of(contact, stored);
    const double reach = match_distance * static_cast<double>(contact.size);
    const PointMatches matches = match_points(old, manifold, reach, stored);
    range_.counts.id_matches += matches.by_id;
    range_.counts.id_misses += matches.missed;
  }
  ATL_ASSERT(range_.cache.rises.empty() || range_.cache.rises.size() == range_.cache.contacts.size(),
             range_.cache.rises.size(), range_.cache.contacts.size());
  if (!range_.cache.rises.empty()) range_.cache.rises[slot] = static_cast<float>(manifold.rise);
  store_features(contact, manifold, incident, margin, tolerance_of(input_.colliders, contact.pair, manifold));
  range_.status[entry] = manifold.count > 0 ? ContactStatus::Touching : ContactStatus::Apart;
  if (manifold.count == 0) return;
  refresher_.fetch(slot);
  if (replaced_.add(entry)) refresh_replaced();
}

void ManifoldRecomputer::refresh_replaced() {
  const std::size_t count = std::exchange(replaced_.count, 0);
  if (count == 0) return;
  const ContactOrder& order = range_.cache.order();
  refresher_.refresh(
      count, [&](std::size_t lane) { return order[replaced_.entries[lane]]; }, true);
}

// Does set_apart() for all parts of a solid and a surface that doesn't move. False, with nothing set, if they are too
// near each other for the gap to last.
bool ManifoldRecomputer::set_surface_apart(std::size_t entry, double margin, double gap, double radius) {
  if (gap < margin + min_surface_gap * static_cast<double>(range_.contact(entry).size)) return false;
  for (std::size_t part = 0; part < max_surface_manifolds; ++part) {
    set_apart(entry + part, margin, gap, radius);
    auto& rises = range_.cache.rises;
    if (!rises.empty()) rises[range_.cache.order()[entry + part]] = 0;
  }
  return true;
}

// Two solids found apart are left alone until they have used their gap up, or, where that hardly exceeds the margin,
// until they have moved by the tolerance. Of those that were apart before the first cache line is all that changes.
void ManifoldRecomputer::set_apart(std::size_t entry, double margin, double gap, double radius) {
  Contact& contact = range_.contact(entry);
  if (!(contact.gap > 0)) {
    forget_impulses(range_.manifold(entry));
    store_features(contact, Manifold{}, {Vector3::Zero(), Quaternion::Identity()}, margin, 0);
  }
  contact.radius = static_cast<float>(radius);
  const double size = static_cast<double>(contact.size);
  contact.gap = static_cast<float>(std::max(gap, margin + static_cast<double>(flat_tolerance) * size));
  ATL_ASSERT(contact.gap > 0 && contact.count == 0, entry, contact.gap, contact.count);
  Eigen::Map<Vector3>(contact.apart_from.data()) = origins_apart(contact, input_);
  contact.turned = turned_by_both(contact, input_);
  range_.status[entry] = ContactStatus::Apart;
}

// Gives two solids that were found apart the contact with which they will meet, if that is farther off than the margin.
bool ManifoldRecomputer::meet_ahead(std::size_t entry, double margin, double gap) {
  const Contact& contact = range_.contact(entry);
  const double range = range_of(contact, input_);
  if (!(range > margin) || gap > range) return false;
  const bool bounces = range_.manifold(entry).restitution > 0;
  const std::optional<Meeting> meeting = input_.ahead->find_meeting(contact, bounces, input_, margin);
  if (!meeting) return false;
  count_source(meeting->by);
  replace(entry, meeting->manifold, meeting->incident, margin);
  refresh_replaced();
  ContactManifold& stored = range_.manifold(entry);
  float(&anchor)[3] = meeting->manifold.reference_is_second ? stored.anchor_second : stored.anchor_first;
  for (int i = 0; i < 3; ++i) anchor[i] -= static_cast<float>(meeting->slip[i]);
  return true;
}

void ManifoldRecomputer::count_source(Narrowphase source) {
  range_.counts.fcl_calls += asks_fcl(source);
  range_.counts.fcl_repairs += source == Narrowphase::Repaired;
}

void ManifoldRecomputer::recompute(std::size_t entry) {
  const Contact& contact = range_.contact(entry);
  const Pair pair = contact.pair;
  const ColliderTable& colliders = input_.colliders;
  const Pose first = colliders.pose(pair.first, input_.poses);
  const Pose second = colliders.pose(pair.second, input_.poses);
  const double margin = margin_of(contact, input_);

  // The narrowphase wants the lower kind first.
  const bool swap = colliders.shape[pair.second].kind < colliders.shape[pair.first].kind;
  const Shape& lower = colliders.shape[swap ? pair.second : pair.first];
  const Shape& higher = colliders.shape[swap ? pair.first : pair.second];
  ATL_ASSERT(is_convex_solid(lower.kind), pair.first, pair.second, static_cast<int>(lower.kind));
  const Pose in_lower = swap ? relative(second, first) : relative(first, second);
  const bool bounded = is_convex_solid(higher.kind);
  Manifold manifold = manifold_after_last(contact, swap);
  if (bounded && !manifold.known) {
    const double gap = centre_line(lower, {Vector3::Zero(), Quaternion::Identity()}, higher, in_lower).gap;
    if (gap > range_of(contact, input_)) {
      set_apart(entry, margin, gap, radius_of(input_, pair));
      return;
    }
  }
  count_source(collide(lower, higher, in_lower, margin, manifold));
  if (manifold.count == 0 && bounded) {
    if (!meet_ahead(entry, margin, manifold.gap)) set_apart(entry, margin, manifold.gap, radius_of(input_, pair));
    return;
  }
  if (manifold.count > 0 && higher.kind == ShapeKind::Sphere && !contact.has_local_offset) {
    const Vector3 shift = first.orientation.conjugate() * shift_between(contact, input_);
    meet_at_impact(lower.radius, higher.radius, in_lower, shift, manifold);
  }
  manifold.reference_is_second ^= swap;
  const bool lower_is_reference = manifold.reference_is_second == swap;
  const Pose incident = lower_is_reference ? in_lower : swap ? relative(first, second) : relative(second, first);
  replace(entry, manifold, incident, margin);
}

void ManifoldRecomputer::fill_box_lane(const Contact& contact, std::size_t lane) {
  boxes_.half_first[lane] = input_.colliders.shape[contact.pair.first].half_extents.data();
  boxes_.half_second[lane] = input_.colliders.shape[contact.pair.second].half_extents.data();
  boxes_.position_first[lane] = input_.poses.positions + 3 * std::size_t{contact.body_first};
  boxes_.orientation_first[lane] = input_.poses.orientations + 4 * std::size_t{contact.body_first};
  boxes_.position_second[lane] = input_.poses.positions + 3 * std::size_t{contact.body_second};
  boxes_.orientation_second[lane] = input_.poses.orientations + 4 * std::size_t{contact.body_second};
  if (!contact.has_local_offset) return;
  first_[lane].set(contact.pair.first, input_);
  second_[lane].set(contact.pair.second, input_);
  boxes_.position_first[lane] = first_[lane].position.data();
  boxes_.orientation_first[lane] = first_[lane].orientation.data();
  boxes_.position_second[lane] = second_[lane].position.data();
  boxes_.orientation_second[lane] = second_[lane].orientation.data();
}

// Does the work of recompute() for the collected pairs of boxes, whose axes are found in lanes.
void ManifoldRecomputer::recompute_boxes() {
  const std::size_t count = std::exchange(box_pairs_.count, 0);
  if (count == 0) return;
  for (std::size_t lane = 0; lane < block_lanes; ++lane) {
    fill_box_lane(range_.contact(box_pairs_.entries[std::min(lane, count - 1)]), lane);
  }
  input_.kernels.find_box_axes(boxes_, box_axes_);
  for (std::size_t lane = 0; lane < count; ++lane) {
    const std::uint32_t entry = box_pairs_.entries[lane];
    const Contact& contact = range_.contact(entry);
    const double margin = margin_of(contact, input_);
    Manifold manifold = manifold_after_last(contact, false);
    const auto& shapes = input_.colliders.shape;
    count_source(collide_boxes(shapes[contact.pair.first].half_extents, shapes[contact.pair.second].half_extents,
                               box_axes_, lane, margin, manifold));
    if (manifold.count == 0) {
      if (!meet_ahead(entry, margin, manifold.gap)) {
        set_apart(entry, margin, manifold.gap, radius_of(input_, contact.pair));
      }
    } else {
      replace(entry, manifold, incident_in_reference(box_axes_, lane, manifold.reference_is_second), margin);
    }
    range_.record_points(entry);
  }
}

// Recomputes all manifolds of a solid and a surface. `entry` is that of the first part.
void ManifoldRecomputer::recompute_surface_parts(std::size_t entry) {
  const Contact& contact = range_.contact(entry);
  const Pair pair = contact.pair;
  const ColliderTable& colliders = input_.colliders;
  const bool surface_second = is_surface(colliders.shape[pair.second].kind);
  const std::uint32_t solid = surface_second ? pair.first : pair.second;
  const std::uint32_t surface = surface_second ? pair.second : pair.first;
  ATL_ASSERT(contact.part == 0, entry, contact.part);
  ATL_ASSERT(is_surface(colliders.shape[surface].kind), solid, surface,
             static_cast<int>(colliders.shape[surface].kind));
  const Pose incident = relative(colliders.pose(surface, input_.poses), colliders.pose(solid, input_.poses));
  const double margin = margin_of(contact, input_);
  SurfaceManifolds found;
  Vector3 shift = Vector3::Zero();
  if (colliders.shape[solid].kind == ShapeKind::Sphere) {
    const Vector3 shift_second = shift_between(contact, input_);
    shift = colliders.pose(surface, input_.poses).orientation.conjugate() *
            (surface_second ? Vector3(-shift_second) : shift_second);
  }
  const bool stands_still = input_.mobility[colliders.body[surface]] == 0;
  if (stands_still && (contact.gap > 0 || contact.margin < 0)) {
    const double radius = colliders.shape[solid].bounding_radius;
    const StepReach& reach = input_.reaches[colliders.body[solid]];
    const double ahead = ball_gap_steps * (shift_between(contact, input_).norm() + static_cast<double>(reach.turn));
    const double max = margin + std::clamp(ahead, min_ball_gap * radius, max_ball_gap * radius);
    const double gap = gap_of_ball(incident.position, radius, colliders.shape[surface], max);
    if (set_surface_apart(entry, margin, gap, ball_radius_part * radius)) return;
  }
  const double max_gap = stands_still ? margin + surface_gap_share * static_cast<double>(contact.size) : 0;
  collide_surface(colliders.shape[solid], colliders.shape[surface], incident, margin, found, shift, max_gap);
  if (found.count == 0 && stands_still && set_surface_apart(entry, margin, found.gap, radius_of(input_, pair))) return;

  const auto manifold_of =
      assign_to_parts(found, [&](std::size_t part) -> const Contact& { return range_.contact(entry + part); });
  for (std::size_t part = 0; part < surface_parts; ++part) {
    Manifold none;
    Manifold& manifold = manifold_of[part] < 0 ? none : found.manifolds[static_cast<std::size_t>(manifold_of[part])];
    manifold.reference_is_second = surface_second;
    replace(entry + part, manifold, incident, margin);
  }
}

}  // namespace atl::collision
