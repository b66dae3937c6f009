#include "direct/island_joints.h"

#include <solver/direct/island_matrix.h>
#include <solver/tuning.h>

namespace atl::solver {
namespace {

JointRow point_row(int axis, const Vector3& arm_first, const Vector3& arm_second) {
  JointRow row;
  row.linear = Vector3::Unit(axis);
  row.angular_first = arm_first.cross(row.linear);
  row.angular_second = arm_second.cross(row.linear);
  return row;
}

void place_arms(const Joint* joints, const IslandPoses& poses, std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    const Joint& of = joints[joint.joint];
    joint.arm_first = poses.of(joint.first, joint.first_body).orientation * of.anchor_first;
    joint.arm_second = poses.of(joint.second, joint.second_body).orientation * of.anchor_second;
  }
}

void place_rows(const Joint& of, const BodyPose& first, const BodyPose& second, DirectJoint& joint) {
  std::size_t r = 0;
  if (of.point) {
    const Vector3 offset = (second.position - first.position) + (joint.arm_second - joint.arm_first);
    for (; r < 3; ++r) {
      joint.at[r] = point_row(static_cast<int>(r), joint.arm_first, joint.arm_second);
      joint.at[r].value = offset[static_cast<Eigen::Index>(r)];
    }
  }
  if (r == joint.rows) return;
  const JointFrames frames = joint_frames(of, first.position, first.orientation, second.position, second.orientation);
  for (std::size_t k = 0; r < joint.rows; ++r, ++k) {
    const LawRow now = law_row(of, k, frames, joint.position[r]);
    joint.at[r] = now.at;
    joint.position[r] = now.position;
  }
}

// Effective masses of rows, and their rates by what doesn't respond.
void weigh_rows(const BodyTable& table, const std::vector<DirectBody>& bodies, DirectJoint& joint) {
  const auto response = [&](std::uint32_t body, const Vector3& linear, const Vector3& angular) {
    if (body == no_body) return 0.0;
    const DirectBody& b = bodies[body];
    return linear.squaredNorm() / b.mass + angular.dot(b.inverse_inertia * angular);
  };
  for (std::size_t r = 0; r < joint.rows; ++r) {
    const JointRow& at = joint.at[r];
    const double responds =
        response(joint.first, at.linear, at.angular_first) + response(joint.second, at.linear, at.angular_second);
    joint.mass[r] = responds > 0 ? 1 / responds : 0;
    joint.given[r] = 0;
    if (joint.first == no_body) {
      joint.given[r] -= at.linear.dot(table.velocity(joint.first_body)) +
                        at.angular_first.dot(table.angular_velocity(joint.first_body));
    }
    if (joint.second == no_body) {
      joint.given[r] += at.linear.dot(table.velocity(joint.second_body)) +
                        at.angular_second.dot(table.angular_velocity(joint.second_body));
    }
  }
}

// Before the substep's forces.
double rate_of(const std::vector<double>& velocities, const DirectJoint& joint, std::size_t row) {
  return joint.rate_by(velocities, row, joint.given[row]);
}

}  // namespace

bool load_joints(const DirectIslandInput& input, const IslandMembers& members, std::vector<DirectJoint>& joints) {
  bool all_locked = true;
  for (std::size_t j = 0; j < members.joints.size(); ++j) {
    const JointLink& link = members.joints[j];
    const Joint& from = input.joints[link.joint];
    DirectJoint& joint = joints[j];
    joint.joint = link.joint;
    joint.first_body = link.first;
    joint.second_body = link.second;
    joint.first = members.local(input, link.first);
    joint.second = members.local(input, link.second);
    joint.rows = from.row_count();
    joint.tension = from.tension;
    joint.position = {};
    joint.impulse = {};
    const std::size_t points = from.point ? 3 : 0;
    for (std::size_t r = points; r < joint.rows; ++r) {
      joint.position[r] = from.position[r - points];
      all_locked &= from.law[r - points].locked();
    }
  }
  return all_locked;
}

const Law& law_of(const Joint& joint, std::size_t row) {
  static constexpr Law locked{.lower = 0, .upper = 0};
  const std::size_t points = joint.point ? 3 : 0;
  return row < points ? locked : joint.law[row - points];
}

void place_joints(const DirectIslandInput& input, double time, double h, std::vector<MovingBody>& bodies,
                  IslandProblem& problem) {
  const IslandPoses poses{input.bodies, bodies, time};
  place_arms(input.joints, poses, problem.joints);
  place_inertia(problem, bodies, h);
  for (DirectJoint& joint : problem.joints) {
    place_rows(input.joints[joint.joint], poses.of(joint.first, joint.first_body),
               poses.of(joint.second, joint.second_body), joint);
    weigh_rows(input.bodies, problem.bodies, joint);
  }
  forget_factor(problem);
}

bool may_bounce(const DirectIslandInput& input, const IslandProblem& problem) {
  for (const DirectJoint& joint : problem.joints) {
    const Joint& of = input.joints[joint.joint];
    if (!of.bounces) continue;
    for (std::size_t r = of.point ? 3 : 0; r < joint.rows; ++r) {
      const Law& law = law_of(of, r);
      const double there = joint.at[r].value + input.dt * rate_of(problem.velocity, joint, r);
      const bool leaves = there < law.lower - tuning::open_gap || there > law.upper + tuning::open_gap;
      if (law.restitution > 0 && leaves) return true;
    }
  }
  return false;
}

void begin_laws(const Joint* joints, double h, const std::vector<double>& velocities, IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const Law& law = law_of(joints[joint.joint], r);
      joint.law[r] = RowLaw::of(law, joint.at[r], joint.mass[r], h, tuning::compliance);
      if (law.looks_back()) joint.law[r].start_at(rate_of(velocities, joint, r));
    }
  }
}

void note_armature(const Joint* joints, const std::vector<double>& velocities, std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      joint.kept[r] = law_of(joints[joint.joint], r).armature > 0 ? rate_of(velocities, joint, r) : 0;
    }
  }
}

void hold_rows(const Joint* joints, IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const RowLaw before = joint.law[r];
      joint.law[r] = {};
      joint.limit[r] = static_cast<std::int8_t>(before.limit(joint.rate[r]));
      joint.motor_bound[r] = static_cast<std::int8_t>(before.motor_bound(joint.rate[r]));
      // Rows have turned with the bodies, and an armature pays for what that makes of its rate.
      joint.law[r].spring_slope = law_of(joints[joint.joint], r).armature;
      joint.law[r].spring_rate = joint.kept[r];
      if (!before.holds(joint.rate[r])) continue;
      joint.law[r].locked = true;
      joint.law[r].stiffness = joint.mass[r] / tuning::compliance;
    }
  }
}

bool follow_tension(IslandProblem& problem, double h) {
  bool tightens = false;
  for (DirectJoint& joint : problem.joints) {
    Vector3 force = Vector3::Zero();
    for (std::size_t r = 0; r < joint.rows; ++r) force += (joint.lasting[r] / h) * joint.at[r].linear;
    const bool grows = force.squaredNorm() > joint.tension.squaredNorm();
    const Vector3 change = (grows ? 1 : tuning::tension_smoothing) * (force - joint.tension);
    joint.tension += change;
    const auto turns = [&](std::uint32_t body, const Vector3& arm) {
      if (body == no_body) return false;
      return h * h * change.norm() * arm.norm() > tuning::notable_stiffness * problem.bodies[body].inertia.trace();
    };
    tightens |= grows && (turns(joint.first, joint.arm_first) || turns(joint.second, joint.arm_second));
  }
  return tightens;
}

void write_back_joints(const DirectIslandInput& input, const std::vector<DirectJoint>& joints) {
  const double over_h = input.settings.substeps / input.dt;
  for (const DirectJoint& from : joints) {
    Joint& joint = input.joints[from.joint];
    joint.tension = from.tension;
    joint.force.setZero();
    joint.torque.setZero();
    std::size_t r = 0;
    if (joint.point) {
      for (; r < 3; ++r) joint.point_impulse[static_cast<Eigen::Index>(r)] = from.lasting[r];
      joint.force = over_h * joint.point_impulse;
    }
    for (std::size_t k = 0; r < from.rows; ++r, ++k) {
      const JointRow& at = from.at[r];
      joint.impulse[k] = from.lasting[r];
      joint.position[k] = from.position[r];
      joint.limit[k] = from.limit[r];
      joint.motor_bound[k] = from.motor_bound[r];
      joint.force += over_h * from.lasting[r] * at.linear;
      joint.torque += over_h * from.lasting[r] * (at.angular_second - from.arm_second.cross(at.linear));
    }
  }
}

}  // namespace atl::solver
