#pragma once
/// A group's step, once its bodies, contacts and joints are gathered: prepare, substeps, finish.

#include <solver/tuning.h>

#include <atomic>
#include <vector>

#include "sweep/group_loops.h"
#include "sweep/group_results.h"
#include "sweep/group_setup.h"
#include "sweep/phase_clock.h"

namespace atl::solver {

// Sets how surfaces that bend move in a sweep: their speeds at `at` substeps into the step, their positions at `after`.
inline void rise(const GroupSetup& setup, double at, double after, Sweep& how) {
  const double substeps = setup.settings.substeps;
  how.rise_part = static_cast<float>(2 * at / substeps - 1);
  how.rise_time = static_cast<float>(after / substeps * (after / substeps - 1) * setup.input.dt);
}

template <typename Executor>
class GroupPass {
 public:
  /// Works on a gathered group; `setup` is made of the same parts and report.
  GroupPass(GroupParts& parts, const GroupSetup& setup, Executor& executor, PhaseClock& clock, GroupReport& report)
      : parts_(parts), setup_(setup), loops_(executor, parts, setup), clock_(clock), report_(report) {}

  void prepare();
  void substep(int number);
  void finish();

 private:
  // Joints that are solved one by one are `joints`, components of them that are solved at once `systems`.
  void prepare_contacts();
  void prepare_joints();
  void complete_joints();
  void refresh_joint_rows(bool moved);
  void prepare_systems();
  void bounce(int number);
  void record_speeds();
  void integrate_velocities(bool carries);
  void warm_start(int number);
  void fit_impulses();
  void solve_velocities(int number, bool carries);
  void solve_systems(int number);
  void split_off_corrections(int number);
  void record_pushes(bool ends);
  void integrate_positions();
  void relax(int number);
  void bound_joints(int number, double speed);
  void record_joint_impacts();
  void bounce_joints();
  void finish_contacts();

  void sweep(Sweep how, JointSweep joints, int iterations, int number);

  GroupParts& parts_;
  const GroupSetup& setup_;
  GroupLoops<Executor> loops_;
  PhaseClock& clock_;
  GroupReport& report_;
  bool joint_impacts_ = false;  // some coordinate bounces at the end of its range in this substep
};

template <typename Executor>
void GroupPass<Executor>::prepare() {
  if (setup_.sweeps_joints) prepare_joints();
  prepare_contacts();
  if (setup_.watches_energy) parts_.passive_energy.begin(setup_.input, setup_.group, parts_.contacts.deepest());
  complete_joints();
  if (setup_.sweeps_tendons) parts_.tendons.begin_step(setup_.joint_step);
  if (setup_.joined) prepare_systems();
  clock_.lap(SolverPhase::Prepare);
}

template <typename Executor>
void GroupPass<Executor>::substep(int number) {
  const bool carries = setup_.settings.warm_starting && number > 0;  // impulses of the last substep
  const bool last = number + 1 == setup_.settings.substeps;
  if (report_.restitution) bounce(number);
  clock_.lap(SolverPhase::Restitution);
  record_speeds();
  integrate_velocities(carries);
  clock_.lap(SolverPhase::Integrate);
  warm_start(number);
  clock_.lap(SolverPhase::WarmStart);
  solve_velocities(number, carries);
  bound_joints(number, tuning::max_closing_speed);
  record_pushes(false);
  clock_.lap(SolverPhase::Solve);
  integrate_positions();
  clock_.lap(SolverPhase::Integrate);
  relax(number);
  record_pushes(true);
  clock_.lap(SolverPhase::Relax);
  if (last && setup_.input.capture != nullptr) capture_answers(setup_.input, parts_, report_, setup_.body_ids);
  if (joint_impacts_) bounce_joints();
  clock_.lap(SolverPhase::Restitution);
}

template <typename Executor>
void GroupPass<Executor>::finish() {
  finish_contacts();
  if (setup_.input.pushed != nullptr) parts_.contacts.tell_pushes(setup_.input.pushed);
  loops_.each_body([&](std::size_t begin, std::size_t end) {
    write_back(setup_.input, parts_, setup_.body_ids, setup_.joined, begin, end);
  });
  loops_.each_system([&](DirectJoints& system) { system.finish(setup_.input); });
  if (setup_.watches_energy) parts_.passive_energy.bound(setup_.input);
  loops_.each_joint_block(
      [&](std::size_t begin, std::size_t end) { parts_.joints.store(setup_.joint_step, begin, end); });
  if (setup_.sweeps_tendons) parts_.tendons.store(setup_.joint_step);
  clock_.lap(SolverPhase::Store);
}

template <typename Executor>
void GroupPass<Executor>::prepare_contacts() {
  loops_.each_contact_block([&](std::size_t begin, std::size_t end) {
    parts_.contacts.find_rims(setup_.input, parts_.bodies, begin, end);
    setup_.kernels.prepare(setup_.contact_data, begin, end);
  });
  for (const ContactBlock& block : parts_.contacts.blocks()) report_.work.add(block);
  if (setup_.input.pushed != nullptr) parts_.contacts.begin_pushes();
  parts_.impacts.begin_step(report_.restitution ? parts_.bodies.padded_count() : 0, parts_.contacts.block_count());
}

// Prepares joints. Their stiffness counts as inertia of the bodies that they pull on.
template <typename Executor>
void GroupPass<Executor>::prepare_joints() {
  JointInertia& inertia = parts_.joint_inertia;
  loops_.each_joint_block(
      [&](std::size_t begin, std::size_t end) { parts_.joints.prepare(setup_.joint_step, begin, end); });
  inertia.reset(parts_.numbers.first_dynamic(), setup_.body_ids.size());
  loops_.each_joint_colour([&](std::size_t begin, std::size_t end) {
    parts_.joints.add_stiffness(setup_.joint_step, inertia.stiffness(), begin, end);
  });
  loops_.each_body([&](std::size_t begin, std::size_t end) {
    inertia.stiffen(setup_.input, setup_.body_ids, begin, end, parts_.bodies);
  });
  inertia.find_followers(setup_.input, setup_.body_ids, parts_.joined_motion);
}

template <typename Executor>
void GroupPass<Executor>::complete_joints() {
  loops_.each_joint_block(
      [&](std::size_t begin, std::size_t end) { setup_.kernels.prepare_joints(setup_.joint_data, begin, end); });
  refresh_joint_rows(false);
}

// Joints' coordinates and rows where bodies are now; once these have `moved`, impulses are carried over.
template <typename Executor>
void GroupPass<Executor>::refresh_joint_rows(bool moved) {
  if (!parts_.joints.has_rows()) return;
  loops_.each_joint_row_block([&](std::size_t begin, std::size_t end) {
    if (!moved) parts_.joints.prepare_rows(setup_.joint_step, begin, end);
    setup_.kernels.refresh_rows(setup_.joint_data, moved, begin, end);
    if (moved) parts_.joints.keep_springs(begin, end);
  });
}

template <typename Executor>
void GroupPass<Executor>::prepare_systems() {
  parts_.joined_motion.record_forces(setup_.body_ids, setup_.input.bodies, setup_.input.gravity);
  loops_.each_system([&](DirectJoints& system) {
    system.locate([&](std::uint32_t body) { return parts_.numbers.local(setup_.input, setup_.group, body); });
    system.begin_step(setup_.input);
  });
}

// Reflects the contacts that hit within the substep, before its forces.
template <typename Executor>
void GroupPass<Executor>::bounce(int number) {
  loops_.each_contact_block(
      [&](std::size_t begin, std::size_t end) { setup_.kernels.find_approaches(setup_.contact_data, begin, end); });
  const JoinedMotion* components = setup_.joined ? &parts_.joined_motion : nullptr;
  const double start = setup_.input.substep() * number;
  parts_.impacts.solve(setup_.contact_data, setup_.friction,
                       {setup_.input, setup_.group, parts_.numbers, components, start});
}

// Records rates before the forces of a substep, since springs go by these.
template <typename Executor>
void GroupPass<Executor>::record_speeds() {
  if (parts_.joints.has_rows()) {
    loops_.each_joint_row_block(
        [&](std::size_t begin, std::size_t end) { parts_.joints.begin_substep(setup_.joint_step, begin, end); });
  }
  if (setup_.sweeps_tendons) parts_.tendons.begin_substep(setup_.joint_step);
}

template <typename Executor>
void GroupPass<Executor>::integrate_velocities(bool carries) {
  loops_.each_body_block([&](std::size_t begin, std::size_t end) {
    setup_.kernels.integrate_velocities(parts_.bodies, setup_.constants, carries, begin, end);
  });
}

template <typename Executor>
void GroupPass<Executor>::warm_start(int number) {
  if (!setup_.settings.warm_starting) {
    parts_.contacts.clear_impulses(report_);
    if (setup_.sweeps_joints) parts_.joints.clear_impulses(0, parts_.joints.block_count());
    if (setup_.sweeps_tendons) parts_.tendons.clear_impulses();
  } else {
    // Later substeps have begun with all that the one before has changed.
    const float kept = setup_.constants.joint_carried;
    const float applied = number == 0 ? kept : kept - 1;
    if (applied != 0) {
      loops_.each_joint_colour([&](std::size_t begin, std::size_t end) {
        setup_.kernels.warm_start_joints(setup_.joint_data, applied, kept, begin, end);
      });
    }
    if (setup_.sweeps_tendons) parts_.tendons.warm_start(parts_.bodies, applied, kept, number > 0);
    if (number == 0) {
      loops_.each_contact_colour(
          [&](std::size_t begin, std::size_t end) { setup_.kernels.warm_start(setup_.contact_data, begin, end); });
    }
    fit_impulses();
  }
  loops_.each_system([&](DirectJoints& system) { system.begin_substep(setup_.input); });
  if (setup_.sweeps_joints && parts_.joints.may_bounce()) record_joint_impacts();
}

// Impulses that are carried over fit what a substep needs, but where the one before had an impact. Without gravity
// there is no load that an impact would be told from, and all are kept.
template <typename Executor>
void GroupPass<Executor>::fit_impulses() {
  if (setup_.block_count == 0 || setup_.struck_speed == 0) return;
  LargestOf struck;
  parts_.contacts.begin_fitting(parts_.bodies.padded_count());
  loops_.each_body_block([&](std::size_t begin, std::size_t end) {
    if (parts_.contacts.find_struck(parts_.bodies, parts_.joined, setup_.struck_speed, begin, end)) struck.add(1);
  });
  if (struck.value() == 0) return;
  for (int round = 0; round < tuning::fitting_rounds; ++round) {
    LargestOf taken_back;
    loops_.each_contact_block([&](std::size_t begin, std::size_t end) {
      const float least = setup_.kernels.find_fitting(setup_.contact_data, parts_.contacts.struck(),
                                                      parts_.contacts.fitting(), begin, end);
      taken_back.add(1 - least);
    });
    if (taken_back.value() == 0) return;
    loops_.each_contact_colour([&](std::size_t begin, std::size_t end) {
      setup_.kernels.fit_impulses(setup_.contact_data, parts_.contacts.fitting(), begin, end);
    });
  }
}

template <typename Executor>
void GroupPass<Executor>::solve_velocities(int number, bool carries) {
  // The first sweep keeps the relaxing sweeps' friction, which is carried over; a contact that has just begun has none
  // yet to carry.
  const Friction friction = setup_.relaxes && carries ? Friction::None : setup_.friction;
  // Relaxing sweeps have already seen the positions at the end of the last substep.
  const bool refresh = !setup_.relaxes && number > 0;
  const bool twice = !(setup_.relaxes && carries);
  Sweep how = {setup_.splits ? Push::None : Push::Bias, refresh, friction, twice};
  rise(setup_, number + 0.5, number, how);
  sweep(how, {.push = how.push, .refresh = refresh, .carries = carries}, setup_.settings.iterations, number);
  if (setup_.splits) split_off_corrections(number);
  // The systems come last, so that a link turned by its contacts is brought back before it gets far out of its joints.
  solve_systems(number);
}

// The same sweeps over velocities of their own, which move bodies and are forgotten.
template <typename Executor>
void GroupPass<Executor>::split_off_corrections(int number) {
  loops_.each_body_block(
      [&](std::size_t begin, std::size_t end) { setup_.kernels.clear_corrections(parts_.bodies, begin, end); });
  parts_.contacts.clear_split_impulses();
  parts_.joints.clear_split_impulses();
  parts_.bodies.velocity.swap(parts_.bodies.correction);
  // Rigid contacts have no softness to forgive what a round over the points leaves.
  sweep({Push::Split, false, Friction::None, true}, {.push = Push::Split}, setup_.settings.iterations, number);
  parts_.bodies.velocity.swap(parts_.bodies.correction);
}

// Both before and after they are relaxed, which ends the substep: what stops in it may need no push in the other.
template <typename Executor>
void GroupPass<Executor>::record_pushes(bool ends) {
  if (setup_.input.pushed == nullptr) return;
  loops_.each_contact_block([&](std::size_t begin, std::size_t end) {
    parts_.contacts.record_pushes(begin, end);
    if (ends) parts_.contacts.add_impulses(begin, end);
  });
}

template <typename Executor>
void GroupPass<Executor>::integrate_positions() {
  loops_.each_body_block([&](std::size_t begin, std::size_t end) {
    setup_.kernels.integrate_positions(parts_.bodies, setup_.constants, begin, end);
  });
  if (setup_.sweeps_joints) parts_.joint_inertia.follow(setup_.input, setup_.body_ids, parts_.bodies);
  refresh_joint_rows(true);
  if (setup_.sweeps_tendons) parts_.tendons.move(setup_.joint_step);
}

template <typename Executor>
void GroupPass<Executor>::relax(int number) {
  loops_.each_system([&](DirectJoints& system) { system.solve_positions(setup_.input, number, parts_.bodies); });
  if (setup_.relaxes) {
    Sweep how = {.push = Push::None, .refresh = true, .friction = setup_.friction, .relaxes = true};
    rise(setup_, number + 1, number + 1, how);
    sweep(how, {.refresh = true, .moved = true}, setup_.settings.relax_iterations, number);
  }
  bound_joints(number, 0);
  loops_.each_system([&](DirectJoints& system) { system.relax(setup_.input, number, parts_.bodies); });
}

// A group larger than the caches is checked once a step only: each check would take a tenth of a net's time.
template <typename Executor>
void GroupPass<Executor>::bound_joints(int number, double speed) {
  const bool last = number + 1 == setup_.settings.substeps;
  if (!setup_.bounds_joints || (setup_.group.large && !last)) return;
  parts_.joint_energy.bound(parts_.joined_motion, setup_.joint_step, setup_.kernels, parts_.numbers.first_dynamic(),
                            speed, parts_.bodies, parts_.joints, parts_.tendons);
}

template <typename Executor>
void GroupPass<Executor>::record_joint_impacts() {
  std::atomic<bool> any = false;
  loops_.each_joint_row_block([&](std::size_t begin, std::size_t end) {
    if (parts_.joints.record_impacts(setup_.joint_step, begin, end)) any.store(true, std::memory_order_relaxed);
  });
  joint_impacts_ = any.load(std::memory_order_relaxed);
}

// Bounces coordinates at the ends of their ranges, by a few sweeps that carry nothing over to the next substep.
template <typename Executor>
void GroupPass<Executor>::bounce_joints() {
  SolverBodies& bodies = parts_.bodies;
  const std::vector<VelocityRows> before = bodies.velocity;
  parts_.joints.begin_bounces();
  for (int i = 0; i < tuning::joint_bounce_sweeps; ++i) {
    loops_.each_joint_colour([&](std::size_t begin, std::size_t end) {
      setup_.kernels.sweep_joints(setup_.joint_data, {.moved = true}, begin, end);
    });
  }
  parts_.joints.end_bounces();
  for (std::size_t i = 0; i < before.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      bodies.free_velocity[i].linear[k] += bodies.velocity[i].linear[k] - before[i].linear[k];
      bodies.free_velocity[i].angular[k] += bodies.velocity[i].angular[k] - before[i].angular[k];
    }
  }
}

template <typename Executor>
void GroupPass<Executor>::finish_contacts() {
  loops_.each_contact_block(
      [&](std::size_t begin, std::size_t end) { setup_.kernels.store(setup_.contact_data, begin, end); });
}

template <typename Executor>
void GroupPass<Executor>::solve_systems(int number) {
  loops_.each_system([&](DirectJoints& system) { system.solve_velocities(setup_.input, number, parts_.bodies); });
}

// The factor of a sweep that so many others follow, which smooth what it leaves.
inline float over_relaxation(int sweeps) {
  return 1 + static_cast<float>(sweeps) / (static_cast<float>(sweeps) + tuning::relaxing_sweeps);
}

// Sweeps until the residual is small, or for as often as is asked for. Joints first: contacts are what may not give.
template <typename Executor>
void GroupPass<Executor>::sweep(Sweep how, JointSweep joints, int iterations, int number) {
  how.measures = setup_.settings.tolerance > 0;
  for (int i = 0; i < iterations; ++i) {
    LargestOf residual;
    joints.relaxation = over_relaxation(iterations - 1 - i);
    how.backwards = setup_.relaxes && (number + i) % 2 == 1;
    if (how.push != Push::Split && !how.relaxes) {
      solve_systems(number);
    }
    const int rounds = joint_impacts_ ? tuning::joint_bounce_sweeps : how.relaxes ? tuning::joint_relaxations : 1;
    for (int round = 1; round <= rounds; ++round) {
      joints.refresh &= round == 1;
      joints.carries &= round == 1;
      joints.measures = how.measures && round == rounds;
      loops_.each_joint_colour([&](std::size_t begin, std::size_t end) {
        residual.add(setup_.kernels.sweep_joints(setup_.joint_data, joints, begin, end));
      });
      if (setup_.sweeps_tendons) {
        const float change = parts_.tendons.sweep(setup_.joint_step, parts_.bodies, joints.push);
        if (joints.measures) residual.add(change);
      }
    }
    loops_.each_contact_colour([&](std::size_t begin, std::size_t end) {
      residual.add(setup_.kernels.sweep(setup_.contact_data, how, begin, end));
    });
    ++report_.sweeps;
    if (how.measures && static_cast<double>(residual.value()) <= setup_.settings.tolerance) return;
    how.refresh = joints.refresh = joints.carries = false;  // nothing moves between sweeps
    if (how.push != Push::Bias) continue;
    // Normal impulses that sweep after sweep has found for the friction of the substep before would push bodies over
    // where nothing holds them: a wall trembles from eight such sweeps on.
    how.friction = setup_.friction;
    how.twice = true;
  }
}

}  // namespace atl::solver
