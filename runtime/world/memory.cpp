// What of a world's memory is for what.

#include <jobs/bytes.h>
#include <jobs/with_joints.h>

#include "state/recorder.h"
#include "world/world_impl.h"

namespace atl {

using jobs::bytes_of;

std::size_t BodyRecords::bytes() const {
  return bytes_of(generation, alive, type, continuous, constants, dynamic, free) + material.bytes() + centre.bytes();
}

std::vector<MemoryUse> World::Impl::memory() const {
  const std::size_t contacts = cache.pairs.size();
  const std::size_t touching = contact_update_.touching.size();
  std::vector<MemoryUse> uses;
  uses.push_back({"bodies",
                  bodies.bytes() + records.bytes() + aabbs.bytes() + active_.bytes() +
                      bytes_of(may_start_or_stop_, pushed_, reaches_),
                  records.count, "bodies"});
  uses.push_back({"sleeping", sleeping.bytes(), records.count, "bodies"});
  uses.push_back({"running_surfaces", bytes_of(bodies.surfaces, surface_contacts_), records.count, "bodies"});
  const std::size_t new_boxes = aabbs.update_bytes();
  uses.push_back({"shapes", colliders.bytes(), colliders.body.size(), "shapes"});
  uses.push_back({"broadphase", broadphase.bytes() + new_boxes, colliders.body.size(), "shapes"});
  uses.push_back({"contacts", cache.bytes() + contact_update_.bytes(), contacts, "pairs"});
  std::size_t solver = bytes_of(groups_, group_reports_);
  group_solvers_.for_each([&](const solver::GroupSolver& each) { solver += each.bytes(); });
  for (const auto& large : large_solvers_) solver += large->bytes();
  uses.push_back({"islands", islands_.bytes(), touching, "contacts"});
  uses.push_back({"contact_solver", solver, touching, "contacts"});
  std::size_t direct = bytes_of(direct_solvers_, direct_of_group_, direct_reports_);
  for (const auto& each : direct_solvers_) direct += each->bytes();
  uses.push_back({"direct_contacts", direct, direct_solvers_.size(), "islands"});
  uses.push_back({"overload_watch", selection_.bytes() + bytes_of(modes_, alone_, all_overloads_, escalated_, failed_),
                  records.count, "bodies"});
  std::size_t of_joints = joints.bytes() + bytes_of(to_kinematic_, joint_events_, assembly_);
  if constexpr (with_joints) of_joints += joint_graph_.bytes() + joint_systems_.bytes();
  uses.push_back({"joints", of_joints, joints.count, "joints"});
  uses.push_back({"continuous_collision", bytes_of(fast_in_order_, carried_) + continuous_.bytes(),
                  static_cast<std::size_t>(report_.counts.swept), "bodies"});
  uses.push_back({"contact_events", events_.bytes() + unasked_events_.bytes(), events_.told.size(), "events"});
  uses.push_back(
      {"contact_problem", bytes_of(capture_.answers, capture_.motions), capture_.answers.size(), "contacts"});
  return uses;
}

}  // namespace atl
