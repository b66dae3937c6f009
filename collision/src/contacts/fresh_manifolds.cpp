// The narrowphase of contacts whose manifolds are to be found anew.

#include <collision/contacts/match_points.h>
#include <collision/narrowphase/collide.h>
#include <collision/shapes/convex.h>
#include <jobs/with_meshes.h>

#include <algorithm>
#include <utility>

#include "contacts/contact_stretch.h"

namespace atl::collision {
namespace {

// A new point that matches no old one by id takes over the impulse of one that lies this near, as part of the
// smaller shape's inner radius.
constexpr double match_distance = 0.04;

// By the inner radius of a solid: how far around it triangles are looked for, where none touches it, so that it can be
// left alone for some steps; and how far off they have to be for that to be worth it.
constexpr double surface_gap_share = 1;
constexpr double least_surface_gap = 0.1;
// How far around the ball that a solid lies in they are looked for first: as far as it gets in some steps, in radii
// from the least to the most. And how far turning by 1 rad counts as bringing the ball nearer, in radii: it doesn't,
// but a surface that is turned by hand (put_elsewhere) has to show.
constexpr double ball_gap_steps = 4;
constexpr double least_ball_gap = 0.5;
constexpr double most_ball_gap = 1.2;
constexpr double ball_lever = 1e-3;
static_assert(ball_lever * put_elsewhere > most_ball_gap);

// Of the boxes of a lane.
Pose incident_in_reference(const BoxAxes& axes, std::size_t lane, bool reference_is_second) {
  const auto position = [&](std::size_t i) { return axes.position[i][lane]; };
  const auto turn = [&](std::size_t i) { return axes.orientation[i][lane]; };
  const Pose second{{position(0), position(1), position(2)}, {turn(3), turn(0), turn(1), turn(2)}};
  if (!reference_is_second) return second;
  return relative(second, {Vector3::Zero(), Quaternion::Identity()});
}

// A manifold that starts with what is known of the pair's last one. Two that were apart have none: what isn't in the
// first cache line of theirs isn't read.
Manifold after_last(const Contact& contact, bool swapped) {
  Manifold fresh;
  if (contact.gap > 0) return fresh;
  fresh.axis = contact.axis;
  fresh.known = contact.count > 0;
  if (!fresh.known) return fresh;
  fresh.reference_is_second = contact.reference_is_second != swapped;
  const auto& [x, y, z] = contact.normal;
  fresh.normal = Vector3(x, y, z).normalized();
  fresh.middle = Vector3(contact.centre_reference[0], contact.centre_reference[1], contact.centre_reference[2]);
  return fresh;
}

void clear_impulses(ContactManifold& manifold) {
  std::fill_n(manifold.normal_impulse, max_points, 0.0f);
  std::fill_n(manifold.friction_impulse, 3, 0.0f);
  manifold.twist_impulse = 0;
}

}  // namespace

bool ContactStretch::are_boxes(Pair pair) const {
  const auto& shapes = input_.colliders.shape;
  return shapes[pair.first].kind == ShapeKind::Box && shapes[pair.second].kind == ShapeKind::Box;
}

bool ContactStretch::has_surface(Pair pair) const {
  const auto& shapes = input_.colliders.shape;
  return is_surface(shapes[pair.first].kind) || is_surface(shapes[pair.second].kind);
}

void ContactStretch::find_stale() {
  for (std::size_t i = 0; i < stale_count_; ++i) {
    const std::uint32_t entry = stale_[i];
    // Parts are found together, by the first of them that is stale.
    if (status_[entry] != ContactStatus::Stale) continue;
    ++counts_.fresh;
    const Pair pair = contact_at(entry).pair;
    if (with_meshes && has_surface(pair)) {
      const std::size_t first = entry - contact_at(entry).part;
      find_surface_parts(first);
      for (std::size_t part = 0; part < max_surface_manifolds; ++part) note_points(first + part);
    } else if (are_boxes(pair)) {
      box_batch_.entries[box_batch_.count++] = entry;
      if (box_batch_.count == block_lanes) find_boxes();
    } else {
      find_anew(entry);
      note_points(entry);
    }
  }
  find_boxes();
}

// A sphere's contact is found in closed form faster than it could be kept.
float ContactStretch::tolerance_of(Pair pair, const Manifold& fresh) const {
  const auto is = [&](auto... kinds) {
    const ShapeKind first = input_.colliders.shape[pair.first].kind;
    const ShapeKind second = input_.colliders.shape[pair.second].kind;
    return ((first == kinds || second == kinds) || ...);
  };
  if (is(ShapeKind::Sphere)) return fresh.count > 0 ? 0 : flat_tolerance;
  const bool rolls = fresh.count < 3 && is(ShapeKind::Capsule, ShapeKind::Cylinder, ShapeKind::Cone);
  return rolls && fresh.count > 0 ? round_tolerance : flat_tolerance;
}

// Stores what the narrowphase found, and hands impulses on.
void ContactStretch::replace(std::size_t entry, const Manifold& fresh, const Pose& incident, double margin) {
  Contact& contact = contact_at(entry);
  ContactManifold& manifold = cache_.manifolds[cache_.order[entry]];
  if (fresh.count == 0) {
    clear_impulses(manifold);
  } else {
    const OldPoints old = OldPoints::of(contact, manifold);
    const PointMatches matches = match_points(old, fresh, match_distance * static_cast<double>(contact.size), manifold);
    counts_.id_matches += matches.by_id;
    counts_.id_misses += matches.missed;
  }
  if (!cache_.rises.empty()) cache_.rises[cache_.order[entry]] = static_cast<float>(fresh.rise);
  capture(contact, fresh, incident, margin, tolerance_of(contact.pair, fresh));
  status_[entry] = fresh.count > 0 ? ContactStatus::Touching : ContactStatus::Apart;
  if (fresh.count > 0) add_to(fresh_batch_, entry, true);
}

// m: no point of those of the two that may turn is farther from its shape's origin.
double ContactStretch::lever_of(Pair pair) const {
  const ColliderTable& colliders = input_.colliders;
  const auto lever = [&](std::uint32_t collider) {
    if (is_surface(colliders.shape[collider].kind) && input_.mobility[colliders.body[collider]] == 0) return 0.0;
    return colliders.shape[collider].bounding_radius;
  };
  return std::max(lever(pair.first), lever(pair.second));
}

// As set_apart(), of all parts of a solid and a surface that stands still. False where they are too near each other for
// that to last.
bool ContactStretch::set_surface_apart(std::size_t entry, double margin, double gap, double lever) {
  if (gap < margin + least_surface_gap * static_cast<double>(contact_at(entry).size)) return false;
  for (std::size_t part = 0; part < max_surface_manifolds; ++part) {
    set_apart(entry + part, margin, gap, lever);
    if (!cache_.rises.empty()) cache_.rises[cache_.order[entry + part]] = 0;
  }
  return true;
}

// Two solids found apart are left alone until they have used their gap up, or, where that hardly exceeds the margin,
// until they have moved by the tolerance. Of those that were apart before the first cache line is all that changes.
void ContactStretch::set_apart(std::size_t entry, double margin, double gap, double lever) {
  Contact& contact = contact_at(entry);
  if (!(contact.gap > 0)) {
    clear_impulses(cache_.manifolds[cache_.order[entry]]);
    capture(contact, Manifold{}, {Vector3::Zero(), Quaternion::Identity()}, margin, 0);
  }
  contact.lever = static_cast<float>(lever);
  const double size = static_cast<double>(contact.size);
  contact.gap = static_cast<float>(std::max(gap, margin + static_cast<double>(flat_tolerance) * size));
  Eigen::Map<Vector3>(contact.apart_from.data()) = origins_apart(contact);
  contact.turned = input_.turned[contact.body_first] + input_.turned[contact.body_second];
  status_[entry] = ContactStatus::Apart;
}

void ContactStretch::note_source(Narrowphase by) {
  counts_.fcl_calls += asks_fcl(by);
  counts_.fcl_repairs += by == Narrowphase::Repaired;
}

void ContactStretch::find_anew(std::size_t entry) {
  const Contact& contact = contact_at(entry);
  const Pair pair = contact.pair;
  const ColliderTable& colliders = input_.colliders;
  const Pose first = colliders.pose(pair.first, input_.poses);
  const Pose second = colliders.pose(pair.second, input_.poses);
  const double margin = margin_of(contact);

  // The narrowphase wants the lower kind first.
  const bool swap = colliders.shape[pair.second].kind < colliders.shape[pair.first].kind;
  const Shape& lower = colliders.shape[swap ? pair.second : pair.first];
  const Shape& higher = colliders.shape[swap ? pair.first : pair.second];
  const Pose in_lower = swap ? relative(second, first) : relative(first, second);
  const bool bounded = is_convex_solid(higher.kind);
  Manifold fresh = after_last(contact, swap);
  if (bounded && !fresh.known) {
    const double gap = centre_line(lower, {Vector3::Zero(), Quaternion::Identity()}, higher, in_lower).gap;
    if (gap > margin) {
      set_apart(entry, margin, gap, lever_of(pair));
      return;
    }
  }
  note_source(collide(lower, higher, in_lower, margin, fresh));
  if (fresh.count == 0 && bounded) {
    set_apart(entry, margin, fresh.gap, lever_of(pair));
    return;
  }
  if (fresh.count > 0 && higher.kind == ShapeKind::Sphere && !contact.placed) {
    meet_at_impact(lower.radius, higher.radius, in_lower, first.orientation.conjugate() * shift_between(contact),
                   fresh);
  }
  fresh.reference_is_second ^= swap;
  const bool lower_is_reference = fresh.reference_is_second == swap;
  const Pose incident = lower_is_reference ? in_lower : swap ? relative(first, second) : relative(second, first);
  replace(entry, fresh, incident, margin);
}

// What find_anew() does, of pairs of boxes: their axes are found in lanes.
void ContactStretch::find_boxes() {
  const std::size_t count = std::exchange(box_batch_.count, 0);
  if (count == 0) return;
  for (std::size_t lane = 0; lane < block_lanes; ++lane) {
    const Contact& contact = contact_at(box_batch_.entries[std::min(lane, count - 1)]);
    boxes_.half_first[lane] = input_.colliders.shape[contact.pair.first].half_extents.data();
    boxes_.half_second[lane] = input_.colliders.shape[contact.pair.second].half_extents.data();
    boxes_.position_first[lane] = input_.poses.positions + 3 * std::size_t{contact.body_first};
    boxes_.orientation_first[lane] = input_.poses.orientations + 4 * std::size_t{contact.body_first};
    boxes_.position_second[lane] = input_.poses.positions + 3 * std::size_t{contact.body_second};
    boxes_.orientation_second[lane] = input_.poses.orientations + 4 * std::size_t{contact.body_second};
    if (!contact.placed) continue;
    place(contact.pair.first, placed_reference_[lane]);
    place(contact.pair.second, placed_incident_[lane]);
    boxes_.position_first[lane] = placed_reference_[lane].position.data();
    boxes_.orientation_first[lane] = placed_reference_[lane].orientation.data();
    boxes_.position_second[lane] = placed_incident_[lane].position.data();
    boxes_.orientation_second[lane] = placed_incident_[lane].orientation.data();
  }
  input_.kernels.find_box_axes(boxes_, box_axes_);
  for (std::size_t lane = 0; lane < count; ++lane) {
    const std::uint32_t entry = box_batch_.entries[lane];
    const Contact& contact = contact_at(entry);
    const double margin = margin_of(contact);
    Manifold fresh = after_last(contact, false);
    note_source(collide_boxes(input_.colliders.shape[contact.pair.first].half_extents,
                              input_.colliders.shape[contact.pair.second].half_extents, box_axes_, lane, margin,
                              fresh));
    if (fresh.count == 0) {
      set_apart(entry, margin, fresh.gap, lever_of(contact.pair));
    } else {
      replace(entry, fresh, incident_in_reference(box_axes_, lane, fresh.reference_is_second), margin);
    }
    note_points(entry);
  }
}

// The manifolds of a solid and a surface go to the parts that had the most similar normals.
void ContactStretch::find_surface_parts(std::size_t entry) {
  const Contact& contact = contact_at(entry);
  const Pair pair = contact.pair;
  const ColliderTable& colliders = input_.colliders;
  const bool surface_second = is_surface(colliders.shape[pair.second].kind);
  const std::uint32_t solid = surface_second ? pair.first : pair.second;
  const std::uint32_t surface = surface_second ? pair.second : pair.first;
  const Pose incident = relative(colliders.pose(surface, input_.poses), colliders.pose(solid, input_.poses));
  const double margin = margin_of(contact);
  SurfaceManifolds found;
  Vector3 shift = Vector3::Zero();
  if (is_smooth(colliders.shape[surface])) {
    const Vector3 shift_second = shift_between(contact);
    shift = colliders.pose(surface, input_.poses).orientation.conjugate() *
            (surface_second ? Vector3(-shift_second) : shift_second);
  }
  const bool stands_still = input_.mobility[colliders.body[surface]] == 0;
  if (stands_still && (contact.gap > 0 || contact.margin < 0)) {
    const double radius = colliders.shape[solid].bounding_radius;
    const StepReach& reach = input_.reaches[colliders.body[solid]];
    const double ahead = ball_gap_steps * (shift_between(contact).norm() + static_cast<double>(reach.turn));
    const double most = margin + std::clamp(ahead, least_ball_gap * radius, most_ball_gap * radius);
    const double gap = gap_of_ball(incident.position, radius, colliders.shape[surface], most);
    if (set_surface_apart(entry, margin, gap, ball_lever * radius)) return;
  }
  const double most_gap = stands_still ? margin + surface_gap_share * static_cast<double>(contact.size) : 0;
  collide_surface(colliders.shape[solid], colliders.shape[surface], incident, margin, found, shift, most_gap);
  if (found.count == 0 && stands_still && set_surface_apart(entry, margin, found.gap, lever_of(pair))) return;

  constexpr auto parts = static_cast<std::size_t>(max_surface_manifolds);
  std::array<int, parts> assigned;  // manifold of a part, or -1
  assigned.fill(-1);
  std::array<bool, parts> placed = {};
  const auto assign_best = [&](double least_cosine) {
    for (int m = 0; m < found.count; ++m) {
      if (placed[static_cast<std::size_t>(m)]) continue;
      double best = least_cosine;
      std::size_t chosen = parts;
      for (std::size_t part = 0; part < parts; ++part) {
        if (assigned[part] >= 0) continue;
        const Contact& old = contact_at(entry + part);
        const Vector3 normal(old.normal[0], old.normal[1], old.normal[2]);
        const double cosine = old.count > 0 ? normal.dot(found.manifolds[static_cast<std::size_t>(m)].normal) : -1.0;
        if (cosine < best || (chosen != parts && cosine == best)) continue;
        best = cosine;
        chosen = part;
      }
      if (chosen == parts) continue;
      assigned[chosen] = m;
      placed[static_cast<std::size_t>(m)] = true;
    }
  };
  assign_best(0.9);   // the same face as before
  assign_best(-2.0);  // whatever is left

  for (std::size_t part = 0; part < parts; ++part) {
    Manifold none;
    none.reference_is_second = surface_second;
    Manifold& fresh = assigned[part] < 0 ? none : found.manifolds[static_cast<std::size_t>(assigned[part])];
    fresh.reference_is_second = surface_second;
    replace(entry + part, fresh, incident, margin);
  }
}

}  // namespace atl::collision
