// The matrix of an island's direct solve, and what velocities make of contacts and joints.

#include <solver/direct/island_problem.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "integrate/matrix3.h"

namespace atl::solver {
namespace {

// Where in a Six what is along and about an axis is.
constexpr int along(int axis) { return axis == 0 ? 0 : 2 + axis; }
constexpr int about(int axis) { return axis == 0 ? 5 : axis; }

}  // namespace

bool IslandProblem::analyse(std::size_t body_count, std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs) {
  const std::vector<std::uint8_t> sizes(body_count, 6);
  return system_.analyse(sizes, pairs, tuning::factor_blocks_per_body * body_count);
}

void DirectContact::add_motion(double sign, const Vector3& arm, const Vector3& v, const Vector3& w, Six& to) const {
  const Vector3 at_centre = v + w.cross(arm);
  for (int axis = 0; axis < 3; ++axis) {
    to[along(axis)] += sign * axes[axis].dot(at_centre);
    to[about(axis)] += sign * axes[axis].dot(w);
  }
}

void DirectContact::bound_friction(double load) {
  bound_load = load;
  law.friction_bound = friction * load;
  law.twist_bound = lever * law.friction_bound + torsional * load;
  law.rolling_bound = rolling * load;
}

Six DirectContact::motion_after(double t) const {
  Six after = motion;
  for (int k = 0; k < 6; ++k) after[k] += t * change[k];
  return after;
}

// What velocities make of the motion.
Six IslandProblem::motion_of(const DirectContact& contact, const std::vector<double>& velocities) const {
  Six motion = {};
  const auto add = [&](std::uint32_t body, const Vector3& arm, double sign) {
    if (body == no_body) return;
    contact.add_motion(sign, arm, Eigen::Map<const Vector3>(&velocities[6 * body]),
                       Eigen::Map<const Vector3>(&velocities[6 * body + 3]), motion);
  };
  add(contact.first, contact.arm_first, -1);
  add(contact.second, contact.arm_second, 1);
  return motion;
}

Six IslandProblem::motion_of(const DirectContact& contact) const {
  Six motion = motion_of(contact, velocity);
  for (int k = 0; k < 6; ++k) motion[k] += contact.given[k];
  return motion;
}

void IslandProblem::add_impulse(const DirectContact& contact, const Six& impulse, double sign,
                                std::vector<double>& to) const {
  const Vector3 force = impulse[0] * contact.axes[0] + impulse[3] * contact.axes[1] + impulse[4] * contact.axes[2];
  const Vector3 couple = impulse[1] * contact.axes[1] + impulse[2] * contact.axes[2] + impulse[5] * contact.axes[0];
  const auto add = [&](std::uint32_t body, const Vector3& arm, double side) {
    if (body == no_body) return;
    const Vector3 torque = couple + arm.cross(force);
    for (int k = 0; k < 3; ++k) {
      to[6 * body + k] += side * force[k];
      to[6 * body + 3 + k] += side * torque[k];
    }
  };
  add(contact.first, contact.arm_first, -sign);
  add(contact.second, contact.arm_second, sign);
}

void IslandProblem::mass_times(const std::vector<double>& velocities, std::vector<double>& product) const {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Vector3 linear = bodies[i].mass * Eigen::Map<const Vector3>(&velocities[6 * i]);
    const Vector3 angular = bodies[i].inertia * Eigen::Map<const Vector3>(&velocities[6 * i + 3]);
    for (int k = 0; k < 3; ++k) {
      product[6 * i + k] = linear[k];
      product[6 * i + 3 + k] = angular[k];
    }
  }
}

bool IslandProblem::is_factored() const {
  // Where something slides its stiffness is another at each motion.
  return std::all_of(contacts.begin(), contacts.end(),
                     [](const DirectContact& contact) {
                       const ContactPieces& pieces = contact.answer.pieces;
                       const bool turns = (pieces.slides != 0 && !contact.law.pyramid) || pieces.rolls;
                       return contact.factored == pieces && !turns;
                     }) &&
         std::all_of(joints.begin(), joints.end(), [](const DirectJoint& joint) {
           for (std::size_t r = 0; r < joint.rows; ++r) {
             if (joint.factored[r] != joint.law[r].pieces(joint.rate[r])) return false;
           }
           return true;
         });
}

void IslandProblem::forget_factor() {
  for (DirectContact& contact : contacts) contact.factored.points = 0xff;
}

bool IslandProblem::factor() {
  add_masses();
  for (DirectContact& contact : contacts) {
    add_stiffness(contact, contact.law.derivative(contact.motion, contact.answer.pieces));
    contact.factored = contact.answer.pieces;
  }
  for (DirectJoint& joint : joints) add_stiffness(joint);
  return system_.factor();
}

void IslandProblem::add_masses() {
  system_.clear();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto node = static_cast<std::uint32_t>(i);
    double* block = system_.values(system_.block_index(node, node));
    for (int k = 0; k < 3; ++k) {
      block[7 * k] = bodies[i].mass;
      for (int r = 0; r < 3; ++r) block[(3 + r) + 6 * (3 + k)] = bodies[i].inertia(r, k);
    }
  }
}

// J^T K J, with K the derivative of the contact's impulses by its motion and J that of its motion by the velocities. K
// is put into the world's frame at the contact's centre, [P Q; Q^T S] of forces and couples by speeds and spins, and
// moved to the bodies' centres by their arms.
void IslandProblem::add_stiffness(const DirectContact& contact, const std::array<Six, 6>& k) {
  const auto& [n, t1, t2] = contact.axes;
  const Vector3 leans = k[0][1] * t1 + k[0][2] * t2;
  Matrix3 p, q, s;
  for (int c = 0; c < 3; ++c) {
    const double p_n = k[0][0] * n[c], p_1 = k[3][3] * t1[c] + k[3][4] * t2[c], p_2 = k[3][4] * t1[c] + k[4][4] * t2[c];
    const double s_n = k[5][5] * n[c], s_1 = k[1][1] * t1[c] + k[1][2] * t2[c], s_2 = k[1][2] * t1[c] + k[2][2] * t2[c];
    for (int r = 0; r < 3; ++r) {
      p(r, c) = p_n * n[r] + p_1 * t1[r] + p_2 * t2[r];
      q(r, c) = leans[c] * n[r];
      s(r, c) = s_n * n[r] + s_1 * t1[r] + s_2 * t2[r];
    }
  }
  struct Side {
    Vector3 arm;
    Matrix3 forces;   // by spins
    Matrix3 crossed;  // [arm] q
  };
  const auto side_of = [&](const Vector3& arm) { return Side{arm, q + crossed(arm, p).transpose(), crossed(arm, q)}; };
  const auto add = [&](std::uint32_t row, const Side& of_row, std::uint32_t column, const Side& of_column,
                       double sign) {
    double* block = system_.values(system_.block_index(row, column));
    const Matrix3 turns = crossed(of_row.arm, of_column.forces);
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) {
        block[r + 6 * c] += sign * p(r, c);
        block[3 + r + 6 * c] += sign * of_row.forces(c, r);
        block[r + 6 * (3 + c)] += sign * of_column.forces(r, c);
        block[3 + r + 6 * (3 + c)] += sign * (turns(r, c) + of_column.crossed(c, r) + s(r, c));
      }
    }
  };
  const Side first = side_of(contact.arm_first);
  const Side second = side_of(contact.arm_second);
  if (contact.first != no_body) add(contact.first, first, contact.first, first, 1);
  if (contact.second != no_body) add(contact.second, second, contact.second, second, 1);
  if (contact.first == no_body || contact.second == no_body) return;
  // A block has the rows of what is eliminated later.
  if (system_.is_earlier(contact.first, contact.second)) {
    add(contact.second, second, contact.first, first, -1);
  } else {
    add(contact.first, first, contact.second, second, -1);
  }
}

// J^T K J of a joint: a row's motion is one of each body.
void IslandProblem::add_stiffness(DirectJoint& joint) {
  const auto add = [&](std::uint32_t row_body, const Vector3& row_angular, std::uint32_t column_body,
                       const Vector3& column_angular, const Vector3& linear, double k) {
    double* block = system_.values(system_.block_index(row_body, column_body));
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) {
        block[r + 6 * c] += k * linear[r] * linear[c];
        block[3 + r + 6 * c] += k * row_angular[r] * linear[c];
        block[r + 6 * (3 + c)] += k * linear[r] * column_angular[c];
        block[3 + r + 6 * (3 + c)] += k * row_angular[r] * column_angular[c];
      }
    }
  };
  const bool both = joint.first != no_body && joint.second != no_body;
  const bool first_later = both && !system_.is_earlier(joint.first, joint.second);
  for (std::size_t i = 0; i < joint.rows; ++i) {
    joint.factored[i] = joint.law[i].pieces(joint.rate[i]);
    const double k = joint.law[i].slope(joint.rate[i]);
    if (k == 0) continue;
    const JointRow& at = joint.at[i];
    if (joint.first != no_body) {
      add(joint.first, at.angular_first, joint.first, at.angular_first, at.linear, k);
    }
    if (joint.second != no_body) {
      add(joint.second, at.angular_second, joint.second, at.angular_second, at.linear, k);
    }
    if (!both) continue;
    // A block has the rows of what is eliminated later.
    if (first_later) {
      add(joint.first, at.angular_first, joint.second, at.angular_second, at.linear, -k);
    } else {
      add(joint.second, at.angular_second, joint.first, at.angular_first, at.linear, -k);
    }
  }
}

double IslandProblem::rate_of(const DirectJoint& joint, std::size_t row, const std::vector<double>& velocities) const {
  const JointRow& at = joint.at[row];
  double rate = 0;
  const auto add = [&](std::uint32_t body, const Vector3& angular, double sign) {
    if (body == no_body) return;
    rate += sign * (at.linear.dot(Eigen::Map<const Vector3>(&velocities[6 * body])) +
                    angular.dot(Eigen::Map<const Vector3>(&velocities[6 * body + 3])));
  };
  add(joint.first, at.angular_first, -1);
  add(joint.second, at.angular_second, 1);
  return rate;
}

void IslandProblem::add_impulse(const DirectJoint& joint, std::size_t row, double impulse,
                                std::vector<double>& to) const {
  const JointRow& at = joint.at[row];
  const auto add = [&](std::uint32_t body, const Vector3& angular, double side) {
    if (body == no_body) return;
    for (int k = 0; k < 3; ++k) {
      to[6 * body + k] += side * at.linear[k];
      to[6 * body + 3 + k] += side * angular[k];
    }
  };
  add(joint.first, at.angular_first, -impulse);
  add(joint.second, at.angular_second, impulse);
}

}  // namespace atl::solver
