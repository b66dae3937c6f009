#pragma once

#include <solver/constraints/joint.h>

#include <array>
#include <cstddef>

namespace atl::solver {

/// The masses of a joint's two bodies, by which its rows act.
struct JointBodies {
  double inverse_mass;                    ///< 1/kg, sum of both
  Matrix3 inertia_first, inertia_second;  ///< 1/(kg m^2), inverse, in world axes
  Matrix3 point_mass;  ///< kg, of the point, where it was a substep ago: rows are nearly orthogonal to it then
};

/// The rows of a joint as they act while the joint holds: with an impulse along one comes what the point and the locked
/// rows need so as not to move. So a sweep over the joint solves all that it locks at once, as a block (they are
/// orthogonal by M^-1: Gram and Schmidt), and a motor moves what it would in the joint's own coordinate. One row after
/// another would leave a part of each that hardly shrinks where arms are long for what bodies weigh, as those of
/// universal joints a metre off bricks of 10 cm; what sweeps leave, stiff joints ring up from.
class HeldRows {
 public:
  HeldRows(const Joint& joint, const JointFrames& frames, const JointBodies& bodies);

  const LawRow& row(std::size_t r) const { return rows_[r]; }
  /// Whether it can act: not where bodies can't be turned, or where the coordinate means nothing.
  bool can_act(std::size_t r) const;
  /// J M^-1 J^T.
  double response(std::size_t r) const { return turned_[r].response; }
  /// The same where the joint doesn't hold.
  double free_response(std::size_t r) const { return free_response_[r]; }

 private:
  // The spins that a unit of impulse along a row gives, and its response.
  struct Turned {
    Vector3 first, second;
    double response;
  };

  Turned turned_by(const JointRow& row) const;
  void hold_point(const JointFrames& frames);
  void hold_locked(std::size_t held, std::size_t r);

  const Joint& joint_;
  const JointBodies& bodies_;
  std::array<LawRow, max_joint_rows> rows_;
  std::array<Turned, max_joint_rows> turned_;
  std::array<double, max_joint_rows> free_response_;
};

}  // namespace atl::solver
