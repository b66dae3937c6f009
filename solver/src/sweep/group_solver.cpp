#include <jobs/with_joints.h>
#include <jobs/with_restitution.h>
#include <jobs/worker_team.h>
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
  return run(input, group, serial, GroupContacts::New);
}

GroupReport GroupSolver::solve(const SolveInput& input, const IslandGroup& group, jobs::WorkerTeam& team,
                               GroupContacts contacts) {
  return run(input, group, team, contacts);
}

template <typename Executor>
GroupReport GroupSolver::run(const SolveInput& input, const IslandGroup& group, Executor& executor,
                             GroupContacts contacts) {
  SubstepConstants constants = SubstepConstants::of(input.settings, input.dt);
  constants.gravity = static_cast<float>(input.gravity.norm());
  GroupReport report;
  StageClock clock(input.settings.profile, report.stage_ms);
  if (contacts == GroupContacts::New) collect(input, group);
  note_needs(input, group, report);
  clock.lap(SolverStage::Colour);
  gather_bodies(input, group, report, executor);
  Pass<Executor> pass(*this, input, group, constants, executor, clock, report);
  pass.prepare();
  for (int i = 0; i < input.settings.substeps; ++i) pass.substep(i);
  pass.finish();
  return report;
}

void GroupSolver::collect(const SolveInput& input, const IslandGroup& group) {
  collect_kinematic_bodies(input, group);
  collect_contacts(input, group);
  collect_joints(input, group);
  const auto end = first_dynamic_ + static_cast<std::uint32_t>(input.islands.bodies(group.begin, group.end).size());
  colouring_.build(contacts_, first_dynamic_, end, blocks_);
  if constexpr (with_joints) joints_.colour(first_dynamic_, end);
}

// Which kernels the group's contacts, joints and bodies call for.
void GroupSolver::note_needs(const SolveInput& input, const IslandGroup& group, GroupReport& report) {
  const bool everything = input.settings.everything;
  report.surfaces = note_surfaces(input, group);
  report.friction = friction_ || report.surfaces || everything;
  report.restitution = with_restitution && (restitution_ || everything);
  report.colours = colouring_.colours().size();
  report.joints = input.islands.joints(group.begin, group.end).size();
  if (with_joints && !joints_.empty()) report.colours = std::max(report.colours, joints_.colours().size());
  bodies_.balls = false;
  for (const std::uint32_t body : input.islands.bodies(group.begin, group.end)) {
    report.gyroscopic_bodies += input.bodies.gyroscopic[body];
    report.locked_bodies += input.bodies.locks[body] != 0;
    bodies_.balls |= input.bodies.ball[body] != 0;
  }
}

template <typename Executor>
void GroupSolver::gather_bodies(const SolveInput& input, const IslandGroup& group, const GroupReport& report,
                                Executor& executor) {
  const SolverSettings& settings = input.settings;
  const std::span<const std::uint32_t> ids = input.islands.bodies(group.begin, group.end);
  bool any_turns = false, any_round_turns = false;
  const auto note_turns = [&](std::span<const std::uint32_t> bodies) {
    for (const std::uint32_t body : bodies) {
      const bool turned = turns(input, body);
      any_turns |= turned;
      any_round_turns |= turned && input.bodies.round[body];
    }
  };
  if (!contacts_.empty()) {
    note_turns(ids);
    note_turns(kinematic_);
  }
  bodies_.reset(first_dynamic_ + ids.size(), {.gyroscopic = report.gyroscopic_bodies > 0 || settings.everything,
                                              .correction = settings.stabilisation == Stabilisation::SplitImpulse,
                                              .locks = report.locked_bodies > 0 || settings.everything,
                                              .shape = !contacts_.empty() && (any_turns || settings.everything)});
  bodies_.round_shapes = any_round_turns;
  load_kinematic_bodies(input);
  executor.parallel_for(ids.size(), body_grain, [&](std::size_t begin, std::size_t end) {
    load_bodies(input, ids, begin, end, input.dt / settings.substeps);
  });
}

ContactKernelData GroupSolver::kernel_data(const SolveInput& input, const GroupReport& report,
                                           const SubstepConstants& constants, bool splits) {
  const std::size_t block_count = colouring_.block_count();
  const auto one_a_block = [&](auto& blocks, bool needed) {
    if (needed && blocks.size() < block_count) blocks.resize(block_count);
    return needed ? blocks.data() : nullptr;
  };
  return {.bodies = bodies_,
          .blocks = blocks_.data(),
          .bounces = one_a_block(bounces_, report.restitution),
          .manifolds = input.manifolds,
          .constants = constants,
          .surface_blocks = one_a_block(surface_blocks_, report.surfaces),
          .surface_contacts = input.surface_contacts,
          .rises = input.rises,
          .split_blocks = one_a_block(split_blocks_, splits),
          .planar_blocks = one_a_block(planar_blocks_, !bodies_.locks.empty()),
          .turning_blocks = one_a_block(turning_blocks_, !bodies_.shape.empty()),
          .joined = joined_.empty() ? nullptr : joined_.data(),
          .leaves_out = !input.settings.everything};
}

// What forces do to bodies that leap in a part of a substep.
void GroupSolver::give_half_kick(std::span<const std::uint32_t> bodies, float time) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!joined_motion_.leaps(i)) continue;
    VelocityRows& velocity = bodies_.velocity[first_dynamic_ + i];
    const AccelerationRows& acceleration = bodies_.acceleration[first_dynamic_ + i];
    for (int k = 0; k < 3; ++k) {
      velocity.linear[k] += time * acceleration.linear[k];
      velocity.angular[k] += time * acceleration.angular[k];
    }
  }
}

void GroupSolver::clear_impulses(const GroupReport& report) {
  for (std::size_t b = 0; b < colouring_.block_count(); ++b) {
    ContactBlock& block = blocks_[b];
    for (auto& point : block.normal_impulse) std::fill_n(point, block_lanes, 0.0f);
    for (auto& axis : block.friction_impulse) std::fill_n(axis, block_lanes, 0.0f);
    std::fill_n(block.twist_impulse, block_lanes, 0.0f);
    if (!report.surfaces) continue;
    for (auto& axis : surface_blocks_[b].rolling_impulse) std::fill_n(axis, block_lanes, 0.0f);
  }
}

void GroupSolver::clear_split_impulses() { std::fill_n(split_blocks_.begin(), colouring_.block_count(), SplitBlock{}); }

}  // namespace atl::solver
