#pragma once

#include <vector>

#include "step/contact_phase.h"
#include "step/contact_rules.h"
#include "step/continuous_phase.h"
#include "step/island_phase.h"
#include "step/solve_phase.h"
#include "step/step_context.h"
#include "world/containment.h"
#include "world/stores.h"

namespace atl {

/// Memory that a step needs and the next one doesn't: of the thread that makes it, for all worlds that it steps.
struct StepMemory {
  solver::FastBodies moved{0};  ///< bodies that moved far by the solve, or whose joints did, by worker
  ContinuousPhase continuous{0};

  void begin(int threads);
};

/// The phases of a step, with what they keep for the next one. Nothing of that is part of a world's state.
class StepPipeline {
 public:
  /// Ahead of a step's first substep. A law that threw may have ended the last step before its contacts were told.
  void begin_step() { hits_.clear(); }
  /// A step of world.clock.dt seconds, maybe one substep of a step under a force law.
  void run(Stores& world, const StepContext& step);
  /// Drops what is kept from step to step, after the state was replaced.
  void forget() { contacts_.forget(); }

  const ContactPhase& contacts() const { return contacts_; }
  const IslandPhase& islands() const { return islands_; }
  IslandPhase& islands() { return islands_; }
  const SolvePhase& solve() const { return solve_; }
  /// See jobs/arrays.h: what contacts have done since events were noted.
  auto event_arrays() const { return std::tie(hits_, velocities_); }

 private:
  void plan(Stores& world, const StepContext& step);
  void build_islands(Stores& world, const StepContext& step);
  void solve_islands(Stores& world, const StepContext& step, StepMemory& memory);
  void follow_fast_bodies(Stores& world, const StepContext& step, StepMemory& memory);
  void finish(Stores& world, const StepContext& step);

  ContactPhase contacts_;
  IslandPhase islands_;
  SolvePhase solve_;
  std::vector<QuarantineFault> broken_;  // bodies that the solve left unsound, in order
  std::vector<ContactHit> hits_;
  std::vector<BodyVelocity> velocities_;  // of active bodies before the solve, while somebody asks for events
  bool rebuilt_ = false;                  // whether islands were, in some substep since events were noted
};

/// Fills step.report with the features that the step ran, and why: the plan as data.
void report_features(const Stores& world, const StepPipeline& pipeline, const ContactRules& rules, bool records,
                     StepReport& report);

}  // namespace atl
