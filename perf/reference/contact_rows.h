#pragma once

#include <atoll/contact_problem.h>

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace atl::reference {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The rows of one patch: its points' normals, then two tangents and the twist where it has them. A row of twist is
/// taken per lever arm, so that all impulses are in N s and all velocities in m/s.
struct PatchRows {
  static constexpr int none = -1;

  std::size_t patch = 0;  ///< of the problem
  int first_row = 0;
  int points = 0;
  bool slides = false;  ///< has the two rows of tangents
  bool twists = false;  ///< has the row of twist, the last
  double friction = 0;
  double mass = 0;                                   ///< kg, a mean of the rows' effective masses
  std::array<int, 2> body = {none, none};            ///< of those that impulses move
  std::array<Eigen::Matrix<double, 7, 6>, 2> j;      ///< relative velocity of the rows from the bodies' velocities
  std::array<Eigen::Matrix<double, 6, 7>, 2> apply;  ///< M^-1 J^T: what impulses do to the bodies' velocities

  int rows() const { return points + (slides ? 2 : 0) + (twists ? 1 : 0); }
};

/// A contact problem as matrices: u = J v + offset, v = free + M^-1 J^T r, with the gaps in the offset.
struct ContactRows {
  explicit ContactRows(const ContactProblem& problem);

  int rows = 0;
  std::vector<PatchRows> patches;
  Eigen::VectorXd free;    ///< velocities without impulses of the bodies that impulses move, six a body
  Eigen::VectorXd offset;  ///< of each row: gaps, and the velocities of kinematic bodies

  Eigen::VectorXd velocities(const Eigen::VectorXd& impulses) const;
  Eigen::VectorXd relative_velocities(const Eigen::VectorXd& velocities) const;

  /// Converts the impulses of a contact problem to those of the rows, and back.
  Eigen::VectorXd impulses_of(const ContactProblem& problem) const;
  void write(const Eigen::VectorXd& impulses, ContactProblem& problem) const;
};

}  // namespace atl::reference
