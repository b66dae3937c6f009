// What is near a fast body. All that touches its fat boxes is paired with it already, so the boxes' tree is asked for
// the few only that left theirs.

#include <collision/shapes/aabb.h>

#include <algorithm>
#include <numeric>
#include <span>

#include "world_impl.h"

namespace atl {
namespace {

constexpr std::size_t grain = 16;  // of loops over fast bodies

// Whether a box holds bounds, beyond the rounding of these.
bool holds(const collision::Aabb& box, const Vector3& lower, const Vector3& upper) {
  const double slack = 1e-12 * (lower.cwiseAbs().maxCoeff() + upper.cwiseAbs().maxCoeff());
  bool inside = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    inside &= static_cast<double>(box.lower[i]) <= lower[axis] - slack &&
              upper[axis] + slack <= static_cast<double>(box.upper[i]);
  }
  return inside;
}

}  // namespace

// Everywhere that a collider of the body has been in this step, if it ends `aside` of where it did.
collision::Aabb World::Impl::swept_box(const FastMove& fast, std::uint32_t collider, const Vector3& aside) const {
  const collision::Bounds start = bounds_at(collider, collision::placed(fast.start_pose(), colliders.local[collider]));
  const collision::Bounds end = bounds_now(collider);
  const Vector3 bulge = Vector3::Constant(fast.bulge);
  return collision::Aabb::around(start.lower.cwiseMin(end.lower + aside) - bulge,
                                 start.upper.cwiseMax(end.upper + aside) + bulge);
}

// Whether a collider has been in its fat box in all of this step. The balls around it at both ends tell that of most,
// for less than their boxes.
bool World::Impl::stayed_in_box(const FastMove& fast, std::uint32_t collider) const {
  const collision::Aabb& fat = broadphase.fat_box(collider);
  const collision::PoseView poses{bodies.positions.data(), bodies.orientations.data()};
  const Vector3& at = colliders.local[collider].position;
  const Vector3 start = fast.start.position + fast.start.orientation * at;
  const Vector3 end = poses[fast.body].position + poses[fast.body].orientation * at;
  const Vector3 around = Vector3::Constant(colliders.shape[collider].bounding_radius + fast.bulge);
  if (holds(fat, start.cwiseMin(end) - around, start.cwiseMax(end) + around)) return true;
  return fat.contains(swept_box(fast, collider, Vector3::Zero()));
}

// For fast bodies to find each other their boxes must show where they went, as those that were stretched along the
// motion do. All are seen as the solver moved them, before any is put back.
void World::Impl::note_rushed() {
  // Where few are fast, to go through all contacts takes longer than to ask the tree.
  constexpr std::size_t few = 16;
  const bool queried = few * fast_in_order_.size() < active_.in_order().size();
  arena.parallel_for(fast_in_order_.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (FastMove& fast : std::span(fast_in_order_).subspan(begin, end - begin)) {
      if (!is_finite(fast.body)) continue;
      fast.queried = queried;
      for_each_collider(fast.body, [&](std::uint32_t collider) {
        if (fast.rushed || stayed_in_box(fast, collider)) return;
        fast.rushed = fast.queried = true;
      });
    }
  });
  for (const FastMove& fast : fast_in_order_) {
    if (!fast.rushed) continue;
    for_each_collider(fast.body, [&](std::uint32_t collider) {
      broadphase.move_box(collider, swept_box(fast, collider, Vector3::Zero()));
    });
  }
}

// Whether two shapes can't meet in this step, by what is known of them: they come near each other by so little that the
// speculative margin has seen it coming; or they were found apart, and what they have moved since is less. The origins
// of shapes move on a line, straight but for the bulge of those that their body turns, of which an end is farthest from
// where they were then.
bool World::Impl::stay_apart(const collision::Contact& contact, const FastMove* first, const FastMove* second) const {
  const auto shift_of = [](const FastMove* fast) -> Vector3 { return fast ? fast->shift : Vector3::Zero(); };
  const Vector3 shift = shift_of(second) - shift_of(first);
  const double size = contact.size;
  const double closing = shift.norm() + (first ? first->turn : 0) + (second ? second->turn : 0);
  if (closing <= collision::approach_share * size) return true;
  if (!(contact.gap > 0)) return false;

  const collision::PoseView poses{bodies.positions.data(), bodies.orientations.data()};
  const Eigen::Map<const Vector3> from(contact.apart_from.data());
  const auto [own, other] = contact.pair;
  double bulge = 0;
  const auto at_start = [&](std::uint32_t collider, const FastMove* fast) -> Vector3 {
    if (!fast) return colliders.position(collider, poses);
    if (colliders.placed[collider]) bulge += fast->bulge;
    return fast->start.position + fast->start.orientation * colliders.local[collider].position;
  };
  const Vector3 start = at_start(other, second) - at_start(own, first) - from;
  const Vector3 end = colliders.position(other, poses) - colliders.position(own, poses) - from;
  const double moved = std::sqrt(std::max(start.squaredNorm(), end.squaredNorm())) + bulge;
  const double turned = bodies.turned[contact.body_first] + bodies.turned[contact.body_second] - contact.turned;
  const double left = static_cast<double>(contact.gap) - moved - static_cast<double>(contact.lever) * turned;
  return left > (stop_share + sweep_tolerance) * size;
}

// What fast bodies may meet of that which they have contacts with, touching or not, of some entries of their order.
void World::Impl::find_near_by_contacts(std::size_t begin, std::size_t end, FastSweep& scratch) const {
  scratch.contacts.clear();
  const auto is_first = [&](std::size_t entry) {  // of a pair's parts
    return entry == 0 || cache.pair_at(entry - 1) != cache.pair_at(entry);
  };
  for (std::size_t entry = begin; entry < end; ++entry) {
    const collision::Pair pair = cache.pair_at(entry);
    const std::uint32_t first = fast_place_[colliders.body[pair.first]];
    const std::uint32_t second = fast_place_[colliders.body[pair.second]];
    if ((first | second) == 0 || !is_first(entry)) continue;
    // The first line of it is all that is read.
    __builtin_prefetch(&cache.contacts[cache.order[entry]]);
    scratch.contacts.push_back({static_cast<std::uint32_t>(entry), first, second});
  }
  const auto fast = [this](std::uint32_t place) { return place == 0 ? nullptr : &fast_in_order_[place - 1]; };
  for (const FastContact& found : scratch.contacts) {
    const collision::Contact& contact = cache.contacts[cache.order[found.entry]];
    const FastMove* first = fast(found.fast_first);
    const FastMove* second = fast(found.fast_second);
    if (stay_apart(contact, first, second)) continue;
    const auto [of_first, of_second] = contact.pair;
    bool apart = contact.count == 0;
    for (std::size_t part = found.entry + 1; part < cache.order.size() && !is_first(part); ++part) {
      apart = apart && cache.contacts[cache.order[part]].count == 0;
    }
    if (first) scratch.near_fast.push_back({found.fast_first - 1, {of_first, of_second, apart}});
    if (second) scratch.near_fast.push_back({found.fast_second - 1, {of_second, of_first, apart}});
  }
}

// What the boxes' tree has near a fast body. Those that are fast themselves learn of it.
void World::Impl::find_near_by_tree(std::uint32_t number, FastSweep& scratch) const {
  query_nearby(fast_in_order_[number], Vector3::Zero(), scratch.nearby);
  for (const Nearby& near : scratch.nearby) {
    scratch.near_fast.push_back({number, near});
    const std::uint32_t place = fast_place_[colliders.body[near.other]];
    if (place == 0 || fast_in_order_[place - 1].queried) continue;
    scratch.near_fast.push_back({place - 1, {near.other, near.own, near.apart}});
  }
}

void World::Impl::find_near_fast() {
  broadphase.take_in(arena);
  note_rushed();
  sweep_scratch_.for_each([](FastSweep& of_worker) { of_worker.near_fast.clear(); });
  const bool by_contacts =
      std::any_of(fast_in_order_.begin(), fast_in_order_.end(), [](const FastMove& fast) { return !fast.queried; });
  constexpr std::size_t contact_grain = 512;
  arena.parallel_for(by_contacts ? cache.order.size() : 0, contact_grain, [&](std::size_t begin, std::size_t end) {
    find_near_by_contacts(begin, end, sweep_scratch_.local());
  });
  arena.parallel_for(fast_in_order_.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (fast_in_order_[i].queried) find_near_by_tree(static_cast<std::uint32_t>(i), sweep_scratch_.local());
    }
  });

  // Found in any order: each body will have its own in order.
  near_fast_begin_.assign(fast_in_order_.size() + 1, 0);
  sweep_scratch_.for_each([this](const FastSweep& of_worker) {
    for (const NearFast& near : of_worker.near_fast) ++near_fast_begin_[near.fast];
  });
  std::partial_sum(near_fast_begin_.begin(), near_fast_begin_.end(), near_fast_begin_.begin());
  near_fast_.resize(near_fast_begin_.back());
  sweep_scratch_.for_each([this](const FastSweep& of_worker) {
    for (const NearFast& near : of_worker.near_fast) near_fast_[--near_fast_begin_[near.fast]] = near.nearby;
  });
}

// What a fast body may meet in this step, in order.
void World::Impl::list_nearby(const FastMove& fast, std::vector<Nearby>& nearby) const {
  const auto number = static_cast<std::size_t>(&fast - fast_in_order_.data());
  nearby.assign(near_fast_.begin() + near_fast_begin_[number], near_fast_.begin() + near_fast_begin_[number + 1]);
  std::sort(nearby.begin(), nearby.end());
  const auto same = [](const Nearby& a, const Nearby& b) { return a.own == b.own && a.other == b.other; };
  nearby.erase(std::unique(nearby.begin(), nearby.end(), same), nearby.end());
}

// The same if it ends `aside` of where it did, as the boxes' tree has it.
void World::Impl::query_nearby(const FastMove& fast, const Vector3& aside, std::vector<Nearby>& nearby) const {
  nearby.clear();
  for_each_collider(fast.body, [&](std::uint32_t own) {
    broadphase.query_box(swept_box(fast, own, aside), [&](std::uint32_t other) {
      if (!broadphase.allowed(own, other)) return;
      nearby.push_back({own, other, !cache.touches(collision::Pair::of(own, other))});
    });
  });
  std::sort(nearby.begin(), nearby.end());
}

}  // namespace atl
