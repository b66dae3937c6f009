#include "step/island_phase.h"

#include <features/with_joints.h>
#include <jobs/arrays.h>
#include <jobs/assert.h>
#include <solver/select/joint_selection.h>

#include <algorithm>
#include <utility>

#include "world/bodies.h"
#include "world/settings_check.h"

namespace atl {
namespace {

// An active body that touches a sleeping one wakes its island.
void wake_touched_sleepers(Stores& world, std::span<const solver::TouchingPair> touching) {
  if (world.sleeping.asleep == 0) return;
  for (const solver::TouchingPair& pair : touching) {
    if (world.active.contains(pair.first) && world.sleeping.is_asleep(pair.second)) world.sleeping.wake(pair.second);
    if (world.active.contains(pair.second) && world.sleeping.is_asleep(pair.first)) world.sleeping.wake(pair.first);
  }
}

}  // namespace

void IslandPhase::build(Stores& world, const StepContext& step, ContactPhase& contacts) {
  wake_touched_sleepers(world, contacts.touching());
  if constexpr (with_joints) {
    update_joint_graph(world, world.clock.dt / step.substeps);
    wake_joined_to_moving(world);
  }
  contacts.remove_lost(world);
  // A woken body may touch another sleeping island, if a modifier had switched off the contacts between the two.
  for (ActiveChange woke = update_active_bodies(world); woke.changed; woke = update_active_bodies(world)) {
    contacts.add_woken(world, step, woke.woken_contacts);
    wake_touched_sleepers(world, contacts.touching());
  }
  const bool one_each = world.settings.tolerance > 0;
  rebuilt_ = world.changes.islands || contacts.touching_changed() || one_each != one_each_;
  if (rebuilt_) {
    islands_.build(world.active.in_order(), world.sleeping.awake, contacts.touching(), joint_graph_.links(),
                   joint_graph_.ties());
    one_each_ = one_each;
    world.changes.islands = false;
  }
  StepCounts& counts = step.report.counts;
  if (with_joints && world.joints.count > 0) count_joints(counts);
  counts.pairs = static_cast<std::int64_t>(world.cache.pairs.size());
  counts.contacts = static_cast<std::int64_t>(contacts.touching().size());
  counts.points = contacts.points();
}

// Makes the graph anew, and shares the joints out between the solvers, where joints or how they are solved changed, or
// substeps can follow other springs than before.
void IslandPhase::update_joint_graph(Stores& world, double h) {
  const double before = std::exchange(joint_substep_, h);
  const bool other_springs =
      h != before && std::any_of(longest_substeps_.begin(), longest_substeps_.end(),
                                 [&](double longest) { return (h > longest) != (before > longest); });
  if (!world.changes.joints && !other_springs) return;
  world.changes.joints = false;
  world.changes.islands = true;
  solver::BodyTable& bodies = world.bodies;
  const std::span<const solver::Joint> joints = world.joints.joints;
  joint_graph_.build(joints, world.joints.acts, bodies);
  const solver::JointMethod method = solver_settings(world.settings).joint_method;
  longest_substeps_.clear();
  joint_systems_.build(joint_graph_, joints, bodies, [&](std::uint32_t component) {
    const std::span<const solver::JointLink> links = joint_graph_.links_of(component);
    longest_substeps_.push_back(solver::longest_substep(links, joints, bodies));
    return solver::joins_directly(links, joints, bodies, method, h > longest_substeps_.back());
  });
  ATL_ASSERT(longest_substeps_.size() == joint_graph_.component_count(), longest_substeps_.size(),
             joint_graph_.component_count());
  to_kinematic_.clear();
  assembly_.resize(bodies.size());
  std::fill(bodies.joined.begin(), bodies.joined.end(), std::uint8_t{0});
  for (const solver::JointLink& link : joint_graph_.links()) {
    for (const std::uint32_t body : {link.first, link.second}) {
      bodies.joined[body] = world.records.dynamic[body];
      assembly_[body] = joint_graph_.component_of(link.joint);
    }
    if (bodies.mobility[link.first] == solver::Mobility::Kinematic) to_kinematic_.push_back({link.first, link.second});
    if (bodies.mobility[link.second] == solver::Mobility::Kinematic) to_kinematic_.push_back({link.second, link.first});
  }
}

// A body that is joined to a moving kinematic body doesn't rest, however slow the motion is.
void IslandPhase::wake_joined_to_moving(Stores& world) const {
  for (const auto& [kinematic, other] : to_kinematic_) {
    if (world.active.contains(kinematic)) world.sleeping.wake(other);
  }
}

void IslandPhase::count_joints(StepCounts& counts) {
  const std::span<const solver::JointLink> acting = acting_joints();
  if (rebuilt_) {
    direct_joints_ = std::count_if(acting.begin(), acting.end(), [this](const solver::JointLink& link) {
      return joint_systems_.is_direct(joint_graph_.component_of(link.joint));
    });
  }
  counts.joints = static_cast<std::int64_t>(acting.size());
  counts.direct_joints = direct_joints_;
}

}  // namespace atl
