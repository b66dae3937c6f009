#pragma once

#include <jobs/bytes.h>
#include <solver/solve_input.h>
#include <solver/sweep/colouring.h>
#include <solver/sweep/contact_block.h>
#include <solver/sweep/group_joints.h>
#include <solver/sweep/joined_motion.h>

#include <array>
#include <cstdint>
#include <vector>

namespace atl::jobs {
class WorkerTeam;
}

namespace atl::solver {

/// What the time of a group goes into. As atoll/report.h has them.
enum class SolverStage { Colour, Prepare, WarmStart, Solve, Relax, Integrate, Restitution, Store };
inline constexpr std::size_t solver_stage_count = 8;

struct GroupReport {
  std::size_t colours = 0;                               ///< of contacts or of joints, whichever has more
  std::size_t joints = 0;                                ///< all that act, however they are solved
  std::int64_t sweeps = 0;                               ///< over its contacts and joints
  std::array<double, solver_stage_count> stage_ms = {};  ///< with SolverSettings::profile
  ContactWork work;
  std::int64_t gyroscopic_bodies = 0;  ///< whose moments of inertia differ
  std::int64_t locked_bodies = 0;      ///< that have motion locks
  bool friction = false;               ///< some contact has it
  bool restitution = false;
  bool surfaces = false;  ///< some surface runs, or holds back rolling or spinning
};

/// Whether a group's contacts may have changed since the same solver solved it last.
enum class GroupContacts { New, Kept };

/// Solves island groups: soft substeps with relaxation ("TGS soft": Catto, "Solver2D", 2024) over coloured
/// blocks of joints and of contacts. Its memory is reused from group to group and stays in cache; only the colours of
/// contacts that are kept outlive a solve.
class GroupSolver {
 public:
  /// All on the calling thread.
  GroupReport solve(const SolveInput& input, const IslandGroup& group);
  /// Every loop shared with a team; the same bits. A group whose contacts, their order and bodies are those of the last
  /// call is not coloured again.
  GroupReport solve(const SolveInput& input, const IslandGroup& group, jobs::WorkerTeam& team, GroupContacts contacts);

  /// Memory held.
  std::size_t bytes() const {
    return jobs::bytes_of(joined_, kinematic_, contacts_, stiffness_, followers_, blocks_, bounces_, surface_blocks_,
                          split_blocks_, planar_blocks_, turning_blocks_) +
           colouring_.bytes() + bodies_.bytes() + joints_.bytes() + joined_motion_.bytes();
  }

 private:
  template <typename Executor>
  class Pass;
  static constexpr std::size_t body_grain = 128;  // of a few microseconds

  template <typename Executor>
  GroupReport run(const SolveInput& input, const IslandGroup& group, Executor& executor, GroupContacts contacts);
  void collect(const SolveInput& input, const IslandGroup& group);
  void collect_kinematic_bodies(const SolveInput& input, const IslandGroup& group);
  std::uint32_t local_body(const SolveInput& input, const IslandGroup& group, std::uint32_t body) const;
  void collect_contacts(const SolveInput& input, const IslandGroup& group);
  void collect_joints(const SolveInput& input, const IslandGroup& group);
  void note_needs(const SolveInput& input, const IslandGroup& group, GroupReport& report);
  bool note_surfaces(const SolveInput& input, const IslandGroup& group);
  template <typename Executor>
  void gather_bodies(const SolveInput& input, const IslandGroup& group, const GroupReport& report, Executor& executor);
  void load_bodies(const SolveInput& input, std::span<const std::uint32_t> bodies, std::size_t begin, std::size_t end,
                   double substep);
  void set_inverse_inertia(std::size_t local, const Matrix3& inverse);
  void stiffen_bodies(const SolveInput& input, std::span<const std::uint32_t> bodies, std::size_t begin,
                      std::size_t end);
  void find_followers(const SolveInput& input, std::span<const std::uint32_t> bodies);
  void follow_inertia(const SolveInput& input, std::span<const std::uint32_t> bodies);
  void give_half_kick(std::span<const std::uint32_t> bodies, float time);
  void load_kinematic_bodies(const SolveInput& input);
  bool turns(const SolveInput& input, std::uint32_t body) const;
  void load_shape(const SolveInput& input, std::uint32_t body, std::size_t local);
  void write_back(const SolveInput& input, std::span<const std::uint32_t> bodies, bool joined, std::size_t begin,
                  std::size_t end);
  ContactKernelData kernel_data(const SolveInput& input, const GroupReport& report, const SubstepConstants& constants,
                                bool splits);
  void note_overloads(const SolveInput& input, std::span<const std::uint32_t> bodies, std::size_t begin,
                      std::size_t end) const;
  void clear_impulses(const GroupReport& report);
  void clear_split_impulses();
  void capture(const SolveInput& input, const GroupReport& report, std::span<const std::uint32_t> bodies) const;

  std::vector<std::uint8_t> joined_;      // by body of the group; empty without joints
  std::vector<std::uint32_t> kinematic_;  // bodies that the group's contacts touch and joints join, in order
  std::uint32_t first_dynamic_ = 1;       // index in bodies_
  std::vector<LocalContact> contacts_;
  bool friction_ = false;  // some contact has it
  bool restitution_ = false;
  Colouring colouring_;
  SolverBodies bodies_;
  std::vector<Matrix3> stiffness_;  // N m, of bodies that joints pull on
  // A body whose inertia joints see turn with it.
  struct Follower {
    std::uint32_t place;
    bool stiff;       // tension counts as inertia
    Matrix3 inertia;  // kg m^2, world frame, as velocities were last changed with it
  };
  std::vector<Follower> followers_;
  std::vector<ContactBlock> blocks_;
  std::vector<BounceBlock> bounces_;
  std::vector<SurfaceBlock> surface_blocks_;
  std::vector<SplitBlock> split_blocks_;
  std::vector<PlanarBlock> planar_blocks_;
  std::vector<TurningBlock> turning_blocks_;
  GroupJoints joints_;
  JoinedMotion joined_motion_;
};

}  // namespace atl::solver
