#include <collision/collide.h>
#include <collision/convex.h>
#include <collision/match_points.h>
#include <collision/surface_contacts.h>
#include <collision/update_contacts.h>
#include <jobs/prefetch.h>
#include <jobs/with_meshes.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace atl::collision {
namespace {

// A new point that matches no old one by id takes over the impulse of one that lies this near, as part of the
// smaller shape's inner radius.
constexpr double match_distance = 0.04;

// Faster than any body: for the largest margin.
constexpr double any_approach = std::numeric_limits<double>::infinity();

// Contacts of one loop chunk; they are refreshed in blocks of lanes.
constexpr std::size_t grain = 128;
// A chunk and the rest of its last pair's parts.
constexpr std::size_t longest_stretch = grain + max_surface_manifolds;

// Pose of a shape that isn't its body's, for a lane of a block.
struct alignas(16) PlacedLane {
  std::array<float, 4> offset = {};
  std::array<double, 4> orientation;
  std::array<double, 3> position;
};
alignas(16) constexpr std::array<float, 4> no_offset = {};

// The update of a stretch of the cache's order, on one thread.
class Stretch {
 public:
  Stretch(ContactCache& cache, const Broadphase& broadphase, const ContactUpdateInput& input)
      : cache_(cache), broadphase_(broadphase), input_(input) {}

  // Writes those that touch to `touching`, over those of the last update.
  struct Result {
    ContactUpdateCounts counts;
    std::size_t touching = 0;
    bool changed = false;  // what touches, up to their number
  };
  Result run(std::size_t begin, std::size_t end, ContactStatus* status, std::span<TouchingPair> touching);
  void place(std::span<const std::uint32_t> slots);

 private:
  // Entries of the order, collected for refresh() until they fill a block.
  struct Batch {
    std::array<std::uint32_t, block_lanes> entries;
    std::size_t count = 0;
  };

  bool is_lost(Pair pair) const;
  void list_touching(std::size_t begin, std::size_t end, std::span<TouchingPair> touching, Result& result);
  void add_to(Batch& batch, std::size_t entry, bool fresh);
  void refresh(Batch& batch, bool fresh);
  template <typename SlotOf>
  void fill_block(std::size_t count, const SlotOf& slot_of);
  void fill_lane(const Contact& contact, ContactManifold& manifold, std::size_t lane);
  void find_anew(std::size_t entry);
  void find_boxes();
  void place(std::uint32_t collider, PlacedLane& lane) const;
  bool are_boxes(Pair pair) const {
    return input_.colliders.shape[pair.first].kind == ShapeKind::Box &&
           input_.colliders.shape[pair.second].kind == ShapeKind::Box;
  }
  void set_apart(std::size_t entry, double margin, double gap);
  bool still_apart(const Contact& contact) const;
  void fetch_ahead(std::size_t entry) const;
  void fetch_rest(std::uint32_t slot) const;
  void find_surface_parts(std::size_t entry);
  void replace(std::size_t entry, const Manifold& fresh, const Pose& incident, double margin);
  Vector3 shift_between(const Contact& contact) const;
  double margin_of(const Contact& contact) const;
  float tolerance_of(Pair pair, const Manifold& fresh) const;

  void note_points(std::size_t entry) { points_[entry - begin_] = contact_at(entry).count; }
  Contact& contact_at(std::size_t entry) { return cache_.contacts[cache_.order[entry]]; }
  std::size_t parts_from(std::size_t entry) const;

  ContactCache& cache_;
  const Broadphase& broadphase_;
  const ContactUpdateInput& input_;
  ContactStatus* status_ = nullptr;
  ContactUpdateCounts counts_;
  RefreshBlock block_;
  std::array<PlacedLane, block_lanes> placed_reference_;
  std::array<PlacedLane, block_lanes> placed_incident_;
  Batch kept_batch_;
  Batch fresh_batch_;
  Batch box_batch_;  // pairs of boxes to be found anew
  BoxBlock boxes_;
  BoxAxes box_axes_;
  std::array<std::uint32_t, longest_stretch> stale_;
  // Of the entries from begin_ on: noted as they pass, since to come back to all contacts costs more.
  std::size_t begin_ = 0;
  std::array<TouchingPair, longest_stretch> pairs_;
  std::array<std::uint8_t, longest_stretch> points_;
  std::size_t stale_count_ = 0;
};

// m, of the second body against the first in this step.
Vector3 Stretch::shift_between(const Contact& contact) const {
  const float(&first)[3] = input_.reaches[contact.body_first].shift;
  const float(&second)[3] = input_.reaches[contact.body_second].shift;
  return {second[0] - first[0], second[1] - first[1], second[2] - first[2]};
}

double Stretch::margin_of(const Contact& contact) const {
  const float turn = input_.reaches[contact.body_first].turn + input_.reaches[contact.body_second].turn;
  return speculative_margin(static_cast<double>(contact.size),
                            shift_between(contact).norm() + static_cast<double>(turn));
}

bool Stretch::is_lost(Pair pair) const {
  return (broadphase_.has_moved(pair.first) || broadphase_.has_moved(pair.second)) &&
         !broadphase_.overlap(pair.first, pair.second);
}

std::size_t Stretch::parts_from(std::size_t entry) const {
  std::size_t end = entry + 1;
  while (end < cache_.order.size() && cache_.contacts[cache_.order[end]].part > 0) ++end;
  return end - entry;
}

Stretch::Result Stretch::run(std::size_t begin, std::size_t end, ContactStatus* status,
                             std::span<TouchingPair> touching) {
  status_ = status;
  stale_count_ = 0;
  // A pair's parts stay together: they belong to the chunk in which they begin.
  while (begin < end && contact_at(begin).part > 0) ++begin;
  if (begin < end) end += parts_from(end - 1) - 1;

  begin_ = begin;
  for (std::size_t i = begin; i < end; ++i) {
    const Contact& contact = contact_at(i);
    pairs_[i - begin] = {contact.body_first, contact.body_second, cache_.order[i]};
    if (is_lost(contact.pair)) {
      status_[i] = ContactStatus::Lost;
      ++counts_.lost;
    } else {
      add_to(kept_batch_, i, false);
    }
  }
  refresh(kept_batch_, false);

  for (std::size_t i = 0; i < stale_count_; ++i) {
    const std::uint32_t entry = stale_[i];
    // Parts are found together, by the first of them that is stale.
    if (status_[entry] != ContactStatus::Stale) continue;
    ++counts_.fresh;
    if (with_meshes && (is_surface(input_.colliders.shape[contact_at(entry).pair.first].kind) ||
                        is_surface(input_.colliders.shape[contact_at(entry).pair.second].kind))) {
      const std::size_t first = entry - contact_at(entry).part;
      find_surface_parts(first);
      for (std::size_t part = 0; part < max_surface_manifolds; ++part) note_points(first + part);
    } else if (are_boxes(contact_at(entry).pair)) {
      box_batch_.entries[box_batch_.count++] = entry;
      if (box_batch_.count == block_lanes) find_boxes();
    } else {
      find_anew(entry);
      note_points(entry);
    }
  }
  find_boxes();
  refresh(fresh_batch_, true);

  Result result;
  list_touching(begin, end, touching, result);
  result.counts = std::exchange(counts_, {});
  return result;
}

void Stretch::list_touching(std::size_t begin, std::size_t end, std::span<TouchingPair> touching, Result& result) {
  std::size_t listed = 0;
  std::uint32_t difference = 0;
  std::int64_t points = 0;
  for (std::size_t i = 0; i < end - begin; ++i) {
    if (status_[begin + i] != ContactStatus::Touching) continue;
    const TouchingPair pair = pairs_[i];
    if (!input_.dynamic[pair.first] && !input_.dynamic[pair.second]) continue;
    TouchingPair& place = touching[listed++];
    difference |= (pair.first ^ place.first) | (pair.second ^ place.second) | (pair.slot ^ place.slot);
    place = pair;
    points += points_[i];
  }
  result.touching = listed;
  result.changed = difference != 0;
  counts_.points += points;
}

void Stretch::add_to(Batch& batch, std::size_t entry, bool fresh) {
  if (!fresh) {
    fetch_ahead(entry);
    if (const Contact& contact = contact_at(entry); contact.gap > 0) {
      if (still_apart(contact)) {
        status_[entry] = ContactStatus::Apart;
        ++counts_.kept;
      } else {
        status_[entry] = ContactStatus::Stale;
        stale_[stale_count_++] = static_cast<std::uint32_t>(entry);
      }
      return;
    }
  }
  fetch_rest(cache_.order[entry]);
  batch.entries[batch.count++] = static_cast<std::uint32_t>(entry);
  if (batch.count == block_lanes) refresh(batch, fresh);
}

// What a refresh reads beside the first line of a contact, while its batch fills.
void Stretch::fetch_rest(std::uint32_t slot) const {
  jobs::prefetch(cache_.contacts[slot], jobs::cache_line);
  jobs::prefetch(cache_.manifolds[slot]);
}

// Slots are in no order: what is needed soon is asked of memory now.
void Stretch::fetch_ahead(std::size_t entry) const {
  constexpr std::size_t ahead = 16;
  if (entry + ahead < cache_.order.size()) __builtin_prefetch(&cache_.contacts[cache_.order[entry + ahead]]);
}

// Whether two solids that were found apart are so still, whatever their features: by how far the centres have moved
// against each other since, and how much the bodies have turned.
bool Stretch::still_apart(const Contact& contact) const {
  const Eigen::Map<const Vector3> first(input_.poses.positions + 3 * std::size_t{contact.body_first});
  const Eigen::Map<const Vector3> second(input_.poses.positions + 3 * std::size_t{contact.body_second});
  const Eigen::Map<const Vector3> from(contact.apart_from.data());
  const double moved = (second - first - from).norm();
  const double turned = input_.turned[contact.body_first] + input_.turned[contact.body_second] - contact.turned;
  const double left = static_cast<double>(contact.gap) - moved - static_cast<double>(contact.lever) * turned;
  return left > speculative_margin(static_cast<double>(contact.size), any_approach) || left > margin_of(contact);
}

void Stretch::refresh(Batch& batch, bool fresh) {
  const std::size_t count = std::exchange(batch.count, 0);
  if (count == 0) return;
  fill_block(count, [&](std::size_t lane) { return cache_.order[batch.entries[lane]]; });
  const unsigned kept = input_.kernels.refresh(block_, count, fresh);
  if (fresh) return;
  for (std::size_t lane = 0; lane < count; ++lane) {
    const std::uint32_t entry = batch.entries[lane];
    if ((kept >> lane & 1) != 0) {
      // A pair found apart is kept as well: it stays apart, but for the tolerance, while it doesn't move.
      note_points(entry);
      status_[entry] = contact_at(entry).count > 0 ? ContactStatus::Touching : ContactStatus::Apart;
      counts_.kept += contact_at(entry).part == 0;
    } else {
      status_[entry] = ContactStatus::Stale;
      stale_[stale_count_++] = entry;
    }
  }
}

// By lane: slot_of(lane) of the first `count`.
template <typename SlotOf>
void Stretch::fill_block(std::size_t count, const SlotOf& slot_of) {
  for (std::size_t lane = 0; lane < block_lanes; ++lane) {
    const std::uint32_t slot = slot_of(std::min(lane, count - 1));
    fill_lane(cache_.contacts[slot], cache_.manifolds[slot], lane);
  }
}

void Stretch::place(std::span<const std::uint32_t> slots) {
  for (std::size_t begin = 0; begin < slots.size(); begin += block_lanes) {
    const std::span<const std::uint32_t> after = slots.subspan(std::min(begin + block_lanes, slots.size()));
    for (const std::uint32_t slot : after.first(std::min(block_lanes, after.size()))) {
      jobs::prefetch(cache_.contacts[slot]);
      jobs::prefetch(cache_.manifolds[slot]);
    }
    const std::size_t count = std::min(block_lanes, slots.size() - begin);
    fill_block(count, [&](std::size_t lane) { return slots[begin + lane]; });
    input_.kernels.refresh(block_, count, true);
  }
}

void Stretch::place(std::uint32_t collider, PlacedLane& lane) const {
  const Pose pose = input_.colliders.pose(collider, input_.poses);
  const Vector3 offset = pose.position - input_.poses[input_.colliders.body[collider]].position;
  Eigen::Map<Vector3>(lane.position.data()) = pose.position;
  Eigen::Map<Eigen::Vector4d>(lane.orientation.data()) = pose.orientation.coeffs();
  Eigen::Map<Eigen::Vector3f>(lane.offset.data()) = offset.cast<float>();
}

void Stretch::fill_lane(const Contact& contact, ContactManifold& manifold, std::size_t lane) {
  block_.contact[lane] = &contact;
  block_.manifold[lane] = &manifold;
  block_.reach_first[lane] = &input_.reaches[contact.body_first];
  block_.reach_second[lane] = &input_.reaches[contact.body_second];

  const bool swapped = contact.reference_is_second;
  const std::size_t reference = swapped ? contact.body_second : contact.body_first;
  const std::size_t incident = swapped ? contact.body_first : contact.body_second;
  block_.position_reference[lane] = input_.poses.positions + 3 * reference;
  block_.orientation_reference[lane] = input_.poses.orientations + 4 * reference;
  block_.position_incident[lane] = input_.poses.positions + 3 * incident;
  block_.orientation_incident[lane] = input_.poses.orientations + 4 * incident;
  block_.offset_reference[lane] = block_.offset_incident[lane] = no_offset.data();
  if (!contact.placed) return;

  PlacedLane& at_reference = placed_reference_[lane];
  PlacedLane& at_incident = placed_incident_[lane];
  place(swapped ? contact.pair.second : contact.pair.first, at_reference);
  place(swapped ? contact.pair.first : contact.pair.second, at_incident);
  block_.position_reference[lane] = at_reference.position.data();
  block_.orientation_reference[lane] = at_reference.orientation.data();
  block_.offset_reference[lane] = at_reference.offset.data();
  block_.position_incident[lane] = at_incident.position.data();
  block_.orientation_incident[lane] = at_incident.orientation.data();
  block_.offset_incident[lane] = at_incident.offset.data();
}

// Of the boxes of a lane.
Pose incident_in_reference(const BoxAxes& axes, std::size_t lane, bool reference_is_second) {
  const auto position = [&](std::size_t i) { return axes.position[i][lane]; };
  const auto turn = [&](std::size_t i) { return axes.orientation[i][lane]; };
  const Pose second{{position(0), position(1), position(2)}, {turn(3), turn(0), turn(1), turn(2)}};
  if (!reference_is_second) return second;
  return relative(second, {Vector3::Zero(), Quaternion::Identity()});
}

void clear_impulses(ContactManifold& manifold) {
  std::fill_n(manifold.normal_impulse, max_points, 0.0f);
  std::fill_n(manifold.friction_impulse, 3, 0.0f);
  manifold.twist_impulse = 0;
}

// A sphere's contact is found in closed form faster than it could be kept.
float Stretch::tolerance_of(Pair pair, const Manifold& fresh) const {
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
void Stretch::replace(std::size_t entry, const Manifold& fresh, const Pose& incident, double margin) {
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
  capture(contact, fresh, incident, margin, tolerance_of(contact.pair, fresh));
  status_[entry] = fresh.count > 0 ? ContactStatus::Touching : ContactStatus::Apart;
  if (fresh.count > 0) add_to(fresh_batch_, entry, true);
}

// Two solids found apart are left alone until they have used their gap up, or, where that hardly exceeds the margin,
// until they have moved by the tolerance.
void Stretch::set_apart(std::size_t entry, double margin, double gap) {
  Contact& contact = contact_at(entry);
  const ColliderTable& colliders = input_.colliders;
  clear_impulses(cache_.manifolds[cache_.order[entry]]);
  capture(contact, Manifold{}, {Vector3::Zero(), Quaternion::Identity()}, margin, 0);
  const auto lever = [&](std::uint32_t collider) {
    return colliders.local[collider].position.norm() + colliders.shape[collider].bounding_radius;
  };
  const double size = static_cast<double>(contact.size);
  contact.gap = static_cast<float>(std::max(gap, margin + static_cast<double>(flat_tolerance) * size));
  contact.lever = static_cast<float>(std::max(lever(contact.pair.first), lever(contact.pair.second)));
  const Vector3 between = input_.poses[contact.body_second].position - input_.poses[contact.body_first].position;
  Eigen::Map<Vector3>(contact.apart_from.data()) = between;
  contact.turned = input_.turned[contact.body_first] + input_.turned[contact.body_second];
  status_[entry] = ContactStatus::Apart;
}

void Stretch::find_anew(std::size_t entry) {
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
  if (bounded) {
    const double gap = centre_line(lower, {Vector3::Zero(), Quaternion::Identity()}, higher, in_lower).gap;
    if (gap > margin) {
      set_apart(entry, margin, gap);
      return;
    }
  }
  Manifold fresh;
  fresh.axis = contact.axis;
  const Narrowphase by = collide(lower, higher, in_lower, margin, fresh);
  if (fresh.count == 0 && bounded) {
    counts_.fcl_calls += by == Narrowphase::Fcl;
    set_apart(entry, margin, fresh.gap);
    return;
  }
  if (fresh.count > 0 && higher.kind == ShapeKind::Sphere && !contact.placed) {
    meet_at_impact(lower.radius, higher.radius, in_lower, first.orientation.conjugate() * shift_between(contact),
                   fresh);
  }
  fresh.reference_is_second ^= swap;
  counts_.fcl_calls += by == Narrowphase::Fcl;
  const bool lower_is_reference = fresh.reference_is_second == swap;
  const Pose incident = lower_is_reference ? in_lower : swap ? relative(first, second) : relative(second, first);
  replace(entry, fresh, incident, margin);
}

// What find_anew() does, of pairs of boxes: their axes are found in lanes.
void Stretch::find_boxes() {
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
    Manifold fresh;
    fresh.axis = contact.axis;
    counts_.fcl_calls +=
        collide_boxes(input_.colliders.shape[contact.pair.first].half_extents,
                      input_.colliders.shape[contact.pair.second].half_extents, box_axes_, lane, margin, fresh);
    if (fresh.count == 0) {
      set_apart(entry, margin, fresh.gap);
    } else {
      replace(entry, fresh, incident_in_reference(box_axes_, lane, fresh.reference_is_second), margin);
    }
    note_points(entry);
  }
}

// The manifolds of a solid and a surface go to the parts that had the most similar normals.
void Stretch::find_surface_parts(std::size_t entry) {
  const Contact& contact = contact_at(entry);
  const Pair pair = contact.pair;
  const ColliderTable& colliders = input_.colliders;
  const bool surface_second = is_surface(colliders.shape[pair.second].kind);
  const std::uint32_t solid = surface_second ? pair.first : pair.second;
  const std::uint32_t surface = surface_second ? pair.second : pair.first;
  const Pose incident = relative(colliders.pose(surface, input_.poses), colliders.pose(solid, input_.poses));
  const double margin = margin_of(contact);
  SurfaceManifolds found;
  collide_surface(colliders.shape[solid], colliders.shape[surface], incident, margin, found);

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

}  // namespace

ContactUpdateCounts& ContactUpdateCounts::operator+=(const ContactUpdateCounts& other) {
  kept += other.kept;
  fresh += other.fresh;
  fcl_calls += other.fcl_calls;
  id_matches += other.id_matches;
  id_misses += other.id_misses;
  points += other.points;
  lost += other.lost;
  return *this;
}

// The chunks' lists, one after another.
void ContactUpdate::collect_touching(jobs::Arena& arena) {
  std::size_t total = 0;
  for (Chunk& chunk : chunks_) {
    chunk.offset = total;
    total += chunk.touching;
  }
  touching.resize(total);
  constexpr std::size_t chunks_at_once = 16;
  arena.parallel_for(chunks_.size(), chunks_at_once, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::copy_n(by_chunk_.data() + i * longest_stretch, chunks_[i].touching, touching.data() + chunks_[i].offset);
    }
  });
}

void ContactUpdate::forget() {
  touching.clear();
  chunks_.clear();
  added_to_ = true;
}

void ContactUpdate::add_touching(const ContactCache& cache, std::span<const std::uint32_t> slots) {
  const auto updated = static_cast<std::ptrdiff_t>(touching.size());
  for (const std::uint32_t slot : slots) {
    const Contact& contact = cache.contacts[slot];
    if (contact.count == 0) continue;
    touching.push_back({contact.body_first, contact.body_second, slot});
    counts.points += contact.count;
    added_to_ = touching_changed = true;
  }
  // No pair is in both parts, and of a pair the contacts are in order.
  std::inplace_merge(touching.begin(), touching.begin() + updated, touching.end(),
                     [&cache](const TouchingPair& a, const TouchingPair& b) {
                       return cache.contacts[a.slot].pair < cache.contacts[b.slot].pair;
                     });
}

void update_contacts(ContactCache& cache, const Broadphase& broadphase, const ContactUpdateInput& input,
                     jobs::Arena& arena, ContactUpdate& update) {
  const std::size_t count = cache.order.size();
  const std::size_t chunk_count = jobs::Arena::chunk_count(count, grain);
  update.touching_changed = update.added_to_ || update.chunks_.size() != chunk_count;
  update.added_to_ = false;
  update.status.resize(count);
  update.chunks_.resize(chunk_count);
  update.by_chunk_.resize(std::max(update.by_chunk_.size(), chunk_count * longest_stretch));
  arena.parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
    ContactUpdate::Chunk& chunk = update.chunks_[begin / grain];
    const std::span<TouchingPair> place =
        std::span(update.by_chunk_).subspan(begin / grain * longest_stretch, longest_stretch);
    Stretch stretch(cache, broadphase, input);
    const Stretch::Result result = stretch.run(begin, end, update.status.data(), place);
    chunk.changed = result.changed || result.touching != chunk.touching;
    chunk.touching = result.touching;
    chunk.counts = result.counts;
  });
  update.counts = {};
  for (const ContactUpdate::Chunk& chunk : update.chunks_) {
    update.counts += chunk.counts;
    update.touching_changed |= chunk.changed;
  }
  if (update.touching_changed) update.collect_touching(arena);
}

void place_contacts(ContactCache& cache, const Broadphase& broadphase, const ContactUpdateInput& input,
                    std::span<const std::uint32_t> slots, jobs::Arena& arena) {
  arena.parallel_for(slots.size(), grain, [&](std::size_t begin, std::size_t end) {
    Stretch(cache, broadphase, input).place(slots.subspan(begin, end - begin));
  });
}

}  // namespace atl::collision
