#include "direct/joint_leapfrog.h"

#include <solver/direct/island_matrix.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "direct/island_joints.h"
#include "integrate/matrix3.h"

namespace atl::solver {
namespace {

bool bends_notably(const Vector3& spin) {
  constexpr double min_square = tuning::min_bend_spin * tuning::min_bend_spin;
  return spin.squaredNorm() > min_square;
}

// A body of a joint, and where it would be at the substep's end if no impulse changed its velocity.
struct Side {
  Vector3 velocity, spin;
  const BodyPose& next;
};

// `other` is room for the pose of what doesn't respond.
Side side_of(const BodyTable& table, double time, std::span<const MovingBody> bodies,
             const std::vector<double>& velocities, std::uint32_t local, std::uint32_t body, BodyPose& other) {
  if (local != no_body) return {linear_part(velocities, local), angular_part(velocities, local), bodies[local].next};
  other = pose_after(table, body, time);
  return {table.velocity(body), table.angular_velocity(body), other};
}

BodyPose next_pose(const BodyTable& table, double h, const MovingBody& moving, std::uint32_t body,
                   const Vector3& velocity, const Vector3& spin) {
  Vector3 turns = spin;
  if (moving.tumbles) {
    const Quaternion& turn = moving.now.orientation;
    const Vector3 own = turn.conjugate() * spin;
    const Vector3 torque = product(moving.body_inertia, own).cross(own);
    turns = turn * (own + (0.5 * h) * product(table.inverse_inertia[body], torque));
  }
  return {moving.now.position + h * velocity, turned(h * turns, moving.now.orientation)};
}

// The bend of find_bends(). A coordinate of a term bends as its joint's bodies swing, and its polynomial as it moves.
double bend_of_tendon(const SolveInput& input, double time, double h, std::span<const MovingBody> bodies,
                      const std::vector<double>& velocities, const DirectJoint& tendon) {
  const Law& law = input.joints[tendon.joint].law[0];
  if (!law.locked() && law.armature == 0) return 0;
  double change = 0, length = 0;
  for (std::size_t i = 0; i < tendon.terms; ++i) {
    const DirectTerm& term = tendon.term[i];
    const TendonTerm& of = input.joints[tendon.joint].term[i];
    BodyPose other_first, other_second;
    const Side a = side_of(input.bodies, time, bodies, velocities, term.first, term.first_body, other_first);
    const Side b = side_of(input.bodies, time, bodies, velocities, term.second, term.second_body, other_second);
    const double moves = h * term.row.at.rate(a.velocity, a.spin, b.velocity, b.spin);
    change += term.row.slope * moves;
    length += term_row(of, input.joints[of.joint], a.next, b.next, term.row.position + moves).value;
  }
  return (length - (tendon.at[0].value + change)) / h;
}

// Velocities are late in a kick that takes back, and rows that are held or driven go at the rates they have. A motor
// drives by no more than its force: the velocities may be those of a blow, which it can't take up.
void hold_late(RowLaw& law, double rate, int limit) {
  const bool driven = law.motor_impulse >= Law::unlimited && law.motor_slope == 0;
  if (law.stiffness == 0 || (limit == 0 && !driven)) return;
  const double lock_rate = limit != 0 ? rate : law.motor_speed;
  law = {.locked = true, .stiffness = law.stiffness, .lock_rate = lock_rate};
}

// Tells a coordinate that goes away from the end of its range, as after a bounce: nothing has held it in the kick.
bool leaves(double rate, int limit) { return -limit * rate > tuning::resting_speed; }

void add_impulse(const Law& of, double impulse, RowLaw& law) {
  if (of.is_servo() && law.motor_slope > 0) {
    law.motor_speed += impulse / law.motor_slope;
  } else if (law.spring_slope > 0) {
    law.spring_rate += impulse / law.spring_slope;
  }
}

// The square of the angle by which an arm turns, but for a fourth order.
double square_of_swing(const Vector3& by, const Vector3& arm) {
  const double square = arm.squaredNorm();
  return square > 0 ? by.squaredNorm() / square : 0;
}

void add_bend(const Joint& of, double bend, std::size_t row, RowLaw& law) {
  if (law.locked) {
    law.lock_rate -= bend;
  } else if (bend != 0 && law.spring_slope > 0) {  // a row that moves nothing has no slope
    law.spring_rate -= law_of(of, row).armature / law.spring_slope * bend;
  }
}

}  // namespace

double find_bends(const SolveInput& input, double time, double h, std::span<MovingBody> bodies,
                  IslandProblem& problem) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    bodies[i].next = next_pose(input.bodies, h, bodies[i], problem.bodies[i].body, linear_part(problem.free, i),
                               angular_part(problem.free, i));
  }
  double square = 0;
  for (DirectJoint& joint : problem.joints) {
    BodyPose other;
    const Side a = side_of(input.bodies, time, bodies, problem.free, joint.first, joint.first_body, other);
    const Side b = side_of(input.bodies, time, bodies, problem.free, joint.second, joint.second_body, other);
    joint.bend = {};
    if (joint.is_tendon()) {
      joint.bend[0] = bend_of_tendon(input, time, h, bodies, problem.free, joint);
      continue;
    }
    if (!bends_notably(a.spin) && !bends_notably(b.spin)) continue;
    const Joint& of = input.joints[joint.joint];
    const Vector3 turned_first = a.next.orientation * of.anchor_first - joint.arm_first;
    const Vector3 turned_second = b.next.orientation * of.anchor_second - joint.arm_second;
    square = std::max(
        {square, square_of_swing(turned_first, joint.arm_first), square_of_swing(turned_second, joint.arm_second)});
    std::size_t r = 0;
    if (of.point) {
      const Vector3 bend =
          (turned_second - turned_first) / h - (b.spin.cross(joint.arm_second) - a.spin.cross(joint.arm_first));
      for (; r < 3; ++r) joint.bend[r] = bend[static_cast<Eigen::Index>(r)];
    }
    if (r == joint.rows) continue;
    const JointFrames frames =
        joint_frames(of, a.next.position, a.next.orientation, b.next.position, b.next.orientation);
    for (std::size_t k = 0; r < joint.rows; ++r, ++k) {
      if (!law_of(of, r).locked() && law_of(of, r).armature == 0) continue;
      const double change = h * joint.at[r].rate(a.velocity, a.spin, b.velocity, b.spin);
      const LawRow there = law_row(of, k, frames, joint.position[r] + change);
      joint.bend[r] = (there.at.value - (joint.at[r].value + change)) / h;
    }
  }
  for (DirectJoint& joint : problem.joints) forget_still(joint, joint.bend);
  const double swing = std::sqrt(square);
  if (swing > tuning::max_bend) {
    for (DirectJoint& joint : problem.joints) joint.bend = {};
  }
  return swing;
}

void answer_bends(const Joint* joints, IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) add_bend(joints[joint.joint], joint.bend[r], r, joint.law[r]);
  }
}

void damp_by_like_rates(const Joint* joints, const std::vector<double>& along, IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      const Law& of = law_of(joints[joint.joint], r);
      if (!joint.law[r].locked && of.damps()) joint.law[r].damp_by(joint.rate_by(along, r), of.armature);
    }
  }
}

void forget_bends(const Joint* joints, IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) add_bend(joints[joint.joint], -joint.bend[r], r, joint.law[r]);
    joint.bend = {};
  }
}

bool is_against_locks(const IslandProblem& problem, const DirectJoint& joint) {
  double speed = 0, radius = 0;  // m/s, of its bodies, and m, that makes speeds of spins
  for (const std::uint32_t body : {joint.first, joint.second}) {
    if (body == no_body) continue;
    radius = std::max(radius, problem.bodies[body].radius);
    speed += linear_part(problem.velocity, body).norm() +
             problem.bodies[body].radius * angular_part(problem.velocity, body).norm();
  }
  double square = 0;
  for (std::size_t r = 0; r < joint.rows; ++r) {
    if (!joint.law[r].locked) continue;
    const double rate = joint.rate_before[r] * (joint.at[r].linear.isZero() ? radius : 1);
    square += rate * rate;
  }
  return square > tuning::energy_tolerance * speed * speed;
}

void hold_locks_alone(const Joint* joints, IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const Law& law = law_of(joints[joint.joint], r);
      if (law.locked()) {
        joint.law[r].lock_rate = 0;
        continue;
      }
      joint.law[r] = {};
      joint.law[r].spring_slope = law.armature;
      joint.law[r].spring_rate = joint.rate_before[r];
      joint.rate[r] = joint.rate_before[r];
    }
  }
  forget_factor(problem);
}

void bound_servos(const Joint* joints, std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      const Law& law = law_of(joints[joint.joint], r);
      if (law.is_servo())
        joint.motor_bound[r] = static_cast<std::int8_t>(servo_bound(law, joint.at[r], joint.rate_before[r]));
    }
  }
}

void begin_kick(const Joint* joints, double h, int sign, IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const Law& law = law_of(joints[joint.joint], r);
      const double rate = joint.rate_before[r];
      const double end_rate = sign < 0 ? rate : joint.bounces[r] ? joint.impact[r].leaving : 0;
      if (sign < 0 && leaves(rate, joint.limit[r])) joint.limit[r] = 0;
      if (law.locked()) {
        joint.law[r].lock_rate = 0;
        continue;
      }
      joint.law[r] = RowLaw::of_kick(law, joint.at[r], joint.row_mass(r), h, sign, rate, end_rate, joint.limit[r],
                                     joint.motor_bound[r]);
      joint.law[r].stiffness = joint.mass[r] / problem.lock_compliance;
      if (sign < 0) {
        hold_late(joint.law[r], rate, joint.limit[r]);
      } else {
        if (law.drives() && joint.law[r].motor_impulse == 0.5 * h * law.motor_force) {
          joint.law[r].soften_motor(joint.mass[r]);
        }
        joint.law[r].soften_friction(joint.mass[r]);
      }
      joint.rate[r] = rate;
      start_at_limit(joint, r);
    }
  }
  forget_factor(problem);
}

void correct_kick(const Joint* joints, double h, int sign, IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const Law& law = law_of(joints[joint.joint], r);
      if (!law.looks_back() || law.locked()) continue;
      const double acceleration = sign * (joint.rate[r] - joint.rate_before[r]) / (0.5 * h);
      const double rate = sign < 0 ? joint.rate_before[r] : joint.rate[r];
      add_impulse(law, sign * kick_correction(law, joint.at[r], joint.row_mass(r), h, rate, acceleration),
                  joint.law[r]);
    }
  }
}

double work_of_bases(const IslandProblem& problem, DirectJoint::Rows<double> DirectJoint::*impulses) {
  double sum = 0;
  for (const DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) sum -= (joint.*impulses)[r] * joint.given[r];
  }
  return sum;
}

bool gains_energy(const Joint* joints, const IslandProblem& problem, std::span<const MovingBody> bodies, double given,
                  const std::vector<double>& before, const std::vector<double>& after, Rotors rotors) {
  // J, from differences: most solves take energy, and no more is asked of these.
  double made = -given;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Vector3 gained = linear_part(after, i) - linear_part(before, i);
    const Vector3 gained_spin = angular_part(after, i) - angular_part(before, i);
    const Vector3 both = linear_part(after, i) + linear_part(before, i);
    const Vector3 both_spins = angular_part(after, i) + angular_part(before, i);
    made +=
        0.5 * problem.bodies[i].mass * gained.dot(both) + 0.5 * gained_spin.dot(product(bodies[i].inertia, both_spins));
  }
  double there = 0;
  for (const DirectJoint& joint : problem.joints) {
    const Joint& of = joints[joint.joint];
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      const Law& law = law_of(of, r);
      if (!law.drives() && !law.looks_back()) continue;
      const double from = joint.rate_by(before, r, joint.given[r]), to = joint.rate_by(after, r, joint.given[r]);
      const double turned = rotors == Rotors::Turn ? joint.rate_before[r] : joint.kept[r];
      const double turns = rotors == Rotors::Keep ? turned + (to - from) : to + joint.bend[r];
      const double rotor = 0.5 * law.armature * (turns * turns - turned * turned);
      made += rotor;
      // Rotors give no more than their rates tell. Impulses along rows that have turned since seem to do more work.
      const bool works = law.drives() || law.springs();
      if (works && rotors != Rotors::Keep) made -= std::max(0.5 * joint.impulse[r] * (to + from) + rotor, 0.0);
      if (law.armature == 0) continue;
      there += 0.5 * law.armature * turned * turned;
    }
  }
  if (made <= 0) return false;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Vector3 spin = angular_part(before, i);
    const double mass = problem.bodies[i].mass;
    there += 0.5 * mass * linear_part(before, i).squaredNorm() + 0.5 * spin.dot(product(bodies[i].inertia, spin)) +
             tuning::min_energy * mass;
  }
  return made > tuning::energy_tolerance * there;
}

void leave_out_tension(std::span<const MovingBody> bodies, IslandProblem& problem) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    DirectBody& body = problem.bodies[i];
    body.inertia = bodies[i].inertia;
    body.inverse_inertia = inverse_inertia_with(body.locks, body.inertia);
  }
  forget_rows(problem);
}

}  // namespace atl::solver
