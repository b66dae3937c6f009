#include "step/contact_phase.h"

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
void note_reaches(Stores& world, jobs::Arena& arena) {
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

}  // namespace

void find_pairs(Stores& world, const StepContext& step) {
  // A longer step reaches farther than was accounted for.
  if (world.clock.dt > world.clock.last_dt) world.aabbs.mark_all_dirty();
  world.aabbs.update(world.active.in_order(), motions(world), world.broadphase, step.arena);
  step.report.counts.new_boxes = static_cast<std::int64_t>(world.broadphase.moved_count());
  world.cache.add(world.broadphase.find_new_pairs(world.cache.pairs, step.arena),
                  [&](collision::Pair pair) { return contact_start(world, pair); });
}

void place_idle_contacts(Stores& world, const collision::NarrowphaseKernels& kernels, jobs::Arena& arena) {
  if (world.cache.order.size() == world.cache.size()) return;
  world.reaches.resize(world.bodies.size());
  std::vector<std::uint32_t> idle;
  for (const std::uint32_t slot : world.cache.all_in_order()) {
    const collision::Contact& contact = world.cache.contacts[slot];
    const bool rests = !world.active.contains(contact.body_first) && !world.active.contains(contact.body_second);
    if (rests && contact.count > 0) idle.push_back(slot);
  }
  collision::place_contacts(world.cache, world.broadphase, contact_input(world, kernels), idle, arena);
}

void ContactPhase::update(Stores& world, const StepContext& step) {
  note_reaches(world, step.arena);
  world.cache.rises.resize(world.contents.smooth_surfaces > 0 ? world.cache.contacts.size() : 0);
  collision::update_contacts(world.cache, world.broadphase, contact_input(world, step.narrowphase_kernels), step.arena,
                             update_);
  world.broadphase.forget_moves();
  const collision::ContactUpdateCounts& found = update_.counts;
  StepCounts& counts = step.report.counts;
  counts.fcl_calls = found.fcl_calls;
  counts.fcl_repairs = found.fcl_repairs;
  counts.kept_manifolds = found.kept;
  counts.fresh_manifolds = found.fresh;
  counts.id_matches = found.id_matches;
  counts.id_misses = found.id_misses;
  counts.active_bodies = static_cast<std::int64_t>(world.active.in_order().size());
  counts.active_contacts = static_cast<std::int64_t>(world.cache.order.size());
}

void ContactPhase::add_woken(Stores& world, const StepContext& step, std::span<const std::uint32_t> slots) {
  collision::place_contacts(world.cache, world.broadphase, contact_input(world, step.narrowphase_kernels), slots,
                            step.arena);
  update_.add_touching(world.cache, slots);
}

void ContactPhase::remove_lost(Stores& world) const {
  if (update_.counts.lost == 0) return;
  std::size_t i = 0;
  world.cache.remove_if([&](std::uint32_t) { return update_.status[i++] == collision::ContactStatus::Lost; });
}

}  // namespace atl
