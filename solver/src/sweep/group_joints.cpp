#include <jobs/assert.h>
#include <jobs/prefetch.h>
#include <solver/constraints/arm_stiffness.h>
#include <solver/constraints/row_law.h>
#include <solver/integrate/motion.h>
#include <solver/sweep/group_joints.h>
#include <solver/tuning.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "integrate/rows3.h"

namespace atl::solver {
namespace {

template <std::size_t n>
using Lanes = float[n][block_lanes];

void set_lane(Lanes<3>& rows, std::size_t lane, const Vector3& from) {
  for (int i = 0; i < 3; ++i) rows[i][lane] = static_cast<float>(from[i]);
}

JointFrames frames_now(const JointStep& step, const JointBlock& block, std::size_t lane) {
  const Joint& joint = step.joints[block.joint[lane]];
  const auto local = [](std::int32_t number) { return static_cast<std::uint32_t>(number); };
  const BodyPose first = pose_now(step, joint.first, local(block.first[lane]));
  const BodyPose second = pose_now(step, joint.second, local(block.second[lane]));
  return joint_frames(joint, first.position, first.orientation, second.position, second.orientation);
}

double rate_of(const SolverBodies& bodies, const JointBlock& block, const JointRowBlock& row, std::size_t lane) {
  const auto first = static_cast<std::size_t>(block.first[lane]), second = static_cast<std::size_t>(block.second[lane]);
  return get_lane(row.linear, lane).dot(velocity_of(bodies, second) - velocity_of(bodies, first)) +
         get_lane(row.angular_second, lane).dot(spin_of(bodies, second)) -
         get_lane(row.angular_first, lane).dot(spin_of(bodies, first));
}

float speed(double value) { return static_cast<float>(std::clamp<double>(value, -unlimited_speed, unlimited_speed)); }

// The part of the way to its speed by which a servo that holds so much moves a rate, after a spring has left `part` of
// it. All of the way, if it is a motor.
float motor_part(double hold, double part) {
  return static_cast<float>(hold > 0 ? hold * part / (1 + hold * part) : 1);
}

// The full turn, or the position of a rate, that positions in a step count from: see JointCoordinateBlock.
double base_of(Coordinate coordinate, double position) {
  constexpr double turn = 2 * 3.14159265358979323846;
  // Beyond, continued() tells no turns apart.
  if (!(std::abs(position) <= 1e15)) return 0;
  if (is_rate(coordinate)) return position;
  return counts_turns(coordinate) ? turn * std::round(position / turn) : 0;
}

void set_coordinate(JointCoordinateBlock& of, std::size_t lane, const Joint& joint, std::size_t r, double h) {
  const Law& law = joint.law[r];
  const Coordinate coordinate = joint.coordinate[r];
  const double base = base_of(coordinate, joint.position[r]);
  ATL_ASSERT(law.lower <= law.upper, joint.first, joint.second, r, law.lower, law.upper);
  of.coordinate[lane] = static_cast<float>(coordinate);
  of.locked[lane] = law.locked() ? 1 : 0;
  of.idles[lane] = !law.locked() && !law.drives() && !law.looks_back() && law.friction == 0 ? 1 : 0;
  of.fades[lane] = is_turn(coordinate) && !(law.locked() && law.lower == 0) ? 1 : 0;
  of.base[lane] = static_cast<float>(base);
  of.lower[lane] = static_cast<float>(law.lower - base);
  of.upper[lane] = static_cast<float>(law.upper - base);
  of.motor_speed[lane] = speed(law.motor_speed);
  of.motor_impulse[lane] = speed(law.drives() ? law.motor_force * h : 0);
  of.friction_impulse[lane] = speed(law.friction * h);
  of.position[lane] = static_cast<float>(joint.position[r] - base);
  of.kinds |= 1u << static_cast<unsigned>(coordinate);
  if (law.looks_back()) of.springs |= static_cast<std::uint8_t>(1u << lane);
}

void set_frames(JointFrameBlock& of, std::size_t lane, const Joint& joint, const BodyTable& table) {
  const Eigen::Quaterniond first(table.orientation(joint.first) * joint.axes_first);
  const Eigen::Quaterniond second(table.orientation(joint.second) * joint.axes_second);
  JointFrames frames;
  frames.set_turn(first, second);
  for (int i = 0; i < 4; ++i) {
    of.axes_first[i][lane] = static_cast<float>(first.coeffs()[i]);
    of.turn[i][lane] = static_cast<float>(frames.turn.coeffs()[i]);
  }
  of.ratio[lane] = static_cast<float>(joint.ratio);
}

// Rates of coordinates, by the bodies' velocities as the step begins. Along rows as they act while the joint holds,
// what breaks the joint would count as well: a rotor would get that rate from nothing.
void start_rates(std::span<JointRowBlock> rows, std::size_t lane, const Joint& joint, const BodyTable& table) {
  const JointFrames frames = joint_frames(joint, table);
  for (std::size_t r = 0; r < joint.rows; ++r) {
    if (!joint.law[r].looks_back()) continue;
    const JointRow at = law_row(joint, r, frames, joint.position[r]).at;
    rows[r].rate[lane] = speed(at.rate(table.velocity(joint.first), table.angular_velocity(joint.first),
                                       table.velocity(joint.second), table.angular_velocity(joint.second)));
  }
}

// The rates that a row's springs and servo leave, of what the row answers with now to the law that `of` has.
void set_springs(JointRowBlock& row, const JointCoordinateBlock& of, std::size_t lane) {
  const double response = row.inverse_mass[lane];
  const double share = 1 / (1 + response * of.spring_slope[lane]);
  ATL_ASSERT(!(share < 0) && !(share > 1), lane, response, of.spring_slope[lane]);
  row.spring_scale[lane] = static_cast<float>(share);
  row.spring_shift[lane] = speed(share * response * of.spring_impulse[lane]);
  row.motor_part[lane] = motor_part(response * of.servo_slope[lane], share);
  row.motor_change[lane] = speed(share * response * of.motor_impulse[lane]);
  row.friction_change[lane] = speed(share * response * of.friction_impulse[lane]);
}

// The same where a soft end of the range, which leaks so much of its impulse, holds the coordinate too.
void soften_springs(JointRowBlock& row, const JointCoordinateBlock& of, std::size_t lane, double leak) {
  if (row.soft_lower[lane] == 0 && row.soft_upper[lane] == 0) return;
  const double response = row.inverse_mass[lane];
  const double left = 1 / (1 + response * of.spring_slope[lane] * leak);
  const double share = leak * left;  // 1 / (1 + hold + stiffness)
  row.soft_scale[lane] = static_cast<float>(share);
  row.soft_shift[lane] = speed(left * row.soft_shift[lane] + share * response * of.spring_impulse[lane]);
  row.soft_motor_part[lane] = motor_part(response * of.servo_slope[lane], share);
  row.soft_motor_change[lane] = static_cast<float>(left * row.soft_motor_change[lane]);
  row.soft_friction_change[lane] = static_cast<float>(left * row.soft_friction_change[lane]);
}

// The rate that springs, motors and friction make of a rate with the impulse that is carried, as lawful_rate() has it,
// but for the ends of the range.
double rate_by_law(const JointRowBlock& row, std::size_t lane, double rate) {
  const double free = rate - static_cast<double>(row.inverse_mass[lane]) * row.impulse[lane];
  const double part = row.motor_part[lane], max = row.motor_change[lane], friction = row.friction_change[lane];
  const auto driven = [&](double from) {
    return from + std::clamp(part * (row.next_motor_speed[lane] - from), -max, max);
  };
  const double sprung = row.spring_scale[lane] * free + row.spring_shift[lane];
  if (friction == 0) return driven(sprung);
  return std::min(std::max(driven(sprung - friction), 0.0), driven(sprung + friction));
}

// The law of springs, servos and armatures in a substep, from the rate before its forces: that at which the row left
// the coordinate. Whatever has moved bodies since did so without a rotor, which has kept it. `max_closed` as SpringStep
// has it.
void find_springs(JointRowBlock& row, JointCoordinateBlock& of, std::size_t lane, const Law& law, double position,
                  double max_closed, double h) {
  const double mass = row.mass[lane], free = of.response[lane], rate = row.rate[lane];
  ATL_ASSERT(!(mass <= 0) && !(free <= 0), lane, mass, free);
  JointRow at;
  at.value = position;
  at.share = of.share[lane];
  const LinearStep spring =
      law.springs() || law.armature > 0 ? LinearStep::of_spring(law, at, mass, 1 / free, h, max_closed) : LinearStep{};
  of.spring_slope[lane] = static_cast<float>(mass * spring.hold);
  of.spring_impulse[lane] = static_cast<float>(mass * (spring.shift + spring.keep * rate));
  const LinearStep servo = law.is_servo() ? LinearStep::of_servo(law, at, mass, h, max_closed) : LinearStep{};
  of.servo_slope[lane] = static_cast<float>(mass * servo.hold);
  if (servo.hold > 0) row.next_motor_speed[lane] = speed((servo.shift + servo.keep * rate) / servo.hold);
}

}  // namespace

double max_closed_of(const JointStep& step, std::uint32_t joint) {
  const int around = step.graph->joints_around(joint);
  ATL_ASSERT(around > 0, joint, around);
  return std::min(tuning::max_swept_closing, tuning::max_swept_closing_together / around);
}

BodyPose pose_now(const JointStep& step, std::uint32_t body, std::uint32_t local) {
  const DisplacementRows& displacement = step.bodies.displacement[local];
  return {step.table.position(body) + get3(displacement.linear),
          (rotation_of(displacement) * step.table.orientation(body)).normalized()};
}

void GroupJoints::clear() {
  joints_.clear();
  rows_.clear();
  may_bounce_ = false;
  has_forces_ = false;
}

void GroupJoints::colour(std::uint32_t first_dynamic, std::uint32_t body_count) {
  if (empty()) return;
  colouring_.build(joints_, first_dynamic, body_count, blocks_);
  const JointBlock& last = blocks_[colouring_.block_count() - 1];
  rows_.assign(last.first_row + last.rows, {});
  coordinates_.resize(rows_.size());
  frames_.resize(rows_.empty() ? 0 : colouring_.block_count());
  row_rates_.assign(may_bounce_ ? rows_.size() * block_lanes : 0, {});
}

void GroupJoints::prepare(const JointStep& step, std::size_t begin, std::size_t end) {
  constexpr std::size_t ahead = 2;
  for (std::size_t b = begin; b < end; ++b) {
    JointBlock& block = blocks_[b];
    if (b + ahead < end) {
      for (const std::int32_t ahead_joint : blocks_[b + ahead].joint) {
        const Joint& joint = step.joints[std::max(ahead_joint, 0)];
        jobs::prefetch(joint.anchor_first);
        jobs::prefetch(joint.anchor_second);
        jobs::prefetch(joint.point_impulse);
      }
    }
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      Vector3 arm_first = Vector3::Zero();
      Vector3 arm_second = Vector3::Zero();
      Vector3 offset = Vector3::Zero();
      Vector3 impulse = Vector3::Zero();
      Softness soft = step.constants.joint;
      if (block.joint[lane] >= 0) {
        const Joint& joint = step.joints[block.joint[lane]];
        soft = soft.shared_by(step.graph->parallel_joints(static_cast<std::uint32_t>(block.joint[lane])));
        arm_first = step.table.orientation(joint.first) * joint.anchor_first;
        arm_second = step.table.orientation(joint.second) * joint.anchor_second;
        offset = (step.table.position(joint.second) - step.table.position(joint.first)) + (arm_second - arm_first);
        impulse = joint.point_impulse / step.constants.refinement;
      }
      set_lane(block.start_arm_first, lane, arm_first);
      set_lane(block.start_arm_second, lane, arm_second);
      set_lane(block.start_offset, lane, offset);
      set_lane(block.impulse, lane, impulse);
      block.bias_rate[lane] = soft.bias_rate;
      block.mass_scale[lane] = soft.mass_scale;
      block.impulse_scale[lane] = soft.impulse_scale;
    }
  }
}

void GroupJoints::add_stiffness(const JointStep& step, std::span<Matrix3> stiffness, std::size_t begin,
                                std::size_t end) const {
  for (std::size_t b = begin; b < end; ++b) {
    const JointBlock& block = blocks_[b];
    if (!block.point) continue;
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      if (block.joint[lane] < 0) continue;
      const Vector3& tension = step.joints[block.joint[lane]].tension;
      const auto bit = 1u << lane;
      if (block.write_first & bit) {
        stiffness[static_cast<std::size_t>(block.first[lane])] +=
            arm_stiffness(get_lane(block.start_arm_first, lane), -tension);
      }
      if (block.write_second & bit) {
        stiffness[static_cast<std::size_t>(block.second[lane])] +=
            arm_stiffness(get_lane(block.start_arm_second, lane), tension);
      }
    }
  }
}

void GroupJoints::prepare_rows(const JointStep& step, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    JointBlock& block = blocks_[b];
    block.looks_back = 0;
    for (std::size_t r = 0; r < block.rows; ++r) {
      JointCoordinateBlock& of = coordinates_[block.first_row + r] = {};
      std::fill_n(of.coordinate, block_lanes, -1.0f);
    }
    for (std::size_t lane = 0; lane < block_lanes && block.rows > 0; ++lane) {
      if (block.joint[lane] < 0) continue;
      const Joint& joint = step.joints[block.joint[lane]];
      ATL_ASSERT(joint.rows <= block.rows && block.first_row + block.rows <= rows_.size(), block.joint[lane],
                 joint.rows, block.rows, rows_.size());
      set_frames(frames_[b], lane, joint, step.table);
      for (std::size_t r = 0; r < joint.rows; ++r) {
        const std::size_t row = block.first_row + r;
        set_coordinate(coordinates_[row], lane, joint, r, step.h);
        rows_[row].impulse[lane] = static_cast<float>(joint.impulse[r] / step.constants.refinement);
      }
      if (joint.looking_back() > 0) {
        block.looks_back = 1;
        start_rates(std::span(rows_).subspan(block.first_row, joint.rows), lane, joint, step.table);
      }
    }
  }
}

void GroupJoints::keep_springs(std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    const JointBlock& block = blocks_[b];
    for (std::size_t r = block.first_row; r < block.first_row + block.rows; ++r) {
      for (unsigned rest = coordinates_[r].springs; rest != 0; rest &= rest - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
        if (rows_[r].mass[lane] > 0) set_springs(rows_[r], coordinates_[r], lane);
      }
    }
  }
}

// The position of a coordinate where bodies are now. Joint::position is that of the start of the step until store().
double GroupJoints::position_now(const Joint& joint, std::size_t r, std::size_t row, std::size_t lane) const {
  return base_of(joint.coordinate[r], joint.position[r]) + coordinates_[row].position[lane];
}

void GroupJoints::begin_substep(const JointStep& step, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    const JointBlock& block = blocks_[b];
    for (std::size_t r = 0; r < block.rows; ++r) {
      const std::size_t number = block.first_row + r;
      JointRowBlock& row = rows_[number];
      JointCoordinateBlock& of = coordinates_[number];
      for (std::size_t lane = 0; lane < block_lanes && (may_bounce_ || of.springs != 0); ++lane) {
        const bool springs = (of.springs >> lane & 1u) != 0 && row.mass[lane] > 0;
        if (!springs && !may_bounce_) continue;
        if (may_bounce_) row_rates_[number * block_lanes + lane].before = rate_of(step.bodies, block, row, lane);
        if (!springs) continue;
        const auto id = static_cast<std::uint32_t>(block.joint[lane]);
        const Joint& joint = step.joints[id];
        const double value = base_of(joint.coordinate[r], joint.position[r]) + of.value[lane];
        const bool alone = step.graph->is_single(id) && joint.looking_back() == 1;
        const double max_closed = alone ? SpringStep::unlimited : max_closed_of(step, id);
        find_springs(row, of, lane, joint.law[r], value, max_closed, step.h);
        set_springs(row, of, lane);
        soften_springs(row, of, lane, block.impulse_scale[lane]);
      }
    }
  }
}

bool GroupJoints::record_impacts(const JointStep& step, std::size_t begin, std::size_t end) {
  ATL_ASSERT(row_rates_.size() == rows_.size() * block_lanes, row_rates_.size(), rows_.size());
  bool any = false;
  for (std::size_t b = begin; b < end; ++b) {
    JointBlock& block = blocks_[b];
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      if (block.joint[lane] < 0 || !step.joints[block.joint[lane]].bounces) continue;
      const Joint& joint = step.joints[block.joint[lane]];
      const JointFrames frames = frames_now(step, block, lane);
      for (std::size_t r = 0; r < joint.rows; ++r) {
        JointRowBlock& row = rows_[block.first_row + r];
        RowRate& rate = row_rates_[(block.first_row + r) * block_lanes + lane];
        rate.impact = {};
        const Law& law = joint.law[r];
        if (law.restitution == 0 || !(row.mass[lane] > 0)) continue;
        const double free_rate = rate_by_law(row, lane, rate_of(step.bodies, block, row, lane));
        const JointRow at = law_row(joint, r, frames, position_now(joint, r, block.first_row + r, lane)).at;
        const double falls = fall_by_own_spring(law, at, row.mass[lane], joint.motor_bound[r] != 0, step.h);
        rate.impact = LimitImpact::of(law, at.value, falls, rate.before, free_rate, step.h);
        row.open_ends[lane] = rate.impact.rests ? 0 : 1;
        any |= rate.impact.end != 0;
      }
    }
  }
  return any;
}

void GroupJoints::begin_bounces() {
  blocks_before_ = blocks_;
  rows_before_ = rows_;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      const LimitImpact& impact = row_rates_[r * block_lanes + lane].impact;
      if (impact.end == 0) continue;
      rows_[r].open_ends[lane] = 0;
      (impact.end < 0 ? rows_[r].lower_speed : rows_[r].upper_speed)[lane] = speed(impact.leaving_late);
    }
  }
}

void GroupJoints::end_bounces() {
  ATL_ASSERT(blocks_before_.size() == blocks_.size() && rows_before_.size() == rows_.size(), blocks_before_.size(),
             blocks_.size(), rows_before_.size(), rows_.size());
  for (std::size_t r = 0; r < rows_.size(); ++r) std::copy_n(rows_[r].rate, block_lanes, rows_before_[r].rate);
  std::copy(blocks_before_.begin(), blocks_before_.end(), blocks_.begin());  // kernels look for them there
  std::copy(rows_before_.begin(), rows_before_.end(), rows_.begin());
}

void GroupJoints::clear_impulses(std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    JointBlock& block = blocks_[b];
    for (auto& axis : block.impulse) std::fill_n(axis, block_lanes, 0.0f);
    for (std::size_t r = 0; r < block.rows; ++r) std::fill_n(rows_[block.first_row + r].impulse, block_lanes, 0.0f);
  }
}

void GroupJoints::store(const JointStep& step, std::size_t begin, std::size_t end) const {
  constexpr std::size_t ahead = 2;
  const double inverse_h = 1 / step.h;
  const double together = step.constants.refinement;
  for (std::size_t b = begin; b < end; ++b) {
    const JointBlock& block = blocks_[b];
    if (b + ahead < end) {
      for (const std::int32_t ahead_joint : blocks_[b + ahead].joint) {
        const Joint& joint = step.joints[std::max(ahead_joint, 0)];
        jobs::prefetch(joint.point_impulse);
        jobs::prefetch(joint.force);
        jobs::prefetch(joint.torque);
      }
    }
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      if (block.joint[lane] < 0) continue;
      Joint& joint = step.joints[block.joint[lane]];
      // The block knows enough of the joint's kind; reading the joint would take another cache line.
      Vector3 linear = block.point ? get_lane(block.impulse, lane) : Vector3(Vector3::Zero());
      Vector3 angular = Vector3::Zero();
      joint.point_impulse = together * linear;
      if (block.rows > 0) {
        const JointFrames frames = joint_frames(joint, step.table);  // bodies have their new poses
        for (std::size_t r = 0; r < joint.rows; ++r) {
          const JointRowBlock& row = rows_[block.first_row + r];
          const double impulse = row.impulse[lane];
          const Vector3 along = get_lane(row.linear, lane);
          linear += impulse * along;
          angular += impulse * (get_lane(row.angular_second, lane) - frames.arm_second.cross(along));
          joint.impulse[r] = together * impulse;
          const LawRow now = law_row(joint, r, frames, position_now(joint, r, block.first_row + r, lane));
          if (std::isfinite(now.position)) joint.position[r] = now.position;
          joint.limit[r] = limit_reached(joint.law[r], now.at.value, joint.limit[r]);
        }
      }
      joint.force = inverse_h * linear;
      joint.tension += tuning::tension_smoothing * (joint.force - joint.tension);
      joint.torque = inverse_h * angular;
    }
  }
}

std::int8_t limit_reached(const Law& law, double position, std::int8_t before) {
  if (law.locked()) return 0;
  const double near = std::min(1e-3, 0.01 * (law.upper - law.lower));
  const auto reaches = [&](double room, std::int8_t end) { return room <= (before == end ? 2 * near : near); };
  if (reaches(position - law.lower, -1)) return -1;
  if (reaches(law.upper - position, 1)) return 1;
  return 0;
}

}  // namespace atl::solver
