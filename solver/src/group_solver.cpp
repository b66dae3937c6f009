#include <jobs/with_joints.h>
#include <jobs/with_restitution.h>
#include <solver/group_solver.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>

namespace atl::solver {
namespace {

// Stands in for a team where the calling thread does it all.
struct Serial {
  template <typename Body>
  void parallel_for(std::size_t count, std::size_t, const Body& body) {
    if (count > 0) body(std::size_t{0}, count);
  }
};

// Blocks of a few microseconds.
constexpr std::size_t contact_grain = 8;
constexpr std::size_t joint_grain = 24;
constexpr std::size_t joint_row_grain = 4;  // in double, and one by one

// Runs a kernel over the blocks colour by colour.
template <typename Executor, typename Kernel>
void for_each_colour(std::span<const Colour> colours, std::size_t grain, Executor& executor, const Kernel& kernel) {
  for (const Colour& colour : colours) {
    if (colour.serial) {
      kernel(colour.begin_block, colour.end_block);
    } else {
      executor.parallel_for(colour.end_block - colour.begin_block, grain, [&](std::size_t begin, std::size_t end) {
        kernel(colour.begin_block + begin, colour.begin_block + end);
      });
    }
  }
}

// Sums up where the time goes, for those who ask.
class StageClock {
 public:
  StageClock(bool runs, std::array<double, solver_stage_count>& ms) : runs_(runs), ms_(ms) {
    if (runs_) last_ = std::chrono::steady_clock::now();
  }
  void lap(SolverStage stage) {
    if (!runs_) return;
    const auto now = std::chrono::steady_clock::now();
    ms_[static_cast<std::size_t>(stage)] += std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
  }

 private:
  bool runs_;
  std::array<double, solver_stage_count>& ms_;
  std::chrono::steady_clock::time_point last_;
};

// The largest of what several workers find, none of it negative: bit patterns are then in order of the numbers.
class LargestOf {
 public:
  void add(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    std::uint32_t most = bits_.load(std::memory_order_relaxed);
    while (bits > most && !bits_.compare_exchange_weak(most, bits, std::memory_order_relaxed)) {
    }
  }
  float value() const { return std::bit_cast<float>(bits_.load(std::memory_order_relaxed)); }

 private:
  std::atomic<std::uint32_t> bits_{0};
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
  const SolverSettings& settings = input.settings;
  const SubstepConstants constants = SubstepConstants::of(settings, input.dt);
  const std::span<const std::uint32_t> body_ids = input.islands.bodies(group.begin, group.end);
  GroupReport report;
  StageClock clock(settings.profile, report.stage_ms);

  if (contacts == GroupContacts::New) {
    collect_kinematic_bodies(input, group);
    collect_contacts(input, group);
    collect_joints(input, group);
    colouring_.build(contacts_, first_dynamic_, first_dynamic_ + static_cast<std::uint32_t>(body_ids.size()), blocks_);
    if constexpr (with_joints)
      joints_.colour(first_dynamic_, first_dynamic_ + static_cast<std::uint32_t>(body_ids.size()));
  }
  report.surfaces = note_surfaces(input, group);
  report.friction = friction_ || report.surfaces || settings.everything;
  report.restitution = with_restitution && (restitution_ || settings.everything);
  report.colours = colouring_.colours().size();
  report.joints = input.islands.joints(group.begin, group.end).size();
  const bool joined = with_joints && report.joints > 0;
  const bool sweeps_joints = with_joints && !joints_.empty();
  if (sweeps_joints) report.colours = std::max(report.colours, joints_.colours().size());
  clock.lap(SolverStage::Colour);

  const bool splits = settings.stabilisation == Stabilisation::SplitImpulse;
  note_bodies(input, body_ids, report);
  bodies_.reset(first_dynamic_ + body_ids.size(), {.gyroscopic = report.gyroscopic_bodies > 0 || settings.everything,
                                                   .correction = splits,
                                                   .locks = report.locked_bodies > 0 || settings.everything});
  load_kinematic_bodies(input);
  constexpr std::size_t body_grain = 128;
  executor.parallel_for(body_ids.size(), body_grain, [&](std::size_t begin, std::size_t end) {
    load_bodies(input, body_ids, begin, end, input.dt / settings.substeps);
  });
  const JointStep joint_step{input.joints, input.bodies, bodies_, constants, input.dt / settings.substeps};
  if (sweeps_joints) {
    executor.parallel_for(joints_.block_count(), joint_grain,
                          [&](std::size_t begin, std::size_t end) { joints_.prepare(joint_step, begin, end); });
    stiffness_.assign(first_dynamic_ + body_ids.size(), Matrix3::Zero());
    for_each_colour(joints_.colours(), joint_grain, executor, [&](std::size_t begin, std::size_t end) {
      joints_.add_stiffness(joint_step, stiffness_, begin, end);
    });
    executor.parallel_for(body_ids.size(), body_grain,
                          [&](std::size_t begin, std::size_t end) { stiffen_bodies(input, body_ids, begin, end); });
  }
  const Kernels& kernels = input.kernels;
  const std::size_t block_count = colouring_.block_count();
  const ContactKernelData data = kernel_data(input, report, constants, splits);
  constexpr std::size_t block_grain = 16;
  executor.parallel_for(block_count, block_grain,
                        [&](std::size_t begin, std::size_t end) { kernels.prepare(data, begin, end); });
  for (std::size_t b = 0; b < block_count; ++b) report.work.add(blocks_[b]);
  // Of those joints that are solved one by one; without any nothing of them runs.
  const JointKernelData joint_data = joints_.kernel_data(bodies_, constants);
  if (sweeps_joints) {
    executor.parallel_for(joints_.block_count(), joint_grain,
                          [&](std::size_t begin, std::size_t end) { kernels.prepare_joints(joint_data, begin, end); });
  }
  // Joints that hang together and are solved at once.
  const std::span<const std::uint32_t> direct = joined ? joined_motion_.direct() : std::span<const std::uint32_t>();
  const DirectInput direct_input{input.joints, input.bodies, bodies_, input.dt / settings.substeps};
  const auto each_system_of = [&](std::span<const std::uint32_t> components, const auto& stage) {
    if constexpr (!with_joints) return;
    executor.parallel_for(components.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) stage(input.joint_graph->system(components[i]));
    });
  };
  const auto each_system = [&](const auto& stage) { each_system_of(direct, stage); };
  const bool leaps = joined && joined_motion_.any_leaps();
  if (leaps) give_half_kick(body_ids, -0.5f * constants.h);
  if (joined) joined_motion_.note_forces(body_ids, input.bodies, input.gravity);
  each_system([&](DirectJoints& system) {
    system.locate([&](std::uint32_t body) { return local_body(input, group, body); });
    system.begin_step(direct_input);
  });
  clock.lap(SolverStage::Prepare);

  const auto each_colour = [&](const auto& kernel) {
    for_each_colour(colouring_.colours(), contact_grain, executor, kernel);
  };
  const auto each_joint_colour = [&](const auto& kernel) {
    if (sweeps_joints) for_each_colour(joints_.colours(), joint_grain, executor, kernel);
  };
  const auto each_body = [&](const auto& kernel) {
    constexpr std::size_t grain = 256;
    executor.parallel_for(bodies_.padded_count() / block_lanes, grain / block_lanes,
                          [&](std::size_t begin, std::size_t end) { kernel(begin * block_lanes, end * block_lanes); });
  };
  // Sweeps until the residual is small, or for as often as is asked for. Joints first: contacts are what may not give.
  const auto sweep = [&](Sweep how, JointSweep joints, int iterations) {
    how.measures = joints.measures = settings.tolerance > 0;
    for (int i = 0; i < iterations; ++i) {
      LargestOf residual;
      if (how.push != Push::Split) {
        if (joints.bias) each_system([&](DirectJoints& system) { system.solve_velocities(direct_input); });
        each_joint_colour([&](std::size_t begin, std::size_t end) {
          residual.add(kernels.sweep_joints(joint_data, joints, begin, end));
        });
      }
      each_colour([&](std::size_t begin, std::size_t end) { residual.add(kernels.sweep(data, how, begin, end)); });
      ++report.sweeps;
      if (how.measures && static_cast<double>(residual.value()) <= settings.tolerance) return;
      how.refresh = joints.refresh = joints.carries = false;  // nothing moves between sweeps
    }
  };
  const Friction friction = !report.friction ? Friction::None : settings.pyramid ? Friction::Pyramid : Friction::Cone;
  const bool relaxes = settings.stabilisation == Stabilisation::Soft && settings.relax_iterations > 0;

  for (int substep = 0; substep < settings.substeps; ++substep) {
    const bool carry_over = settings.warm_starting && substep > 0;
    each_body([&](std::size_t begin, std::size_t end) {
      kernels.integrate_velocities(bodies_, constants, carry_over, begin, end);
    });
    clock.lap(SolverStage::Integrate);
    if (!settings.warm_starting) {
      clear_impulses(report);
      if (sweeps_joints) joints_.clear_impulses(0, joints_.block_count());
    } else if (substep == 0) {
      each_joint_colour([&](std::size_t begin, std::size_t end) { kernels.warm_start_joints(joint_data, begin, end); });
      each_colour([&](std::size_t begin, std::size_t end) { kernels.warm_start(data, begin, end); });
    }
    each_system([&](DirectJoints& system) { system.begin_substep(); });
    clock.lap(SolverStage::WarmStart);

    // The relaxing sweeps' friction is carried over; a contact that has just begun has none yet to carry.
    const Friction solved_friction = relaxes && carry_over ? Friction::None : friction;
    // Where sweeps relax they have seen the positions that the last substep ended with.
    const bool refresh = !relaxes && substep > 0;
    const bool twice = !(relaxes && carry_over);
    sweep({splits ? Push::None : Push::Bias, refresh, solved_friction, twice},
          {.bias = true, .refresh = refresh, .carries = carry_over}, settings.iterations);
    if (splits) {
      each_body([&](std::size_t begin, std::size_t end) { kernels.clear_corrections(bodies_, begin, end); });
      clear_split_impulses();
      bodies_.velocity.swap(bodies_.correction);
      // Rigid contacts have no softness to forgive what a round over the points leaves.
      sweep({Push::Split, false, Friction::None, true}, {}, settings.iterations);
      bodies_.velocity.swap(bodies_.correction);
    }
    // What contacts have done to one link is not to turn it far out of its joints before these see it.
    if (joined) {
      each_system_of(joined_motion_.touched_direct(),
                     [&](DirectJoints& system) { system.solve_velocities(direct_input); });
    }
    clock.lap(SolverStage::Solve);
    each_body([&](std::size_t begin, std::size_t end) { kernels.integrate_positions(bodies_, constants, begin, end); });
    if (sweeps_joints && joints_.has_rows()) {
      executor.parallel_for(joints_.block_count(), joint_row_grain,
                            [&](std::size_t begin, std::size_t end) { joints_.refresh_rows(joint_step, begin, end); });
    }
    clock.lap(SolverStage::Integrate);
    each_system([&](DirectJoints& system) { system.solve_positions(direct_input); });
    if (relaxes) {
      sweep({Push::None, true, friction}, {.bias = false, .refresh = true, .carries = false},
            settings.relax_iterations);
    }
    each_system([&](DirectJoints& system) { system.relax(direct_input); });
    clock.lap(SolverStage::Relax);
  }
  if (input.capture != nullptr) capture(input, report, body_ids);
  if (report.restitution) {
    each_colour([&](std::size_t begin, std::size_t end) { kernels.restitute(data, begin, end); });
  }
  clock.lap(SolverStage::Restitution);
  // Nothing is done about a large island that wasn't built to stand.
  const bool notes_overloads = !group.large || group.remedy != Remedy::None;
  executor.parallel_for(block_count, block_grain, [&](std::size_t begin, std::size_t end) {
    kernels.store(data, begin, end);
    if (notes_overloads) note_overloads(input, body_ids, begin, end);
  });
  each_system([&](DirectJoints& system) { system.end_step(direct_input); });
  if (leaps) give_half_kick(body_ids, 0.5f * constants.h);
  if (joined) {
    each_system_of(joined_motion_.disturbed_direct(), [&](DirectJoints& system) { system.project(direct_input); });
  }
  executor.parallel_for(body_ids.size(), body_grain,
                        [&](std::size_t begin, std::size_t end) { write_back(input, body_ids, joined, begin, end); });
  each_system([&](DirectJoints& system) { system.settle(direct_input, input.bodies, input.dt, input.fast); });
  if (sweeps_joints) {
    executor.parallel_for(joints_.block_count(), joint_grain,
                          [&](std::size_t begin, std::size_t end) { joints_.store(joint_step, begin, end); });
  }
  clock.lap(SolverStage::Store);
  return report;
}

// Which kernels the group's bodies call for.
void GroupSolver::note_bodies(const SolveInput& input, std::span<const std::uint32_t> bodies, GroupReport& report) {
  bodies_.balls = false;
  for (const std::uint32_t body : bodies) {
    report.gyroscopic_bodies += input.bodies.gyroscopic[body];
    report.locked_bodies += input.bodies.locks[body] != 0;
    bodies_.balls |= input.bodies.ball[body] != 0;
  }
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
          .split_blocks = one_a_block(split_blocks_, splits),
          .planar_blocks = one_a_block(planar_blocks_, !bodies_.locks.empty()),
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
