#pragma once

#include <atoll/world.h>
#include <collision/broadphase/broadphase.h>
#include <collision/contacts/body_aabbs.h>
#include <collision/contacts/contact_cache.h>
#include <collision/contacts/update_contacts.h>
#include <collision/continuous/continuous_collision.h>
#include <collision/shapes/collider_table.h>
#include <jobs/append.h>
#include <jobs/arena.h>
#include <jobs/scratch.h>
#include <jobs/shared_values.h>
#include <solver/direct/direct_island.h>
#include <solver/direct/joint_systems.h>
#include <solver/integrate/body_table.h>
#include <solver/islands/islands.h>
#include <solver/islands/joint_graph.h>
#include <solver/select/solver_selection.h>
#include <solver/sweep/group_solver.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "state/roster.h"
#include "step/contact_events.h"
#include "world/active_bodies.h"
#include "world/body_definition.h"
#include "world/constants_pool.h"
#include "world/joint_table.h"
#include "world/quarantine.h"
#include "world/sleeping.h"

namespace atl {

/// What users add to a body that the solver's table doesn't hold, one entry a body index.
struct BodyRecords {
  std::vector<std::uint32_t> generation;
  std::vector<std::uint8_t> alive;
  std::vector<BodyType> type;
  std::vector<std::uint8_t> dynamic;  ///< 1 for dynamic bodies
  jobs::SharedValues<Material> material;
  /// m, of mass, body frame
  jobs::SharedValues<Vector3> centre = jobs::SharedValues<Vector3>(Vector3::Zero());
  std::vector<std::uint8_t> continuous;
  std::vector<std::shared_ptr<const BodyConstants>> constants;  ///< of those alive
  /// Bodies that were told not to touch a body, of those that were.
  std::map<std::uint32_t, std::vector<std::uint32_t>> ignored;
  std::vector<std::uint32_t> free;  ///< indices of removed bodies; the last is used first
  std::size_t count = 0;            ///< alive

  void resize(std::size_t bodies);
  std::size_t bytes() const;  // memory.cpp
};

inline solver::Mobility mobility_of(BodyType type) {
  switch (type) {
    case BodyType::Static:
      return solver::Mobility::Fixed;
    case BodyType::Kinematic:
      return solver::Mobility::Kinematic;
    case BodyType::Dynamic:
      break;
  }
  return solver::Mobility::Dynamic;
}

/// Which optional stages the world's bodies call for. Kept up to date as bodies come and go.
struct Contents {
  std::size_t kinematic = 0;
  std::size_t with_friction = 0;
  std::size_t with_restitution = 0;
  std::size_t gyroscopic = 0;
  std::size_t smooth_surfaces = 0;

  void count(const solver::BodyTable& bodies, const BodyRecords& records, std::uint32_t body, int sign);
};

class StateHash;
class Recorder;
struct RecordedBody;

class World::Impl {
 public:
  explicit Impl(const WorldDef& def);
  ~Impl();

  // The step and its phases: step.cpp.
  template <typename Step>
  StepReport take_step(double dt, bool forced, const Step& step);  // world.cpp
  StepReport step(double dt);
  void begin_step();
  /// By dt seconds of the step that has begun, maybe all of it. Its events wait for its end.
  StepReport advance(double dt, int substeps, bool ends_step);

  // Bodies: bodies.cpp.
  BodyId add_body(const CheckedBody& start);
  void remove_body(BodyId id);
  std::uint32_t index_of(BodyId id, const char* call) const;
  std::uint32_t awaken(BodyId id, const char* call);
  std::uint32_t awaken(std::uint32_t body);
  void apply_force(std::uint32_t body, const Vector3& force, const Vector3& torque);
  void apply_impulse(std::uint32_t body, const Vector3& impulse, const Vector3& moment);  // N s, N m s
  Pose pose(BodyId id) const;
  void set_pose(BodyId id, const Pose& pose);
  void set_surface(std::uint32_t body, const solver::Surface& surface);
  void set_surface_velocity(BodyId id, const Vector3& velocity);
  void set_filter(BodyId id, const CollisionFilter& filter);
  void set_collision_enabled(BodyId a, BodyId b, bool enabled);
  void wake_all();
  void wake_touching(std::uint32_t body);
  void release_body(BodyId id);  // quarantine.cpp
  void take_in_boxes();          // colliders.cpp

  // Joints: joints.cpp.
  JointId add_joint(const JointDef& def);
  void remove_joint(std::uint32_t joint);
  bool contains(JointId id) const;
  std::uint32_t index_of(JointId id, const char* call) const;
  JointState joint_state(std::uint32_t joint) const;
  void set_joint(std::uint32_t joint, const JointKind& kind);
  void set_joint_enabled(std::uint32_t joint, bool enabled);
  void solve_joints_anew() { joints_stale_ = joints.size() > 0; }
  std::span<const JointEvent> joint_events() const { return joint_events_; }

  // Snapshots: restore.cpp.
  const std::shared_ptr<const Roster>& roster() const;
  std::uint64_t serial() const { return serial_; }
  std::size_t save_state(std::vector<std::byte>& bytes) const;  // the number of those that it wrote
  /// `origin` is the serial number of the world that was saved.
  void restore(const std::shared_ptr<const Roster>& saved, std::uint64_t origin, std::span<const std::byte> state);
  /// Throws Error if that is no state of such bodies.
  static void try_out(const std::shared_ptr<const Roster>& roster, std::span<const std::byte> state);

  // Recordings: recording.cpp.
  void record(const std::string& path, const RecordingOptions& options);
  void record_state();
  void stop_recording(const char* call);
  void end_recording();  // as the world ends
  std::vector<RecordedBody> recorded_bodies() const;
  void record_result();  // of a step

  // Results: contact_forces.cpp, contact_problem.cpp, restore.cpp.
  std::span<const ContactForce> contact_forces();
  void place_idle_contacts();
  ContactProblem contact_problem() const;
  std::span<const ContactEvent> contact_events() const { return events_.told; }
  std::span<const EscalatedIsland> escalated_islands() const { return escalated_; }
  std::vector<MemoryUse> memory() const;  // memory.cpp
  std::uint64_t state_hash() const;
  std::vector<BodyHash> body_hashes() const;
  BodyHash body_hash(std::uint32_t body) const;

  Vector3 gravity;
  Settings settings;
  const solver::Kernels* kernels;
  const collision::NarrowphaseKernels* narrowphase_kernels;
  jobs::Arena arena;

  solver::BodyTable bodies;
  collision::ColliderTable colliders;
  BodyRecords records;
  Contents contents;
  JointTable joints;
  Sleeping sleeping;
  QuarantineList quarantine;
  collision::Broadphase broadphase;
  collision::BodyAabbs aabbs;
  collision::ContactCache cache;

  std::unique_ptr<Recorder> recorder;  // null while nothing is recorded

 private:
  template <typename Archive, typename AnyWorld>
  friend class WorldState;
  friend class ForcedStep;

  void plan();
  void find_pairs();
  void update_contacts();
  void build_islands();
  void solve_islands();
  void follow_fast_bodies();
  void sweep_fast_bodies();
  void finish();

  void resize_bodies(std::size_t count);
  void give_constants(std::uint32_t body, const std::shared_ptr<const BodyConstants>& constants);
  void take_out(std::uint32_t body);
  void add_colliders(std::uint32_t body);
  void note_size(std::uint32_t body);
  void remove_colliders(std::uint32_t body);
  void add_proxies(std::uint32_t body, const collision::Filter& filter);
  void add_box(std::uint32_t collider, const collision::Aabb& box, const collision::Filter& filter);
  collision::BodyMotions motions() const;
  void move_proxies(std::uint32_t body);
  bool may_move(std::uint32_t body) const;
  bool update_active_bodies();
  collision::ContactUpdateInput contact_input() const;
  void note_arrival_or_departure(std::uint32_t body);
  void note_reaches();
  void note_what_began_and_ended();
  void note_events(ContactEvents& events);
  collision::FastBody fast_body(const solver::MovedBody& moved) const;
  void list_fast_bodies();
  void list_carried(std::span<const collision::CcdStop> stops);
  std::uint32_t assembly_of(std::uint32_t body) const;
  void stop(const collision::CcdStop& stop);
  void follow_position(solver::Joint& joint) const;
  void wake_touched_sleepers();
  void remove_lost_contacts();
  solver::SolverSettings how() const;  // the step in progress is solved
  bool escalates() const;
  void choose_modes();
  solver::SolveMode mode_of(const solver::IslandGroup& group) const;
  void solve_groups();
  void prepare_direct_solvers();
  bool solve_directly(const solver::SolveInput& input, std::size_t group);
  void note_modes();
  void move_unconstrained_bodies();
  void note_stages();  // step_plan.cpp

  // Joints: joints.cpp, and in the step joint_step.cpp.
  void check_bodies(const JointDef& def) const;
  void remove_joints_of(std::uint32_t body);
  void joint_changed(std::uint32_t joint);
  void wake_joined_by(std::uint32_t joint);
  void wake_joined(std::uint32_t body);
  void keep_apart(std::uint32_t joint);
  void let_touch(std::uint32_t joint);
  void release(std::uint32_t joint);
  solver::JointFrames frames_of(const solver::Joint& joint) const;
  void update_joint_graph();
  void wake_joined_to_moving();
  std::span<const solver::JointLink> acting_joints() const;
  void count_joints();
  void note_joints();
  void watch_joint(std::uint32_t joint);
  void keep_driven_awake(std::uint32_t joint);

  void keep_belts_awake();

  // Parts of the state: body_hash.cpp.
  struct BodyParts;
  void hash_body(BodyParts& parts, std::uint32_t body) const;
  void hash_contact(StateHash& hash, std::uint32_t slot) const;

  // Containment: quarantine.cpp, and of joints joints.cpp.
  void suspect_new(std::uint32_t body);
  void quarantine_suspects();
  void before_move(std::uint32_t body, const Vector3& position);
  void put_back(std::uint32_t body, const solver::BodyPose& pose);
  void restrain_broken();
  void quarantine_broken();
  void put_in_quarantine(std::uint32_t body, Quarantine reason);
  void suspend_joints_of(std::uint32_t body);
  void resume_joints_of(std::uint32_t body);

  // Taking on a state that was saved: restore.cpp.
  void adopt(const std::shared_ptr<const Roster>& roster);
  void forget_roster();
  void read_state(std::span<const std::byte> state);
  void restore_materials();
  void run_surface(std::uint32_t body, const Vector3& velocity);
  void restore_quarantined(std::uint32_t body, Quarantine reason, std::int64_t step, const collision::Filter& filter);
  void note_restored_bodies();
  std::span<const std::byte> definition_bytes(std::uint32_t joint);
  void restore_joint(std::uint32_t joint, const JointDef& def);
  void restore_joints(bool same);
  void gather_kept_apart(std::vector<collision::Pair>& pairs) const;
  void restore_kept_apart(std::span<const collision::Pair> told);
  bool is_in_broadphase(std::uint32_t collider) const;
  void restore_box(std::uint32_t collider, const collision::Aabb& box, const collision::Filter& filter);
  void restore_plane(std::uint32_t collider, const collision::Plane& plane, const collision::Filter& filter);
  bool may_touch(collision::Pair pair) const;
  void restore_pairs(std::span<const collision::Pair> pairs);
  collision::ContactCache::Start contact_start(collision::Pair pair) const;

  // The step in progress, and what its phases hand on.
  std::int64_t steps_ = 0;  // begun so far
  double dt_ = 0;
  int substeps_ = 1;
  bool ends_step_ = true;  // else more substeps follow, under a force law
  bool forced_ = false;    // a force law is being asked
  double last_dt_ = 0;
  double last_substep_ = 0;  // s; 0 before the first step
  StepReport report_;
  ActiveBodies active_;
  std::vector<std::uint32_t> may_start_or_stop_;  // bodies that came, went or got a velocity, see active_
  std::vector<std::uint32_t> pushed_;             // bodies with a force or torque on them
  std::vector<collision::StepReach> reaches_;
  collision::ContactUpdate contact_update_;
  std::span<const solver::TouchingPair> touching_;
  solver::Islands islands_;
  bool islands_stale_ = true;  // bodies started, stopped, came or went since they were made
  std::vector<solver::IslandGroup> groups_;
  bool one_each_ = false;  // a group for each island, that stops sweeping when it is done
  std::vector<solver::GroupReport> group_reports_;
  jobs::Scratch<solver::GroupSolver> group_solvers_;
  std::vector<std::unique_ptr<solver::GroupSolver>> large_solvers_;  // of large groups, in order
  solver::SolverSelection selection_;
  std::vector<solver::SolveMode> modes_;  // by island, or empty
  std::vector<std::uint8_t> alone_;       // likewise: solved in a way of its own
  bool regrouped_ = false;                // since the last solve
  std::vector<std::unique_ptr<solver::DirectIsland>> direct_solvers_;
  std::vector<solver::DirectIsland*> direct_of_group_;  // or empty
  std::vector<solver::DirectIslandReport> direct_reports_;
  solver::Overloads overloads_;
  std::vector<solver::Overload> all_overloads_;
  std::vector<EscalatedIsland> escalated_;
  std::vector<std::uint32_t> failed_;  // bodies of islands that could not be solved at once
  solver::FastBodies fast_;
  std::vector<collision::FastBody> fast_in_order_;  // of assemblies, then of bodies
  std::vector<collision::FastBody> carried_;        // likewise: not fast, but joined to what stops
  collision::ContinuousCollision continuous_;
  std::vector<std::pair<std::uint32_t, Quarantine>> broken_;  // bodies that the solve left unsound, in order
  std::vector<std::uint32_t> assembly_;                       // by joined body: its component of the graph of joints
  solver::JointGraph joint_graph_;
  solver::JointSystems joint_systems_;  // by component of the graph
  bool joints_stale_ = false;           // joints came, went or changed since the graph was made
  std::vector<std::pair<std::uint32_t, std::uint32_t>> to_kinematic_;  // kinematic bodies, and what is joined to them
  std::int64_t direct_joints_ = 0;                                     // of awake bodies
  std::vector<JointEvent> joint_events_;
  ContactEvents events_;
  ContactEvents unasked_events_;  // that nobody asked for, where everything is run
  bool islands_rebuilt_ = false;  // by the last step

  std::vector<solver::SurfaceContact> surface_contacts_;  // by contact slot; empty while all surfaces are plain

  solver::ContactCapture capture_;
  bool captured_ = false;  // by the last step

  // Whether the broadphase has boxes to take in: several threads may find that it has, and one does it.
  std::atomic<bool> boxes_wait_ = false;
  std::mutex taking_in_;

  ConstantsPool constants_;
  std::uint64_t serial_;                            // of this world in the process
  mutable std::shared_ptr<const Roster> roster_;    // null if bodies came or went since it was made
  std::shared_ptr<const Roster> known_as_;          // a snapshot's, found to be the same
  std::vector<std::uint8_t> restored_acts_;         // scratch: which joints acted
  std::vector<std::byte> definition_bytes_;         // scratch
  std::vector<collision::Pair> kept_apart_before_;  // scratch, in order
  std::vector<collision::Pair> kept_apart_;         // scratch, in order

  std::vector<ContactForce> contact_forces_;
  bool contact_forces_valid_ = false;
};

}  // namespace atl
