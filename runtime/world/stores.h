#pragma once

#include <atoll/settings.h>
#include <atoll/world.h>
#include <collision/broadphase/broadphase.h>
#include <collision/contacts/body_aabbs.h>
#include <collision/contacts/contact_cache.h>
#include <collision/contacts/update_contacts.h>
#include <collision/shapes/collider_table.h>
#include <solver/constraints/surface_contact.h>
#include <solver/integrate/body_table.h>
#include <solver/select/solver_selection.h>
#include <solver/select/substep_control.h>

#include <cstdint>
#include <tuple>
#include <vector>

#include "world/active_bodies.h"
#include "world/body_records.h"
#include "world/contact_choices.h"
#include "world/contact_events.h"
#include "world/joint_table.h"
#include "world/quarantine.h"
#include "world/sleeping.h"

namespace atl {

/// Steps and their lengths.
struct StepClock {
  std::int64_t steps = 0;   ///< begun so far
  double dt = 0;            ///< s, of the step in progress, or else of the last one; 0 before the first
  double last_dt = 0;       ///< s, of the last one that ended
  double last_substep = 0;  ///< s, of that
  double time = 0;          ///< s, sum of all steps that ended
};

/// The changes since the last step.
struct Changes {
  std::vector<std::uint32_t> may_start_or_stop;  ///< bodies that came, went or got a velocity
  std::vector<std::uint32_t> pushed;             ///< bodies with a force or torque on them
  bool islands = true;                           ///< bodies started, stopped, came or went
  bool joints = false;                           ///< joints came, went or changed
};

/// Accelerations of all bodies, 3 numbers each; during a step, the velocities at its start. Empty unless asked for.
struct Accelerations {
  std::vector<double> linear;   ///< m/s^2
  std::vector<double> angular;  ///< rad/s^2

  auto arrays() const { return std::tie(linear, angular); }
};

/// Results of the last step that callers can ask for.
struct StepResults {
  ContactEvents contact_events;
  ContactEvents unasked_events;  ///< that nobody asked for, where everything is run
  SensorEvents sensor_events;
  std::vector<JointEvent> joint_events;
  std::vector<SleepEvent> sleep_events;
  std::vector<SolverChoice> solver_choices;
  std::vector<MissedTarget> missed_targets;
  std::vector<ContactForce> contact_forces;  ///< made when asked for
  bool contact_forces_valid = false;
  std::vector<PairForce> pair_forces;  ///< likewise, each time
  bool captured = false;               ///< whether there is a contact problem
  Accelerations accelerations;
};

/// All that a world keeps from step to step. Each store owns its data; what concerns several of them at once are
/// functions beside them: bodies.h, colliders.h, joints.h, containment.h. What lasts of it is told by visit_world
/// (state/world_state.h), which names every store.
struct Stores {
  Vector3 gravity = Vector3::Zero();  ///< m/s^2
  Settings settings = {};
  StepClock clock = {};

  solver::BodyTable bodies = {};
  BodyRecords records = {};
  Contents contents = {};
  JointTable joints = {};

  collision::ColliderTable colliders = {};
  collision::Broadphase broadphase = {};
  collision::BodyAabbs aabbs = {};
  collision::ContactCache cache = {};
  ContactChoices choices = {};
  std::vector<MaterialPair> material_pairs = {};              ///< the lower id first, in order
  std::vector<solver::SurfaceContact> surface_contacts = {};  ///< by contact slot; empty while all surfaces are plain

  ActiveBodies active = {};
  std::vector<collision::StepReach> reaches = {};  ///< by body, in the step in progress; zero unless active
  Sleeping sleeping = {};
  QuarantineList quarantine = {};
  solver::SolverSelection selection = {};
  solver::SubstepControl control = {};

  Changes changes = {};
  StepResults results = {};
};

}  // namespace atl
