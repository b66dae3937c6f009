#pragma once
/// A group's step, once its bodies, contacts and joints are gathered: prepare, substeps, finish.

#include <jobs/with_joints.h>
#include <solver/sweep/group_solver.h>
#include <solver/tuning.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>

namespace atl::solver {

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

/// `Executor` shares a loop out, or runs it: jobs::WorkerTeam, or what stands in for one.
template <typename Executor>
class GroupSolver::Pass {
 public:
  /// Of a group that was gathered; `report` says what it needs.
  Pass(GroupSolver& solver, const SolveInput& input, const IslandGroup& group, const SubstepConstants& constants,
       Executor& executor, StageClock& clock, GroupReport& report)
      : solver_(solver),
        input_(input),
        group_(group),
        settings_(input.settings),
        kernels_(input.kernels),
        constants_(constants),
        executor_(executor),
        clock_(clock),
        report_(report),
        body_ids_(input.islands.bodies(group.begin, group.end)),
        block_count_(solver.colouring_.block_count()),
        splits_(settings_.stabilisation == Stabilisation::SplitImpulse),
        relaxes_(settings_.stabilisation == Stabilisation::Soft && settings_.relax_iterations > 0),
        joined_(with_joints && report.joints > 0),
        sweeps_joints_(with_joints && !solver.joints_.empty()),
        leaps_(joined_ && solver.joined_motion_.any_leaps()),
        friction_(!report.friction    ? Friction::None
                  : settings_.pyramid ? Friction::Pyramid
                                      : Friction::Cone),
        joint_step_{input.joints, input.bodies, solver.bodies_, constants, input.dt / settings_.substeps},
        direct_input_{input.joints, input.bodies, solver.bodies_, input.dt / settings_.substeps},
        data_(solver.kernel_data(input, report, constants, splits_)),
        joint_data_(solver.joints_.kernel_data(solver.bodies_, constants)) {}

  void prepare();
  void substep(int number);
  void finish();

 private:
  // In blocks, or what else is counted, of a few microseconds.
  static constexpr std::size_t contact_grain = 8;
  static constexpr std::size_t block_grain = 16;
  static constexpr std::size_t joint_grain = 24;
  static constexpr std::size_t joint_row_grain = 4;  // in double, and one by one
  static constexpr std::size_t body_block_grain = 256 / block_lanes;

  // Runs a kernel over the blocks colour by colour.
  template <typename Kernel>
  void for_each_colour(std::span<const Colour> colours, std::size_t grain, const Kernel& kernel) {
    for (const Colour& colour : colours) {
      if (colour.serial) {
        kernel(colour.begin_block, colour.end_block);
      } else {
        executor_.parallel_for(colour.end_block - colour.begin_block, grain, [&](std::size_t begin, std::size_t end) {
          kernel(colour.begin_block + begin, colour.begin_block + end);
        });
      }
    }
  }
  template <typename Kernel>
  void each_colour(const Kernel& kernel) {
    for_each_colour(solver_.colouring_.colours(), contact_grain, kernel);
  }
  // Of joints that are solved one by one; without any nothing of them runs.
  template <typename Kernel>
  void each_joint_colour(const Kernel& kernel) {
    if (sweeps_joints_) for_each_colour(solver_.joints_.colours(), joint_grain, kernel);
  }
  template <typename Kernel>
  void each_joint_block(std::size_t grain, const Kernel& kernel) {
    if (sweeps_joints_) executor_.parallel_for(solver_.joints_.block_count(), grain, kernel);
  }
  template <typename Kernel>
  void each_body_block(const Kernel& kernel) {
    executor_.parallel_for(solver_.bodies_.padded_count() / block_lanes, body_block_grain,
                           [&](std::size_t begin, std::size_t end) { kernel(begin * block_lanes, end * block_lanes); });
  }
  // Joints that hang together and are solved at once.
  template <typename Stage>
  void each_system_of(std::span<const std::uint32_t> components, const Stage& stage) {
    if constexpr (!with_joints) return;
    executor_.parallel_for(components.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) stage(input_.joint_systems->of(components[i]));
    });
  }
  template <typename Stage>
  void each_system(const Stage& stage) {
    if (joined_) each_system_of(solver_.joined_motion_.direct(), stage);
  }

  void prepare_joints();
  void prepare_systems();
  void warm_start(int number);
  void sweep(Sweep how, JointSweep joints, int iterations, int number);
  void rise(Sweep& how, double at, double after) const;
  void solve_velocities(int number, bool carries);
  void split_off_corrections(int number);
  void integrate_positions();
  void relax(int number);
  void bounce(bool last);
  void note_joint_impacts();
  void bounce_joints();

  GroupSolver& solver_;
  const SolveInput& input_;
  const IslandGroup& group_;
  const SolverSettings& settings_;
  const Kernels& kernels_;
  const SubstepConstants& constants_;
  Executor& executor_;
  StageClock& clock_;
  GroupReport& report_;
  const std::span<const std::uint32_t> body_ids_;
  const std::size_t block_count_;
  const bool splits_;         // impulses that push apart are kept from those that last
  const bool relaxes_;        // what soft contacts pushed is taken back
  const bool joined_;         // there are joints
  const bool sweeps_joints_;  // some are solved one by one
  const bool leaps_;
  bool joint_impacts_ = false;  // some coordinate bounces at the end of its range in this substep
  const Friction friction_;
  const JointStep joint_step_;
  const DirectInput direct_input_;
  const ContactKernelData data_;
  const JointKernelData joint_data_;
};

template <typename Executor>
void GroupSolver::Pass<Executor>::prepare() {
  if (sweeps_joints_) prepare_joints();
  executor_.parallel_for(block_count_, block_grain,
                         [&](std::size_t begin, std::size_t end) { kernels_.prepare(data_, begin, end); });
  for (std::size_t b = 0; b < block_count_; ++b) report_.work.add(solver_.blocks_[b]);
  each_joint_block(joint_grain,
                   [&](std::size_t begin, std::size_t end) { kernels_.prepare_joints(joint_data_, begin, end); });
  if (joined_) prepare_systems();
  clock_.lap(SolverStage::Prepare);
}

// How stiff joints are counts as inertia of the bodies that they pull on.
template <typename Executor>
void GroupSolver::Pass<Executor>::prepare_joints() {
  each_joint_block(joint_grain,
                   [&](std::size_t begin, std::size_t end) { solver_.joints_.prepare(joint_step_, begin, end); });
  solver_.stiffness_.assign(solver_.first_dynamic_ + body_ids_.size(), Matrix3::Zero());
  each_joint_colour([&](std::size_t begin, std::size_t end) {
    solver_.joints_.add_stiffness(joint_step_, solver_.stiffness_, begin, end);
  });
  executor_.parallel_for(body_ids_.size(), body_grain, [&](std::size_t begin, std::size_t end) {
    solver_.stiffen_bodies(input_, body_ids_, begin, end);
  });
  solver_.find_followers(input_, body_ids_);
}

template <typename Executor>
void GroupSolver::Pass<Executor>::prepare_systems() {
  if (leaps_) solver_.give_half_kick(body_ids_, -0.5f * constants_.h);
  solver_.joined_motion_.note_forces(body_ids_, input_.bodies, input_.gravity);
  each_system([&](DirectJoints& system) {
    system.locate([&](std::uint32_t body) { return solver_.local_body(input_, group_, body); });
    system.begin_step(direct_input_);
  });
  each_system_of(solver_.joined_motion_.untouched_direct(),
                 [&](DirectJoints& system) { system.kick_springs(direct_input_, -1); });
  each_system([&](DirectJoints& system) { system.note_rates(direct_input_); });
}

template <typename Executor>
void GroupSolver::Pass<Executor>::substep(int number) {
  const bool carries = settings_.warm_starting && number > 0;  // impulses of the last substep
  if (sweeps_joints_ && solver_.joints_.has_rows()) {
    each_joint_block(joint_row_grain,
                     [&](std::size_t begin, std::size_t end) { solver_.joints_.note_rates(joint_step_, begin, end); });
  }
  if (report_.restitution && number > 0) {
    executor_.parallel_for(block_count_, block_grain, [&](std::size_t begin, std::size_t end) {
      kernels_.note_approaches(data_, number, begin, end);
    });
  }
  each_body_block([&](std::size_t begin, std::size_t end) {
    kernels_.integrate_velocities(solver_.bodies_, constants_, carries, begin, end);
  });
  clock_.lap(SolverStage::Integrate);
  warm_start(number);
  if (sweeps_joints_ && solver_.joints_.may_bounce()) note_joint_impacts();
  clock_.lap(SolverStage::WarmStart);
  solve_velocities(number, carries);
  if (splits_) split_off_corrections(number);
  // What contacts have done to one link is not to turn it far out of its joints before these see it.
  if (joined_) {
    each_system_of(solver_.joined_motion_.touched_direct(),
                   [&](DirectJoints& system) { system.solve_velocities(direct_input_); });
  }
  clock_.lap(SolverStage::Solve);
  integrate_positions();
  clock_.lap(SolverStage::Integrate);
  relax(number);
  clock_.lap(SolverStage::Relax);
  const bool last = number + 1 == settings_.substeps;
  if (last && input_.capture != nullptr) solver_.capture(input_, report_, body_ids_);
  if (report_.restitution) bounce(last);
  if (joint_impacts_) bounce_joints();
  clock_.lap(SolverStage::Restitution);
}

template <typename Executor>
void GroupSolver::Pass<Executor>::warm_start(int number) {
  if (!settings_.warm_starting) {
    solver_.clear_impulses(report_);
    if (sweeps_joints_) solver_.joints_.clear_impulses(0, solver_.joints_.block_count());
  } else if (number == 0) {
    each_joint_colour([&](std::size_t begin, std::size_t end) { kernels_.warm_start_joints(joint_data_, begin, end); });
    each_colour([&](std::size_t begin, std::size_t end) { kernels_.warm_start(data_, begin, end); });
  }
  each_system([&](DirectJoints& system) { system.begin_substep(); });
}

// Sweeps until the residual is small, or for as often as is asked for. Joints first: contacts are what may not give.
template <typename Executor>
void GroupSolver::Pass<Executor>::sweep(Sweep how, JointSweep joints, int iterations, int number) {
  how.measures = joints.measures = settings_.tolerance > 0;
  for (int i = 0; i < iterations; ++i) {
    LargestOf residual;
    how.backwards = relaxes_ && (number + i) % 2 == 1;
    if (how.push != Push::Split) {
      if (joints.bias) each_system([&](DirectJoints& system) { system.solve_velocities(direct_input_); });
      each_joint_colour([&](std::size_t begin, std::size_t end) {
        residual.add(kernels_.sweep_joints(joint_data_, joints, begin, end));
      });
    }
    each_colour([&](std::size_t begin, std::size_t end) { residual.add(kernels_.sweep(data_, how, begin, end)); });
    ++report_.sweeps;
    if (how.measures && static_cast<double>(residual.value()) <= settings_.tolerance) return;
    how.refresh = joints.refresh = joints.carries = false;  // nothing moves between sweeps
  }
}

// Of surfaces that bend, whose speeds are those `at` substeps into the step, and whose places `after` as many.
template <typename Executor>
void GroupSolver::Pass<Executor>::rise(Sweep& how, double at, double after) const {
  const double substeps = settings_.substeps;
  how.rise_part = static_cast<float>(2 * at / substeps - 1);
  how.rise_time = static_cast<float>(after / substeps * (after / substeps - 1) * input_.dt);
}

template <typename Executor>
void GroupSolver::Pass<Executor>::solve_velocities(int number, bool carries) {
  // The relaxing sweeps' friction is carried over; a contact that has just begun has none yet to carry.
  const Friction friction = relaxes_ && carries ? Friction::None : friction_;
  // Where sweeps relax they have seen the positions that the last substep ended with.
  const bool refresh = !relaxes_ && number > 0;
  const bool twice = !(relaxes_ && carries);
  Sweep how = {splits_ ? Push::None : Push::Bias, refresh, friction, twice};
  rise(how, number + 0.5, number);
  sweep(how, {.bias = true, .refresh = refresh, .carries = carries}, settings_.iterations, number);
}

// The same sweeps over velocities of their own, which move bodies and are forgotten.
template <typename Executor>
void GroupSolver::Pass<Executor>::split_off_corrections(int number) {
  each_body_block([&](std::size_t begin, std::size_t end) { kernels_.clear_corrections(solver_.bodies_, begin, end); });
  solver_.clear_split_impulses();
  solver_.bodies_.velocity.swap(solver_.bodies_.correction);
  // Rigid contacts have no softness to forgive what a round over the points leaves.
  sweep({Push::Split, false, Friction::None, true}, {}, settings_.iterations, number);
  solver_.bodies_.velocity.swap(solver_.bodies_.correction);
}

template <typename Executor>
void GroupSolver::Pass<Executor>::integrate_positions() {
  each_body_block([&](std::size_t begin, std::size_t end) {
    kernels_.integrate_positions(solver_.bodies_, constants_, begin, end);
  });
  if (sweeps_joints_) solver_.follow_inertia(input_, body_ids_);
  if (solver_.joints_.has_rows()) {
    each_joint_block(joint_row_grain, [&](std::size_t begin, std::size_t end) {
      solver_.joints_.refresh_rows(joint_step_, begin, end);
    });
  }
}

template <typename Executor>
void GroupSolver::Pass<Executor>::relax(int number) {
  each_system([&](DirectJoints& system) { system.solve_positions(direct_input_); });
  if (relaxes_) {
    Sweep how = {.push = Push::None, .refresh = true, .friction = friction_, .relaxes = true};
    rise(how, number + 1, number + 1);
    sweep(how, {.bias = false, .refresh = true, .carries = false}, settings_.relax_iterations, number);
  }
  each_system([&](DirectJoints& system) { system.relax(direct_input_); });
}

template <typename Executor>
void GroupSolver::Pass<Executor>::bounce(bool last) {
  each_colour([&](std::size_t begin, std::size_t end) { kernels_.restitute(data_, friction_, last, begin, end); });
  if (!joined_) return;
  each_system_of(solver_.joined_motion_.bouncing_direct(),
                 [&](DirectJoints& system) { system.project(direct_input_); });
}

template <typename Executor>
void GroupSolver::Pass<Executor>::note_joint_impacts() {
  std::atomic<bool> any = false;
  each_joint_block(joint_row_grain, [&](std::size_t begin, std::size_t end) {
    if (solver_.joints_.note_impacts(joint_step_, begin, end)) any.store(true, std::memory_order_relaxed);
  });
  joint_impacts_ = any.load(std::memory_order_relaxed);
}

// At the ends of their ranges, by a few sweeps of which the next substep carries nothing over.
template <typename Executor>
void GroupSolver::Pass<Executor>::bounce_joints() {
  SolverBodies& bodies = solver_.bodies_;
  const std::vector<VelocityRows> before = bodies.velocity;
  solver_.joints_.begin_bounces();
  for (int i = 0; i < tuning::joint_bounce_sweeps; ++i) {
    each_joint_colour([&](std::size_t begin, std::size_t end) {
      kernels_.sweep_joints(joint_data_, {.bias = false, .refresh = false, .carries = false}, begin, end);
    });
  }
  solver_.joints_.end_bounces();
  for (std::size_t i = 0; i < before.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      bodies.free_velocity[i].linear[k] += bodies.velocity[i].linear[k] - before[i].linear[k];
      bodies.free_velocity[i].angular[k] += bodies.velocity[i].angular[k] - before[i].angular[k];
    }
  }
}

template <typename Executor>
void GroupSolver::Pass<Executor>::finish() {
  // Nothing is done about a large island that wasn't built to stand.
  const bool notes_overloads = !group_.large || settings_.finer > 1;
  executor_.parallel_for(block_count_, block_grain, [&](std::size_t begin, std::size_t end) {
    kernels_.store(data_, begin, end);
    if (notes_overloads) solver_.note_overloads(input_, body_ids_, begin, end);
  });
  each_system([&](DirectJoints& system) { system.end_step(direct_input_); });
  if (joined_) {
    const std::span<const std::uint32_t> leaping = solver_.joined_motion_.untouched_direct();
    each_system_of(leaping, [&](DirectJoints& system) { system.kick_springs(direct_input_, 1); });
    if (leaps_) solver_.give_half_kick(body_ids_, 0.5f * constants_.h);
    each_system_of(leaping, [&](DirectJoints& system) { system.project(direct_input_); });
  }
  executor_.parallel_for(body_ids_.size(), body_grain, [&](std::size_t begin, std::size_t end) {
    solver_.write_back(input_, body_ids_, joined_, begin, end);
  });
  each_system([&](DirectJoints& system) {
    system.settle(direct_input_, input_.bodies, input_.bounds, input_.dt, input_.fast);
  });
  each_joint_block(joint_grain,
                   [&](std::size_t begin, std::size_t end) { solver_.joints_.store(joint_step_, begin, end); });
  clock_.lap(SolverStage::Store);
}

}  // namespace atl::solver
