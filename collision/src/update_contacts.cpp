#include <collision/collide.h>
#include <collision/update_contacts.h>

#include <algorithm>

namespace atl::collision {
namespace {

// A pair may drift this part of the smaller shape's inner radius, or turn this far (rad), before its features
// are found anew. Separations stay exact for fixed features; what goes stale is where the outlines cross, by
// at most the drift. Chosen so that a resting scene keeps everything and a sliding box asks FCL every few
// millimetres.
constexpr double drift_tolerance = 2e-3;
constexpr double turn_tolerance = 2e-3;

// A new point that matches no old one by id takes over the impulse of one that lies this near, as part of the
// smaller shape's inner radius.
constexpr double match_distance = 0.04;

struct Motion {
  Eigen::Map<const Vector3> velocity;
  Eigen::Map<const Vector3> angular_velocity;

  Motion(const ContactUpdateInput& input, std::size_t shape)
      : velocity(input.velocities + 3 * shape), angular_velocity(input.angular_velocities + 3 * shape) {}

  // How far the surface gets in a step by turning. A half-space turns about its origin: not bounded here.
  double turn_reach(const Shape& shape, double dt) const {
    return shape.kind == ShapeKind::HalfSpace ? 0 : angular_velocity.norm() * shape.bounding_radius * dt;
  }
};

// Impulses of the old manifold, by what identifies their points.
struct OldPoints {
  int count;
  std::array<FeatureId, max_points> ids;
  std::array<float, max_points> impulses;
  std::array<Vector3, max_points> positions;  // reference frame
  bool reference_is_second;
};

OldPoints remember(const Contact& contact, const ContactManifold& manifold) {
  OldPoints old{contact.count, contact.ids, {}, {}, contact.reference_is_second};
  for (std::size_t i = 0; i < contact.count; ++i) {
    const std::array<float, 3>& offset = contact.offset[i];
    old.impulses[i] = manifold.normal_impulse[i];
    old.positions[i] = contact.centre_reference + Vector3(offset[0], offset[1], offset[2]);
  }
  return old;
}

// Hands impulses on: by feature id first, then, among what is left, to the nearest point within reach.
void match_points(const OldPoints& old, const Manifold& fresh, double reach, ContactManifold& manifold,
                  ContactUpdateCounts& counts) {
  std::array<bool, max_points> taken = {};
  std::array<bool, max_points> matched = {};
  for (std::size_t i = 0; i < max_points; ++i) manifold.normal_impulse[i] = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(fresh.count); ++i) {
    for (std::size_t j = 0; j < static_cast<std::size_t>(old.count); ++j) {
      if (taken[j] || old.ids[j] != fresh.points[i].id) continue;
      manifold.normal_impulse[i] = old.impulses[j];
      taken[j] = matched[i] = true;
      ++counts.id_matches;
      break;
    }
  }
  if (old.count == 0) return;
  for (std::size_t i = 0; i < static_cast<std::size_t>(fresh.count); ++i) {
    if (matched[i]) continue;
    ++counts.id_misses;
    if (old.reference_is_second != fresh.reference_is_second) continue;
    double nearest = reach * reach;
    std::size_t best = max_points;
    for (std::size_t j = 0; j < static_cast<std::size_t>(old.count); ++j) {
      const double distance = (old.positions[j] - fresh.points[i].position).squaredNorm();
      if (taken[j] || distance >= nearest) continue;
      nearest = distance;
      best = j;
    }
    if (best == max_points) continue;
    manifold.normal_impulse[i] = old.impulses[best];
    taken[best] = true;
  }
}

void clear_impulses(ContactManifold& manifold) {
  std::fill_n(manifold.normal_impulse, max_points, 0.0f);
  std::fill_n(manifold.friction_impulse, 3, 0.0f);
  manifold.twist_impulse = 0;
}

// Only where FCL's axis search is what costs is there anything to keep.
bool worth_keeping(const Shape& first, const Shape& second) {
  return first.kind == ShapeKind::Box && second.kind == ShapeKind::Box;
}

bool within_tolerance(const Drift& drift, double size) {
  const double turn_squared = static_cast<double>(drift.half_turn[0]) * drift.half_turn[0] +
                              static_cast<double>(drift.half_turn[1]) * drift.half_turn[1] +
                              static_cast<double>(drift.half_turn[2]) * drift.half_turn[2];
  return drift.shift.squaredNorm() < drift_tolerance * size * drift_tolerance * size &&
         turn_squared < 0.25 * turn_tolerance * turn_tolerance;
}

ContactStatus update_contact(Contact& contact, ContactManifold& manifold, const Broadphase& broadphase,
                             const ContactUpdateInput& input, ContactUpdateCounts& counts) {
  std::size_t first = contact.pair.first;
  std::size_t second = contact.pair.second;
  if (!input.active[first] && !input.active[second]) return ContactStatus::Idle;
  if ((broadphase.has_moved(contact.pair.first) || broadphase.has_moved(contact.pair.second)) &&
      !broadphase.overlap(contact.pair.first, contact.pair.second)) {
    return ContactStatus::Lost;
  }

  const Pose pose_first = input.poses[first];
  const Pose pose_second = input.poses[second];
  const Shape& shape_first = input.shapes[first];
  const Shape& shape_second = input.shapes[second];
  const double size = std::min(shape_first.inner_radius, shape_second.inner_radius);
  const Motion motion_first(input, first);
  const Motion motion_second(input, second);
  const double approach = (motion_first.velocity - motion_second.velocity).norm() * input.dt +
                          motion_first.turn_reach(shape_first, input.dt) +
                          motion_second.turn_reach(shape_second, input.dt);
  const double margin = speculative_margin(shape_first, shape_second, approach);

  // A pair found apart is kept as well: it stays apart, but for the tolerance, while it doesn't move.
  if (worth_keeping(shape_first, shape_second) && margin <= contact.margin + drift_tolerance * size) {
    const Pose incident =
        contact.reference_is_second ? relative(pose_second, pose_first) : relative(pose_first, pose_second);
    const Drift drift = drift_since_capture(contact, incident);
    if (within_tolerance(drift, size)) {
      ++counts.kept;
      if (contact.count == 0) return ContactStatus::Apart;
      place(contact, drift, pose_first, pose_second, margin, manifold);
      return ContactStatus::Touching;
    }
  }

  // The narrowphase wants the lower kind first.
  const bool swap = shape_second.kind < shape_first.kind;
  Manifold fresh;
  fresh.axis = contact.axis;
  const Narrowphase by = swap ? collide(shape_second, shape_first, relative(pose_second, pose_first), margin, fresh)
                              : collide(shape_first, shape_second, relative(pose_first, pose_second), margin, fresh);
  fresh.reference_is_second ^= swap;
  if (by == Narrowphase::Fcl) ++counts.fcl_calls;

  const OldPoints old = remember(contact, manifold);
  const Pose incident =
      fresh.reference_is_second ? relative(pose_second, pose_first) : relative(pose_first, pose_second);
  capture(contact, fresh, incident, margin);
  if (fresh.count == 0) {
    clear_impulses(manifold);
    return ContactStatus::Apart;
  }
  match_points(old, fresh, match_distance * size, manifold, counts);
  const Drift none{Vector3::Zero(), {0, 0, 0}, 1};
  place(contact, none, pose_first, pose_second, margin, manifold);
  return ContactStatus::Touching;
}

}  // namespace

ContactUpdateCounts& ContactUpdateCounts::operator+=(const ContactUpdateCounts& other) {
  fcl_calls += other.fcl_calls;
  kept += other.kept;
  id_matches += other.id_matches;
  id_misses += other.id_misses;
  return *this;
}

double speculative_margin(const Shape& a, const Shape& b, double approach) {
  // 5% of the inner radius is 2.5 cm for a cube of 1 m: a resting neighbour across a 2 cm gap is watched.
  const double size = std::min(a.inner_radius, b.inner_radius);
  return 0.05 * size + std::min(approach, 0.5 * size);
}

ContactUpdateCounts update_contacts(ContactCache& cache, const Broadphase& broadphase, const ContactUpdateInput& input,
                                    jobs::Arena& arena, std::vector<ContactStatus>& status) {
  constexpr std::size_t grain = 128;
  const std::size_t count = cache.order.size();
  status.resize(count);
  std::vector<ContactUpdateCounts> chunk_counts(jobs::Arena::chunk_count(count, grain));
  arena.parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
    ContactUpdateCounts counts;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t slot = cache.order[i];
      status[i] = update_contact(cache.contacts[slot], cache.manifolds[slot], broadphase, input, counts);
    }
    chunk_counts[begin / grain] = counts;
  });
  ContactUpdateCounts total;
  for (const ContactUpdateCounts& counts : chunk_counts) total += counts;
  return total;
}

}  // namespace atl::collision
