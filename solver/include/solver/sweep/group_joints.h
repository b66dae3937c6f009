#pragma once

#include <jobs/arrays.h>
#include <solver/constraints/joint.h>
#include <solver/constraints/row_law.h>
#include <solver/integrate/body_table.h>
#include <solver/integrate/motion.h>
#include <solver/islands/joint_graph.h>
#include <solver/sweep/colouring.h>
#include <solver/sweep/joint_block.h>
#include <solver/sweep/kernels.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// The input of a group's joints in a step.
struct JointStep {
  Joint* joints;  ///< by index
  const JointGraph* graph;
  const BodyTable& table;  ///< poses of the start of the step, or, as results are stored, of its end
  const SolverBodies& bodies;
  const SubstepConstants& constants;
  double h;  ///< s, of a substep
};

/// The part of its distance from rest that a spring of this joint closes at most in a substep, as one of several.
double max_closed_of(const JointStep& step, std::uint32_t joint);

/// The pose to which its displacement has brought a body; `local` is its index into SolverBodies.
BodyPose pose_now(const JointStep& step, std::uint32_t body, std::uint32_t local);

/// The joints of an island group that are solved one after another, as contacts are: coloured blocks for the wide
/// kernels, of which this makes those parts that are not wide: the start of a step, springs, and what lasts. Memory is
/// reused.
class GroupJoints {
 public:
  /// Starts a new group.
  void clear();
  void add(const LocalJoint& local, const Joint& joint) {
    joints_.push_back(local);
    may_bounce_ |= joint.bounces;
    has_forces_ |= joint.acts_as_force();
  }
  /// Colours all joints that were added; see Colouring.
  void colour(std::uint32_t first_dynamic, std::uint32_t body_count);

  bool empty() const { return joints_.empty(); }
  bool has_rows() const { return !rows_.empty(); }
  std::span<const Colour> colours() const { return colouring_.colours(); }
  std::size_t block_count() const { return empty() ? 0 : colouring_.block_count(); }
  /// The data of the joint kernels. With `splits` the impulses that close joints are kept separate from those that
  /// last.
  JointKernelData kernel_data(SolverBodies& bodies, const SubstepConstants& constants, bool splits) {
    split_rows_.resize(splits ? rows_.size() : 0);
    return {.bodies = bodies,
            .blocks = blocks_.data(),
            .rows = rows_.data(),
            .split_rows = split_rows_.data(),
            .frames = frames_.data(),
            .coordinates = coordinates_.data(),
            .constants = constants};
  }

  // The following work on blocks [begin, end), several workers at once.

  /// The start of the step, with the impulses of the last. Kernels::prepare_joints does the rest.
  void prepare(const JointStep& step, std::size_t begin, std::size_t end);
  /// Adds what the tension in points makes of how bodies turn (arm_stiffness.h), by index into SolverBodies. Not for
  /// blocks of different colours at once.
  void add_stiffness(const JointStep& step, std::span<Matrix3> stiffness, std::size_t begin, std::size_t end) const;
  /// Frames, coordinates and laws of the step, for rows other than points. Kernels::refresh_rows does the rest, once
  /// bodies have their inertia of the step and points their masses.
  void prepare_rows(const JointStep& step, std::size_t begin, std::size_t end);
  /// Finds what springs, servos and armatures do in a substep, from the rates before its forces.
  void begin_substep(const JointStep& step, std::size_t begin, std::size_t end);
  /// Keeps them once bodies have moved, after Kernels::refresh_rows: as impulses, whatever rows answer to these now.
  void keep_springs(std::size_t begin, std::size_t end);
  /// True if some coordinate may bounce at the end of its range.
  bool may_bounce() const { return may_bounce_; }
  /// Finds the coordinates that will bounce in this substep, once forces and warm start are applied. Returns true if
  /// any.
  bool record_impacts(const JointStep& step, std::size_t begin, std::size_t end);
  /// Switches all blocks such that sweeps without a bias make these coordinates bounce. The impulses of those sweeps
  /// are dropped at the end, since the next substep has no part in them.
  void begin_bounces();
  void end_bounces();
  /// True if some coordinate has a spring, a motor or a rotor.
  bool has_forces() const { return has_forces_; }
  /// Calls act(body, impulse, angular impulse) for these forces, once for each of the two bodies, by index into
  /// SolverBodies.
  template <typename Act>
  void each_force(const JointStep& step, const Act& act) const;
  /// Scales impulses of points and of all other coordinates by scale(body).
  template <typename Scale>
  void scale_held(const JointStep& step, const Scale& scale);
  void clear_impulses(std::size_t begin, std::size_t end);
  void clear_split_impulses() { std::ranges::fill(split_rows_, SplitRowBlock{}); }
  /// Impulses, coordinates and what holds the joints, back to them. Bodies have their new poses.
  void store(const JointStep& step, std::size_t begin, std::size_t end) const;

  /// See jobs/arrays.h.
  auto arrays() const {
    return std::tie(joints_, blocks_, rows_, frames_, coordinates_, split_rows_, row_rates_, blocks_before_,
                    rows_before_, colouring_);
  }

 private:
  double position_now(const Joint& joint, std::size_t r, std::size_t row, std::size_t lane) const;

  std::vector<LocalJoint> joints_;
  Colouring colouring_;
  std::vector<JointBlock> blocks_;
  std::vector<JointRowBlock> rows_;
  std::vector<JointFrameBlock> frames_;            // one a block, if there are rows
  std::vector<JointCoordinateBlock> coordinates_;  // one a row
  std::vector<SplitRowBlock> split_rows_;          // one a row, where the group needs them

  // A coordinate that may bounce: m/s or rad/s.
  struct RowRate {
    double before = 0;   // at the start of the substep, before its forces
    LimitImpact impact;  // in it
  };
  bool may_bounce_ = false;
  bool has_forces_ = false;
  std::vector<RowRate> row_rates_;  // by lane of rows_, if any may
  std::vector<JointBlock> blocks_before_;
  std::vector<JointRowBlock> rows_before_;
};

template <typename Act>
void GroupJoints::each_force(const JointStep& step, const Act& act) const {
  for (std::size_t b = 0; b < block_count(); ++b) {
    const JointBlock& block = blocks_[b];
    for (std::size_t lane = 0; lane < block_lanes && block.rows > 0; ++lane) {
      if (block.joint[lane] < 0) continue;
      const Joint& joint = step.joints[block.joint[lane]];
      for (std::size_t r = 0; r < joint.rows; ++r) {
        if (!joint.law[r].acts_as_force()) continue;
        const JointRowBlock& row = rows_[block.first_row + r];
        const double impulse = row.impulse[lane];
        const auto along = [&](const float(&axes)[3][block_lanes]) {
          return Vector3(impulse * Vector3(axes[0][lane], axes[1][lane], axes[2][lane]));
        };
        if (block.write_first >> lane & 1u) act(block.first[lane], -along(row.linear), -along(row.angular_first));
        if (block.write_second >> lane & 1u) act(block.second[lane], along(row.linear), along(row.angular_second));
      }
    }
  }
}

template <typename Scale>
void GroupJoints::scale_held(const JointStep& step, const Scale& scale) {
  for (std::size_t b = 0; b < block_count(); ++b) {
    JointBlock& block = blocks_[b];
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      if (block.joint[lane] < 0) continue;
      const float by = scale((block.write_first >> lane & 1u) ? block.first[lane] : block.second[lane]);
      for (auto& axis : block.impulse) axis[lane] *= by;
      const Joint& joint = step.joints[block.joint[lane]];
      for (std::size_t r = 0; r < joint.rows; ++r) {
        if (!joint.law[r].acts_as_force()) rows_[block.first_row + r].impulse[lane] *= by;
      }
    }
  }
}

/// The end of its range that a coordinate is at: -1, 1, or 0 for none. It arrives within a millimetre or milliradian,
/// or a hundredth of a range shorter than ten of these, and leaves at twice that distance, so that it doesn't flicker.
std::int8_t limit_reached(const Law& law, double position, std::int8_t before);

}  // namespace atl::solver
