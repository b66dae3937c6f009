#include "mechanism/inverse_kinematics.h"

#include <solver/integrate/trigonometry.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>
#include <vector>

namespace atl::mechanism {
namespace {

constexpr double goal = 1e-11;  // m and rad: rounding of a reach of 1 km is 1e-13
// Steps that are taken or tried. An arm of seven hinges took 6 to poses whose angles were within 0.5 rad, the median of
// 300, and 100 at most to any of the poses that it reached from anywhere.
constexpr int max_iterations = 400;
constexpr double first_damping = 1e-3;  // of the mean square of the Jacobian's rows, as all dampings
constexpr double min_damping = 1e-12;   // where rounding begins to show in the solve
constexpr double max_damping = 1e12;    // no step is small enough to be a gain

// Which numbers of q a step may change, and how far.
struct Freedom {
  std::vector<bool> free;  // by v
  std::vector<double> lower;
  std::vector<double> upper;
  std::vector<Eigen::Index> q;  // of a turn or slide, else -1

  Freedom(const Tree& tree, const World& world)
      : free(tree.nv, true), lower(tree.nv, -unlimited), upper(tree.nv, unlimited), q(tree.nv, -1) {
    for (const Link& link : tree.links) {
      for (const Stage& stage : link.stages) {
        for (std::size_t i = stage.v; i < stage.v + stage.v_count(); ++i) free[i] = stage.motion != Motion::Free;
        if (!stage.has_axis() || stage.locked) continue;
        const JointRange& range = axis_of(world, link, stage).range;
        lower[stage.v] = range.lower;
        upper[stage.v] = range.upper;
        q[stage.v] = static_cast<Eigen::Index>(stage.q);
      }
    }
  }

  VectorXd within(VectorXd configuration) const {
    for (std::size_t i = 0; i < free.size(); ++i) {
      if (q[i] >= 0) configuration[q[i]] = std::clamp(configuration[q[i]], lower[i], upper[i]);
    }
    return configuration;
  }

  // Tells a step out of the range of a coordinate that is at an end of it.
  bool leaves(std::size_t i, const VectorXd& configuration, double step) const {
    if (q[i] < 0) return false;
    const double value = configuration[q[i]];
    return (value <= lower[i] && step < 0) || (value >= upper[i] && step > 0);
  }
};

// A configuration, and how far it is from the target.
struct Candidate {
  VectorXd q;
  Kinematics at;
  Vector3 point;
  VectorXd error;  // 3 numbers, or 6 with the turn that is left

  Candidate(const Tree& tree, const World& world, const Target& target, const VectorXd& configuration)
      : q(configuration), at(kinematics(tree, world, q, VectorXd::Zero(static_cast<Eigen::Index>(tree.nv)))) {
    const Pose& pose = at.poses[target.link];
    point = pose.position + pose.orientation * target.point;
    error = VectorXd::Zero(target.orientation ? 6 : 3);
    error.head<3>() = target.position - point;
    if (!target.orientation) return;
    Quaternion turn = *target.orientation * pose.orientation.conjugate();
    if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
    const double sine = turn.vec().norm();
    if (sine > 0) error.tail<3>() = 2 * solver::arctangent(sine, turn.w()) / sine * turn.vec();
  }
};

// J^T (J J^T + damping I)^-1 error, of the coordinates that may go that way.
VectorXd damped_step(const MatrixXd& jacobian, const Candidate& from, const Freedom& freedom, double damping) {
  std::vector<bool> free = freedom.free;
  const Eigen::Index rows = from.error.size();
  while (true) {
    MatrixXd square = damping * MatrixXd::Identity(rows, rows);
    for (std::size_t i = 0; i < free.size(); ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      if (free[i]) square += jacobian.col(column) * jacobian.col(column).transpose();
    }
    const VectorXd pull = square.ldlt().solve(from.error);
    VectorXd step = VectorXd::Zero(jacobian.cols());
    bool within = true;
    for (std::size_t i = 0; i < free.size(); ++i) {
      if (!free[i]) continue;
      const auto column = static_cast<Eigen::Index>(i);
      step[column] = jacobian.col(column).dot(pull);
      if (!freedom.leaves(i, from.q, step[column])) continue;
      free[i] = within = false;
    }
    if (within) return step;
  }
}

}  // namespace

// Marquardt, "An algorithm for least-squares estimation of nonlinear parameters", 1963: less damping after a step that
// gains, more after one that doesn't.
InverseKinematics inverse_kinematics(const Tree& tree, const World& world, const Target& target) {
  const Freedom freedom(tree, world);
  Candidate best(tree, world, target, freedom.within(read_q(tree, world)));
  double damping = first_damping;
  int iterations = 0;
  while (iterations < max_iterations && best.error.norm() > goal && damping < max_damping) {
    ++iterations;
    const MatrixXd jacobian = jacobian_at(tree, best.at, target.link, best.point).topRows(best.error.size());
    const double scale = jacobian.squaredNorm() / static_cast<double>(jacobian.rows());
    if (!(scale > 0)) break;
    const VectorXd step = damped_step(jacobian, best, freedom, damping * scale);
    Candidate next(tree, world, target, freedom.within(integrate(tree, best.q, step)));
    if (next.error.norm() < best.error.norm()) {
      best = std::move(next);
      damping = std::max(0.1 * damping, min_damping);
    } else {
      damping *= 10;
    }
  }
  InverseKinematics found{.q = best.q, .position_error = best.error.head<3>().norm(), .iterations = iterations};
  if (target.orientation) found.angle_error = best.error.tail<3>().norm();
  return found;
}

}  // namespace atl::mechanism
