#pragma once

#include <collision/contact.h>
#include <jobs/worker_team.h>
#include <solver/body_table.h>
#include <solver/colouring.h>
#include <solver/contact_capture.h>
#include <solver/islands.h>
#include <solver/kernels.h>
#include <solver/motion.h>
#include <solver/solver_settings.h>

#include <array>
#include <cstdint>
#include <vector>

namespace atl::solver {

/// What all groups of a step share.
struct SolveInput {
  const Islands& islands;
  BodyTable& bodies;
  collision::ContactManifold* manifolds;  ///< by slot
  Vector3 gravity;                        ///< m/s^2
  double dt;                              ///< s
  const SolverSettings& settings;
  const Kernels& kernels;
  FastBodies& fast;
  ContactCapture* capture = nullptr;  ///< null where nobody asks
  /// By contact slot: N m s, in the tangent plane, on the second body. Null while all surfaces are plain.
  std::array<float, 3>* rolling_impulses = nullptr;
};

struct GroupReport {
  std::size_t colours = 0;
  bool friction = false;  ///< some contact has it
  bool restitution = false;
  bool gyroscopic = false;
};

/// Solves island groups: soft substeps with relaxation ("TGS soft": Catto, "Solver2D", 2024) over coloured
/// blocks. Its memory is reused from group to group and stays in cache; nothing in it outlives a solve.
class GroupSolver {
 public:
  /// All on the calling thread.
  GroupReport solve(const SolveInput& input, const IslandGroup& group);
  /// Every loop shared with a team; the same bits.
  GroupReport solve(const SolveInput& input, const IslandGroup& group, jobs::WorkerTeam& team);

 private:
  template <typename Executor>
  GroupReport run(const SolveInput& input, const IslandGroup& group, Executor& executor);
  void collect_contacts(const SolveInput& input, const IslandGroup& group, GroupReport& report);
  void load_bodies(const SolveInput& input, std::span<const std::uint32_t> bodies, std::size_t begin, std::size_t end,
                   double substep);
  void load_kinematic_bodies(const SolveInput& input);
  void write_back(const SolveInput& input, std::span<const std::uint32_t> bodies, std::size_t begin, std::size_t end);
  void clear_impulses();
  void capture(const SolveInput& input, std::span<const std::uint32_t> bodies) const;

  std::vector<std::uint32_t> kinematic_;  // bodies that the group's contacts touch, in order
  std::uint32_t first_dynamic_ = 1;       // index in bodies_
  std::vector<LocalContact> contacts_;
  Colouring colouring_;
  SolverBodies bodies_;
  std::vector<ContactBlock> blocks_;
  std::vector<BounceBlock> bounces_;
};

}  // namespace atl::solver
