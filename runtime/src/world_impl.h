#pragma once

#include <atoll/world.h>
#include <collision/broadphase.h>
#include <collision/contact_cache.h>
#include <collision/update_contacts.h>
#include <jobs/arena.h>
#include <jobs/scratch.h>
#include <solver/body_table.h>
#include <solver/group_solver.h>
#include <solver/islands.h>

#include <vector>

#include "sleeping.h"

namespace atl {

/// What users add to a body that the solver's table doesn't hold, one entry a body index.
struct BodyRecords {
  std::vector<std::uint32_t> generation;
  std::vector<std::uint8_t> alive;
  std::vector<BodyType> type;
  std::vector<collision::Shape> shape;
  std::vector<Material> material;
  std::vector<std::uint32_t> free;  ///< indices of removed bodies; the last is used first
  std::size_t count = 0;            ///< alive
};

/// Which optional stages the world's bodies call for. Kept up to date as bodies come and go.
struct Contents {
  std::size_t kinematic = 0;
  std::size_t with_friction = 0;
  std::size_t with_restitution = 0;
  std::size_t gyroscopic = 0;

  void count(const solver::BodyTable& bodies, const BodyRecords& records, std::uint32_t body, int sign);
};

class World::Impl {
 public:
  explicit Impl(const WorldDef& def);

  // The step and its phases: step.cpp.
  StepReport step(double dt);

  // Bodies: bodies.cpp.
  BodyId add_body(const BodyDef& def);
  void remove_body(BodyId id);
  std::uint32_t index_of(BodyId id, const char* call) const;
  std::uint32_t awaken(BodyId id, const char* call);
  void set_pose(BodyId id, const Pose& pose);
  void wake_all();
  void wake_touching(std::uint32_t body);

  // Results: contact_forces.cpp, state_hash.cpp.
  std::span<const ContactForce> contact_forces() const;
  std::uint64_t state_hash() const;

  Vector3 gravity;
  Settings settings;
  const solver::Kernels* kernels;
  jobs::Arena arena;

  solver::BodyTable bodies;
  BodyRecords records;
  Contents contents;
  Sleeping sleeping;
  collision::Broadphase broadphase;
  collision::ContactCache cache;

 private:
  void plan();
  void find_pairs();
  void update_contacts();
  void build_islands();
  void solve_islands();
  void sweep_fast_bodies();
  void finish();

  struct ProxyBoxes {
    collision::Aabb needed;
    collision::Aabb fat;
  };
  ProxyBoxes proxy_boxes(std::uint32_t body) const;
  collision::Plane world_plane(std::uint32_t body) const;
  bool is_finite(std::uint32_t body) const;
  void add_proxy(std::uint32_t body);
  void move_proxy(std::uint32_t body);
  void wake_touched_sleepers();
  void collect_touching_pairs();
  void solve_groups();
  void move_unconstrained_bodies();
  void note_stages();
  std::int64_t first_non_finite_body();

  // The step in progress, and what its phases hand on.
  double dt_ = 0;
  double last_substep_ = 0;  // s; 0 before the first step
  StepReport report_;
  std::vector<std::uint8_t> active_;  // 1: may move in this step
  std::vector<collision::Aabb> new_boxes_;
  std::vector<std::uint8_t> outgrown_;
  std::vector<collision::ContactStatus> status_;
  std::vector<solver::TouchingPair> touching_;
  solver::Islands islands_;
  std::vector<solver::IslandGroup> groups_;
  std::vector<solver::GroupReport> group_reports_;
  jobs::Scratch<solver::GroupSolver> group_solvers_;

  mutable std::vector<ContactForce> contact_forces_;
  mutable bool contact_forces_valid_ = false;
};

}  // namespace atl
