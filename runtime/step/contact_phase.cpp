#include "step/contact_phase.h"

#include <collision/continuous/find_meeting.h>
#include <features/with_continuous.h>
#include <jobs/assert.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>

#include "world/colliders.h"

namespace atl {
namespace {

collision::ContactUpdateInput contact_input(const Stores& world, const collision::NarrowphaseKernels& kernels) {
  static_assert(sizeof(solver::Mobility) == 1 && static_cast<int>(solver::Mobility::Fixed) == 0);
  const solver::BodyTable& bodies = world.bodies;
  return {.colliders = world.colliders,
          .poses = {bodies.positions.data(), bodies.orientations.data()},
          .dynamic = world.records.dynamic,
          .mobility = {reinterpret_cast<const std::uint8_t*>(bodies.mobility.data()), bodies.size()},
          .turned = bodies.turned,
          .reaches = world.reaches,
          .kernels = kernels};
}

// How far bodies get in this step at the speeds they have.
void write_reaches(Stores& world, jobs::Arena& arena) {
  constexpr std::size_t grain = 1024;
  const std::span<const std::uint32_t> active = world.active.in_order();
  if (active.empty()) return;
  const solver::BodyTable& bodies = world.bodies;
  const double dt = world.clock.dt;
  world.reaches.resize(bodies.size());
  arena.parallel_for(active.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t body : active.subspan(begin, end - begin)) {
      collision::StepReach& reach = world.reaches[body];
      const Vector3 shift = dt * bodies.velocity(body);
      for (int i = 0; i < 3; ++i) reach.shift[i] = static_cast<float>(shift[i]);
      reach.turn = static_cast<float>(dt * bodies.angular_velocity(body).norm() * bodies.radius[body]);
    }
  });
}

// Pairs of which a filter is asked again: those with a contact, and those that were refused, which are forgotten.
struct AskedAgain {
  std::vector<collision::Pair> in_contact, refused;
};
AskedAgain take_asked_again(Stores& world) {
  AskedAgain again;
  ContactChoices& choices = world.choices;
  if (choices.refiltered.empty()) return again;
  for (const std::uint32_t body : choices.refiltered) {
    world.cache.for_each_contact_of(body, [&](std::uint32_t slot) {
      if (world.cache.contacts[slot].part == 0) again.in_contact.push_back(world.cache.contacts[slot].pair);
    });
  }
  std::sort(again.in_contact.begin(), again.in_contact.end());
  again.in_contact.erase(std::unique(again.in_contact.begin(), again.in_contact.end()), again.in_contact.end());
  const auto is_asked = [&](std::uint32_t collider) {
    return std::binary_search(choices.refiltered.begin(), choices.refiltered.end(), world.colliders.body[collider]);
  };
  const auto stays = [&](collision::Pair pair) { return !is_asked(pair.first) && !is_asked(pair.second); };
  const auto asked = std::stable_partition(choices.refused.begin(), choices.refused.end(), stays);
  again.refused.assign(asked, choices.refused.end());
  choices.refused.erase(asked, choices.refused.end());
  choices.refiltered.clear();
  ATL_ASSERT(std::is_sorted(again.refused.begin(), again.refused.end()), again.refused.size());
  return again;
}

// New pairs, less those that a filter refuses or has refused. What it is asked of again may lose its contacts.
void find_pairs_by_filter(Stores& world, const StepContext& step) {
  ContactChoices& choices = world.choices;
  std::erase_if(choices.refused, [&](collision::Pair pair) {
    return (world.broadphase.has_moved(pair.first) || world.broadphase.has_moved(pair.second)) &&
           !world.broadphase.overlap(pair.first, pair.second);
  });
  std::vector<collision::Pair> fresh;
  const std::span<const collision::Pair> found = world.broadphase.find_new_pairs(world.cache.pairs, step.arena);
  std::copy_if(found.begin(), found.end(), std::back_inserter(fresh),
               [&](collision::Pair pair) { return !choices.is_refused(pair); });
  const AskedAgain again = take_asked_again(world);
  add_in_order(fresh, again.refused);
  if (step.rules != nullptr && step.rules->filters()) {
    std::vector<collision::Pair> asked = fresh;
    add_in_order(asked, again.in_contact);
    const std::vector<collision::Pair> refused = step.rules->refuse(world, asked);
    const auto is_refused = [&](collision::Pair pair) {
      return std::binary_search(refused.begin(), refused.end(), pair);
    };
    std::erase_if(fresh, is_refused);
    if (std::any_of(again.in_contact.begin(), again.in_contact.end(), is_refused)) {
      world.cache.remove_any_if([&](std::uint32_t slot) { return is_refused(world.cache.contacts[slot].pair); });
      world.changes.islands = true;
    }
    add_in_order(choices.refused, refused);
  }
  world.cache.add(fresh, [&](collision::Pair pair) { return contact_start(world, pair); });
}

}  // namespace

void find_pairs(Stores& world, const StepContext& step) {
  // A longer step reaches farther than was accounted for.
  if (world.clock.dt > world.clock.last_dt) world.aabbs.mark_all_dirty();
  world.aabbs.update(world.active.in_order(), motions(world), world.broadphase, step.arena);
  step.report.counts.aabb_updates = static_cast<std::int64_t>(world.broadphase.moved_count());
  const bool filtered = step.rules != nullptr && step.rules->filters();
  if (filtered || !world.choices.is_empty()) return find_pairs_by_filter(world, step);
  world.cache.add(world.broadphase.find_new_pairs(world.cache.pairs, step.arena),
                  [&](collision::Pair pair) { return contact_start(world, pair); });
}

void place_idle_contacts(Stores& world, const collision::NarrowphaseKernels& kernels, jobs::Arena& arena) {
  if (world.cache.order().size() == world.cache.size()) return;
  world.reaches.resize(world.bodies.size());
  std::vector<std::uint32_t> idle;
  for (const std::uint32_t slot : world.cache.all_in_order()) {
    const collision::Contact& contact = world.cache.contacts[slot];
    const bool rests = !world.active.contains(contact.body_first) && !world.active.contains(contact.body_second);
    if (rests && contact.count > 0) idle.push_back(slot);
  }
  collision::refresh_contacts(world.cache, contact_input(world, kernels), idle, arena);
}

namespace {

// Contacts that a modifier changed in the last step are again as materials say.
void undo_modified(Stores& world) {
  for (const auto& [slot, pair] : world.choices.modified) {
    if (world.cache.contacts[slot].pair != pair || !world.cache.pairs.contains(pair)) continue;
    mix_materials(world, slot);
  }
  world.choices.modified.clear();
}

// Takes points of a manifold away for a step. The others lie about another centre, at which friction acts.
void switch_off_points(collision::ContactManifold& manifold, std::size_t count, unsigned on) {
  float x = 0, y = 0, points = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if ((on >> i & 1) != 0) {
      x += manifold.x[i];
      y += manifold.y[i];
      ++points;
      continue;
    }
    manifold.x[i] = manifold.y[i] = 0;
    manifold.separation[i] = collision::no_point;
    manifold.normal_impulse[i] = 0;
  }
  if (points == 0) {
    std::fill_n(manifold.friction_impulse, 3, 0.0f);
    manifold.torsional_impulse = 0;
    return;
  }
  x /= points;
  y /= points;
  manifold.friction_radius = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if ((on >> i & 1) == 0) continue;
    manifold.x[i] -= x;
    manifold.y[i] -= y;
    manifold.friction_radius += std::sqrt(manifold.x[i] * manifold.x[i] + manifold.y[i] * manifold.y[i]) / points;
  }
  const collision::Tangents frame = collision::tangents(manifold.normal);
  for (std::size_t i = 0; i < 3; ++i) {
    const float shift = x * frame.first[i] + y * frame.second[i];
    manifold.anchor_first[i] += shift;
    manifold.anchor_second[i] += shift;
  }
}

}  // namespace

// Such edges take two shapes that stand still, or that are parts of one body: other worlds are not searched.
void ContactPhase::leave_out_inner_edges(Stores& world, const collision::NarrowphaseKernels& kernels) {
  inner_.clear();
  inner_points_ = 0;
  const Contents& contents = world.contents;
  const bool has_fixed = contents.fixed_with_edges > 0 && contents.fixed_colliders > 1;
  if (!has_fixed && contents.moving_compounds == 0) return;
  const std::span<const std::uint32_t> found = inner_edges_.find(world.cache, contact_input(world, kernels), update_);
  inner_.assign(found.begin(), found.end());
  for (const std::uint32_t slot : inner_) {
    collision::forget_impulses(world.cache.manifolds[slot]);
    inner_points_ += world.cache.contacts[slot].count;
  }
}

void ContactPhase::change(Stores& world, std::uint32_t slot, const ModifiedContact& modified) {
  const std::size_t count = world.cache.contacts[slot].count;
  collision::ContactManifold& manifold = world.cache.manifolds[slot];
  world.choices.modified.push_back({slot, modified.pair});
  const bool rubs = modified.friction > 0, bounces = modified.restitution > 0;
  if (rubs != (manifold.friction > 0) || bounces != (manifold.restitution > 0)) {
    other_kinds_.push_back({{modified.pair, modified.part}, static_cast<std::uint8_t>(2 * rubs + bounces)});
  }
  manifold.friction = modified.friction;
  manifold.restitution = modified.restitution;
  if (modified.points != (1u << count) - 1) {
    switch_off_points(manifold, count, modified.points);
    for (std::size_t i = 0; i < count; ++i) modified_.points_off += (modified.points >> i & 1) == 0;
    if (modified.points == 0) modified_.off.push_back(slot);
  }
  if (modified.slip == std::array<float, 3>{}) return;
  if (!modified_.slips) slips_.assign(world.cache.manifolds.size(), {});
  modified_.slips = true;
  std::copy_n(modified.slip.data(), 3, slips_[slot].velocity);
}

void ContactPhase::modify(Stores& world, const StepContext& step, std::span<const solver::TouchingPair> contacts) {
  const std::vector<ModifiedContact> all = step.rules->modify(world, contacts);
  auto next = all.begin();
  for (const solver::TouchingPair& touching : contacts) {
    if (next == all.end()) break;
    const collision::Contact& contact = world.cache.contacts[touching.slot];
    if (next->pair == contact.pair && next->part == contact.part) change(world, touching.slot, *next++);
  }
  std::sort(other_kinds_.begin(), other_kinds_.end());
  list_on(world);
}

// Lists the touching contacts without those that are switched off.
void ContactPhase::list_on(const Stores& world) {
  jobs::CompactArray<std::uint32_t>& off = modified_.off;
  std::sort(off.begin(), off.end());
  off_.clear();
  std::set_union(off.begin(), off.end(), inner_.begin(), inner_.end(), std::back_inserter(off_));
  parts_off_.clear();
  for (const std::uint32_t slot : off_) {
    parts_off_.emplace_back(world.cache.contacts[slot].pair, world.cache.contacts[slot].part);
  }
  std::sort(parts_off_.begin(), parts_off_.end());
  off_changed_ = parts_off_ != parts_off_before_;
  on_.clear();
  modified_.pairs_off.clear();
  if (off_.empty()) return;
  const auto is_in = [](const jobs::CompactArray<std::uint32_t>& slots) {
    return [&slots](const solver::TouchingPair& pair) {
      return std::binary_search(slots.begin(), slots.end(), pair.slot);
    };
  };
  const auto pair_of = [&](const solver::TouchingPair& pair) { return world.cache.contacts[pair.slot].pair; };
  std::copy_if(update_.touching.begin(), update_.touching.end(), std::back_inserter(on_), std::not_fn(is_in(off_)));
  if (off.empty()) return;
  for (auto first = update_.touching.begin(); first != update_.touching.end();) {
    const auto end = std::find_if(first, update_.touching.end(),
                                  [&](const solver::TouchingPair& pair) { return pair_of(pair) != pair_of(*first); });
    if (std::all_of(first, end, is_in(off))) modified_.pairs_off.push_back(pair_of(*first));
    first = end;
  }
}

// Gives the contacts of surfaces the material of the triangles that they have now.
void ContactPhase::mix_surfaces(Stores& world) {
  if (world.contents.own_materials == 0 || world.contents.surfaces == 0) return;
  for (const solver::TouchingPair& touching : update_.touching) {
    const collision::Contact& contact = world.cache.contacts[touching.slot];
    const collision::ContactManifold& manifold = world.cache.manifolds[touching.slot];
    const bool rubbed = manifold.friction > 0, bounced = manifold.restitution > 0;
    mix_materials(world, touching.slot);
    if (rubbed == (manifold.friction > 0) && bounced == (manifold.restitution > 0)) continue;
    const int kind = 4 + 2 * (manifold.friction > 0) + (manifold.restitution > 0);
    other_kinds_.push_back({{contact.pair, contact.part}, static_cast<std::uint8_t>(kind)});
  }
}

void ContactPhase::update(Stores& world, const StepContext& step) {
  undo_modified(world);
  write_reaches(world, step.arena);
  world.cache.rises.resize(world.contents.surfaces > 0 ? world.cache.contacts.size() : 0);
  const auto is_joined = [&](std::uint32_t body) {
    bool any = false;
    world.joints.for_each_of(body, [&](std::uint32_t joint) { any |= world.joints.acts[joint] != 0; });
    return any;
  };
  const collision::MotionAhead ahead = {world.bodies.angular_velocities.data(), world.clock.dt, is_joined,
                                        collision::find_meeting};
  collision::ContactUpdateInput input = contact_input(world, step.narrowphase_kernels);
  if constexpr (with_continuous) input.ahead = &ahead;
  collision::update_contacts(world.cache, world.broadphase, input, step.arena, update_);
  world.broadphase.forget_moves();
  std::swap(parts_off_, parts_off_before_);
  std::swap(other_kinds_, other_kinds_before_);
  other_kinds_.clear();
  modified_ = {};
  mix_surfaces(world);
  leave_out_inner_edges(world, step.narrowphase_kernels);
  if (step.rules != nullptr && step.rules->modifies()) {
    modify(world, step, update_.touching);
  } else {
    list_on(world);
  }
  const collision::ContactUpdateCounts& found = update_.counts;
  StepCounts& counts = step.report.counts;
  counts.fcl_calls = found.fcl_calls;
  counts.fcl_repairs = found.fcl_repairs;
  counts.recycled_manifolds = found.recycled;
  counts.recomputed_manifolds = found.recomputed;
  counts.id_matches = found.id_matches;
  counts.id_misses = found.id_misses;
  counts.active_bodies = static_cast<std::int64_t>(world.active.in_order().size());
  counts.active_contacts = static_cast<std::int64_t>(world.cache.order().size());
}

void ContactPhase::add_woken(Stores& world, const StepContext& step, std::span<const std::uint32_t> slots) {
  collision::refresh_contacts(world.cache, contact_input(world, step.narrowphase_kernels), slots, step.arena);
  update_.add_touching(world.cache, slots);
  leave_out_inner_edges(world, step.narrowphase_kernels);
  if (step.rules == nullptr || !step.rules->modifies()) return list_on(world);
  std::vector<solver::TouchingPair> woken;
  for (const std::uint32_t slot : slots) {
    const collision::Contact& contact = world.cache.contacts[slot];
    if (contact.count > 0) woken.push_back({contact.body_first, contact.body_second, slot});
  }
  modify(world, step, woken);
}

void ContactPhase::remove_lost(Stores& world) {
  if (update_.counts.lost > 0) {
    std::size_t i = 0;
    world.cache.remove_if([&](std::uint32_t) { return update_.status[i++] == collision::ContactStatus::Lost; });
    ATL_ASSERT(i == update_.status.size(), i, update_.status.size());
  }
  cache_changes_ = world.cache.changes();
}

}  // namespace atl
