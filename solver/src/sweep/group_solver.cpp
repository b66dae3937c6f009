#include <features/with_joints.h>
#include <features/with_restitution.h>
#include <jobs/assert.h>
#include <jobs/worker_team.h>
#include <solver/constraints/contact_arm.h>
#include <solver/direct/joint_systems.h>
#include <solver/sweep/group_solver.h>

#include <algorithm>

#include "sweep/group_pass.h"

namespace atl::solver {
namespace {

// Stands in for a team where the calling thread does it all.
struct Serial {
  template <typename Body>
  void parallel_for(std::size_t count, std::size_t, const Body& body) {
    if (count > 0) body(std::size_t{0}, count);
  }
};

}  // namespace

GroupReport GroupSolver::solve(const SolveInput& input, const IslandGroup& group) {
  Serial serial;
  return run(input, group, serial, GroupColours::New);
}

GroupReport GroupSolver::solve(const SolveInput& input, const IslandGroup& group, jobs::WorkerTeam& team,
                               GroupColours colours) {
  return run(input, group, team, colours);
}

template <typename Executor>
GroupReport GroupSolver::run(const SolveInput& input, const IslandGroup& group, Executor& executor,
                             GroupColours colours) {
  SubstepConstants constants = SubstepConstants::of(input.settings, input.dt);
  ATL_ASSERT(input.settings.substeps >= 1 && input.dt > 0, input.settings.substeps, input.dt);
  constants.gravity = static_cast<float>(input.gravity.norm());
  GroupReport report;
  PhaseClock clock(input.settings.profile, report.phase_ms);
  if (colours == GroupColours::New) collect(input, group);
  select_kernels(input, group, report);
  clock.lap(SolverPhase::Colour);
  gather_bodies(input, group, report, executor);
  const GroupSetup setup(input, group, constants, report, parts_);
  GroupPass<Executor> pass(parts_, setup, executor, clock, report);
  pass.prepare();
  for (int i = 0; i < input.settings.substeps; ++i) pass.substep(i);
  pass.finish();
  return report;
}

void GroupSolver::collect(const SolveInput& input, const IslandGroup& group) {
  parts_.numbers.collect(input, group);
  parts_.contacts.collect(input, group, parts_.numbers);
  if constexpr (with_joints) collect_joints(input, group);
}

// Joints of components that are solved at once are left to who does that; what else happens to bodies that are joined
// happens to all.
void GroupSolver::collect_joints(const SolveInput& input, const IslandGroup& group) {
  const GroupBodies& numbers = parts_.numbers;
  parts_.joints.clear();
  parts_.tendons.clear();
  parts_.joined.clear();
  const std::span<const JointLink> links = input.islands.joints(group.begin, group.end);
  if (links.empty()) return;
  parts_.joined_motion.build(input, group);
  parts_.joined.assign(numbers.count(), 0);
  for (std::size_t i = numbers.first_dynamic(); i < parts_.joined.size(); ++i) {
    const std::size_t body = i - numbers.first_dynamic();
    if (!parts_.joined_motion.is_joined(body)) continue;
    parts_.joined[i] = static_cast<std::uint8_t>(parts_.joined_motion.is_direct(body) ? Joined::Direct : Joined::Swept);
  }
  for (const JointLink& link : links) {
    if (input.solves_directly(input.joint_graph->component_of(link.joint))) continue;
    const Joint& joint = input.joints[link.joint];
    if (joint.is_tendon()) {
      parts_.tendons.add(link.joint, input.joints,
                         [&](std::uint32_t body) { return numbers.local(input, group, body); });
      continue;
    }
    parts_.joints.add({numbers.local(input, group, link.first), numbers.local(input, group, link.second), link.joint,
                       joint.point, joint.rows},
                      joint);
  }
  parts_.joints.colour(numbers.first_dynamic(), numbers.count());
}

// Selects kernels by the features that the group's contacts, joints and bodies have in this step.
void GroupSolver::select_kernels(const SolveInput& input, const IslandGroup& group, GroupReport& report) {
  const bool everything = input.settings.everything;
  report.surfaces = update_surface_contacts(input, group);
  report.friction = parts_.contacts.friction() || report.surfaces || everything;
  report.restitution = with_restitution && (parts_.contacts.restitution() || everything);
  report.colours = parts_.contacts.colours().size();
  report.joints = input.islands.joints(group.begin, group.end).size();
  if (with_joints && !parts_.joints.empty()) {
    report.colours = std::max(report.colours, parts_.joints.colours().size());
  }
  parts_.bodies.balls = false;
  for (const std::uint32_t body : input.islands.bodies(group.begin, group.end)) {
    report.gyroscopic_bodies += input.bodies.gyroscopic[body];
    report.locked_bodies += input.bodies.locks[body] != 0;
    parts_.bodies.balls |= input.bodies.ball[body] != 0;
  }
}

template <typename Executor>
void GroupSolver::gather_bodies(const SolveInput& input, const IslandGroup& group, const GroupReport& report,
                                Executor& executor) {
  const SolverSettings& settings = input.settings;
  const std::span<const std::uint32_t> ids = input.islands.bodies(group.begin, group.end);
  const std::span<const std::uint32_t> kinematic = parts_.numbers.kinematic();
  const std::uint32_t first_dynamic = parts_.numbers.first_dynamic();
  const bool any_contact = !parts_.contacts.empty();
  bool any_turns = false, any_rolls = false;
  const auto record_turns = [&](std::span<const std::uint32_t> bodies) {
    for (const std::uint32_t body : bodies) {
      const bool turned = turns_in_step(input.bodies, body, input.dt);
      any_turns |= turned;
      any_rolls |= turned && input.bodies.rolls[body];
    }
  };
  if (any_contact) {
    record_turns(ids);
    record_turns(kinematic);
  }
  SolverBodies& rows = parts_.bodies;
  rows.reset(first_dynamic + ids.size(), {.gyroscopic = report.gyroscopic_bodies > 0 || settings.everything,
                                          .correction = settings.stabilisation == Stabilisation::SplitImpulse,
                                          .locks = report.locked_bodies > 0 || settings.everything,
                                          .shape = any_contact && (any_turns || settings.everything),
                                          .blow = report.restitution});
  rows.roll = any_rolls;
  load_kinematic_bodies(input, kinematic, rows);
  const std::vector<double> approaches = approach_speeds(input, group, parts_.numbers);
  executor.parallel_for(ids.size(), GroupLoops<Executor>::body_grain, [&](std::size_t begin, std::size_t end) {
    load_bodies(input, ids, begin, end, first_dynamic, approaches, rows);
  });
}

}  // namespace atl::solver
