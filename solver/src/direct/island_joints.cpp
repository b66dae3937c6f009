#include "direct/island_joints.h"

#include <jobs/assert.h>
#include <solver/direct/island_matrix.h>
#include <solver/tuning.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace atl::solver {
namespace {

// 1/kg: the responses of a point's three rows, the diagonal of [arm] W [arm]^T and 1 / m.
void add_point_response(const DirectBody& body, const Vector3& arm, double (&to)[3]) {
  const Matrix3& w = body.inverse_inertia;
  const double x = arm.x(), y = arm.y(), z = arm.z();
  to[0] += body.inverse_mass[0] + (z * z * w(1, 1) + y * y * w(2, 2) - 2 * (y * z * w(2, 1)));
  to[1] += body.inverse_mass[1] + (z * z * w(0, 0) + x * x * w(2, 2) - 2 * (x * z * w(2, 0)));
  to[2] += body.inverse_mass[2] + (y * y * w(0, 0) + x * x * w(1, 1) - 2 * (x * y * w(1, 0)));
}

void place_arms(const Joint* joints, const IslandPoses& poses, std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    const Joint& of = joints[joint.joint];
    joint.arm_first = poses.of(joint.first, joint.first_body).orientation * of.anchor_first;
    joint.arm_second = poses.of(joint.second, joint.second_body).orientation * of.anchor_second;
  }
}

void place_terms(const Joint* joints, const IslandPoses& poses, DirectJoint& tendon) {
  tendon.at[0] = {};
  for (std::size_t i = 0; i < tendon.terms; ++i) {
    TermRow& row = tendon.term[i].row;
    row = term_at(joints, tendon, i, poses, row.position);
    tendon.at[0].value += row.value;
  }
  tendon.position[0] = tendon.at[0].value;
}

void place_rows(const Joint& of, const BodyPose& first, const BodyPose& second, DirectJoint& joint) {
  std::size_t r = joint.point_rows();
  if (r == joint.rows) return;
  const JointFrames frames = joint_frames(of, first.position, first.orientation, second.position, second.orientation);
  for (std::size_t k = 0; r < joint.rows; ++r, ++k) {
    const LawRow now = law_row(of, k, frames, joint.position[r]);
    joint.at[r] = now.at;
    joint.position[r] = now.position;
  }
}

// 1/kg or 1/(kg m^2): what an impulse along a row makes of its rate by a body.
double response_of(const DirectBody& body, const Vector3& linear, const Vector3& angular) {
  return linear.dot(body.inverse_mass.cwiseProduct(linear)) + angular.dot(body.inverse_inertia * angular);
}

bool has_locks(const std::vector<DirectBody>& bodies, const DirectJoint& joint) {
  const auto is_locked = [&](std::uint32_t body) { return body != no_body && bodies[body].locks != 0; };
  return is_locked(joint.first) || is_locked(joint.second);
}

// Finds the rows along which motion locks let nothing move: what is left of their response is rounding, by which an
// impulse would have no bound. A lock there has nothing to hold.
void find_still(const std::vector<DirectBody>& bodies, DirectJoint& joint) {
  joint.still = 0;
  if (joint.is_tendon() || !has_locks(bodies, joint)) return;
  for (std::size_t r = 0; r < joint.rows; ++r) {
    const JointRow at = joint.row(r);
    double left = 0, without_locks = 0;
    const auto add = [&](std::uint32_t body, const Vector3& angular) {
      if (body == no_body) return;
      const DirectBody& of = bodies[body];
      left += response_of(of, at.linear, angular);
      without_locks += (at.linear.squaredNorm() + angular.squaredNorm() / (of.radius * of.radius)) / of.mass;
    };
    add(joint.first, at.angular_first);
    add(joint.second, at.angular_second);
    if (!(left > tuning::min_response_share * without_locks)) joint.still |= static_cast<std::uint8_t>(1 << r);
    if (joint.is_lock(r)) joint.law[r].locked = !joint.is_still(r);
  }
}

void weigh_tendon(const std::vector<DirectBody>& bodies, DirectJoint& tendon) {
  double responds = 0;
  for (const PulledBody& body : tendon.pulled()) {
    if (body.body == no_body) continue;
    const DirectBody& of = bodies[body.body];
    responds += response_of(of, body.linear, body.angular);
  }
  tendon.mass[0] = responds > 0 ? 1 / responds : 0;
}

// Effective masses of rows: `locked`, or of the others.
void weigh_rows(const Joint& of, const std::vector<DirectBody>& bodies, bool locked, DirectJoint& joint) {
  if (joint.is_tendon()) {
    if (of.law[0].locked() == locked) weigh_tendon(bodies, joint);
    return;
  }
  const auto response = [&](std::uint32_t body, const Vector3& linear, const Vector3& angular) {
    if (body == no_body) return 0.0;
    return response_of(bodies[body], linear, angular);
  };
  if (joint.point && locked) {
    double responds[3] = {0, 0, 0};
    if (joint.first != no_body) add_point_response(bodies[joint.first], joint.arm_first, responds);
    if (joint.second != no_body) add_point_response(bodies[joint.second], joint.arm_second, responds);
    for (std::size_t r = 0; r < 3; ++r) {
      // Locks may leave nothing of it, and so may rounding, with arms of 1e12 m.
      joint.mass[r] = responds[r] > 0 && !joint.is_still(r) ? 1 / responds[r] : 0;
    }
  }
  for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
    if (law_of(of, r).locked() != locked) continue;
    const JointRow& at = joint.at[r];
    const double responds =
        response(joint.first, at.linear, at.angular_first) + response(joint.second, at.linear, at.angular_second);
    joint.mass[r] = responds > 0 && !joint.is_still(r) ? 1 / responds : 0;
  }
}

// The part of a tendon's rate by bodies of a term that don't respond.
double given_rate(const BodyTable& table, const DirectTerm& term) {
  const auto motion = [&](std::uint32_t local, std::uint32_t body) {
    return local != no_body ? std::pair<Vector3, Vector3>(Vector3::Zero(), Vector3::Zero())
                            : std::pair<Vector3, Vector3>(table.velocity(body), table.angular_velocity(body));
  };
  const auto [v_first, w_first] = motion(term.first, term.first_body);
  const auto [v_second, w_second] = motion(term.second, term.second_body);
  return term.row.slope * term.row.at.rate(v_first, w_first, v_second, w_second);
}

// The rates of rows by what doesn't respond.
void give_rates(const BodyTable& table, DirectJoint& joint) {
  if (joint.is_tendon()) {
    joint.given[0] = 0;
    for (std::size_t i = 0; i < joint.terms; ++i) joint.given[0] += given_rate(table, joint.term[i]);
    return;
  }
  if (joint.first != no_body && joint.second != no_body) return;
  for (std::size_t r = 0; r < joint.rows; ++r) {
    const JointRow at = joint.row(r);
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

// m or rad: how far a coordinate is beyond its range, but for what one substep closes.
double left_beyond(const Law& law, double value, double closed) {
  return std::max(value - law.upper - closed, 0.0) + std::min(value - law.lower + closed, 0.0);
}

// The rate at the end from which a coordinate goes back into its range.
double& end_rate(RowLaw& law, double back) { return back > 0 ? law.lower_rate : law.upper_rate; }

// A rate on the piece that a motor, or dry friction, was on; or the rate before, where that is more than they can stop.
// By a small one, as rounding leaves it where they hold or let a coordinate creep, they would seem to slip.
double rate_on_piece(double rate, double mass, double speed, double impulse, double slope, int bound) {
  if (!(std::abs(rate - speed) * mass < impulse)) return rate;
  const double reach = 2 * impulse / slope;
  return bound == 0 ? speed : bound > 0 ? std::min(rate, speed - reach) : std::max(rate, speed + reach);
}

// The search begins on the pieces that rows were on.
void start_rate(const Law& of, bool reaches_ends, DirectJoint& joint, std::size_t row) {
  const RowLaw& law = joint.law[row];
  double& rate = joint.rate[row] = joint.rate_before[row];
  if (law.friction_slope > 0) {
    rate = rate_on_piece(rate, joint.mass[row], law.friction_speed, law.friction_impulse, law.friction_slope,
                         joint.friction_bound[row]);
  }
  if (of.drives() && !of.is_servo() && law.motor_slope > 0) {
    rate = rate_on_piece(rate, joint.mass[row], law.motor_speed, law.motor_impulse, law.motor_slope,
                         joint.motor_bound[row]);
  }
  if (reaches_ends) start_at_limit(joint, row);
}

// 1/s^2: by how much the acceleration along a coordinate falls by its way, by what springs and servos make of it as all
// coordinates go on at their rates.
double fall_along(const Joint* joints, IslandProblem& problem, BalanceSearch& search, const DirectJoint& of,
                  std::size_t row) {
  if (of.rate[row] == 0 || (!is_factored(problem) && !search.matrix.factor(problem))) return 0;
  std::vector<double>& answer = search.direction;
  of.set_momenta(row, answer);
  search.matrix.solve(problem, answer);
  double sum = 0;
  for (const DirectJoint& joint : problem.joints) {
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      const Law& law = law_of(joints[joint.joint], r);
      if (law.locked() || !(joint.mass[r] > 0)) continue;
      const bool at_bound = joint.law[r].motor_bound(joint.rate[r]) != 0;
      const double stiffness =
          (joint.mass[r] + law.armature) * force_on(law, joint.at[r], joint.mass[r], at_bound).square_of_omega;
      if (stiffness > 0) sum += stiffness * joint.rate_by(answer, r) * joint.rate[r];
    }
  }
  return sum / of.rate[row];
}

// Locks ask for no rate.
void release_locks(const Joint& of, DirectJoint& joint) {
  joint.bend = {};
  for (std::size_t r = 0; r < joint.rows; ++r) {
    if (law_of(of, r).locked()) joint.law[r].lock_rate = 0;
  }
}

}  // namespace

TermRow term_at(const Joint* joints, const DirectJoint& tendon, std::size_t i, const IslandPoses& poses,
                double before) {
  const DirectTerm& term = tendon.term[i];
  const TendonTerm& of = joints[tendon.joint].term[i];
  return term_row(of, joints[of.joint], poses.of(term.first, term.first_body), poses.of(term.second, term.second_body),
                  before);
}

RowKinds load_joints(const Joint* all, const IslandMembers& members, std::vector<DirectJoint>& joints) {
  RowKinds kinds;
  auto ends = members.term_ends.begin();
  ATL_ASSERT(members.ends.size() == members.joints.size() && joints.size() == members.joints.size(),
             members.ends.size(), joints.size(), members.joints.size());
  for (std::size_t j = 0; j < members.joints.size(); ++j) {
    const JointLink& link = members.joints[j];
    const Joint& from = all[link.joint];
    DirectJoint& joint = joints[j];
    joint.joint = link.joint;
    joint.first_body = link.first;
    joint.second_body = link.second;
    joint.first = members.ends[j].first;
    joint.second = members.ends[j].second;
    joint.point = from.point;
    joint.rows = from.row_count();
    joint.tension = from.tension;
    joint.position = {};
    joint.given = joint.beyond = joint.back = {};
    joint.joined = {};
    joint.share.fill(1);
    joint.impulse = {};
    joint.rate = joint.kept = {};
    joint.bend = {};
    joint.bounces = {};
    joint.impact = {};
    joint.limit = joint.motor_bound = joint.friction_bound = {};
    joint.terms = from.terms;
    for (std::size_t i = 0; i < from.terms; ++i, ++ends) {
      const Joint& of = all[from.term[i].joint];
      joint.term[i] = {of.first, of.second, ends->first, ends->second, {}};
      joint.term[i].row.position = from.term[i].position;
    }
    ATL_ASSERT(joint.rows >= 1 && joint.rows <= max_joint_rows, link.joint, joint.rows);
    const std::size_t points = joint.point_rows();
    joint.locks = joint.still = 0;
    for (std::size_t r = 0; r < joint.rows; ++r) {
      joint.law[r] = {.locked = law_of(from, r).locked()};
      joint.locks |= static_cast<std::uint8_t>(joint.law[r].locked ? 1 << r : 0);
    }
    for (std::size_t r = points; r < joint.rows; ++r) {
      const Law& law = from.law[r - points];
      joint.position[r] = from.position[r - points];
      joint.limit[r] = from.limit[r - points];
      joint.motor_bound[r] = from.motor_bound[r - points];
      joint.friction_bound[r] = from.friction_bound[r - points];
      kinds.all_locked &= law.locked();
      kinds.acts |= law.looks_back() || law.drives() || law.friction > 0;
      kinds.looks_back |= law.looks_back();
      kinds.damps |= !law.locked() && law.damps();
      kinds.bounces |= law.restitution > 0;
    }
  }
  ATL_ASSERT(ends == members.term_ends.end(), members.term_ends.size());
  return kinds;
}

const Law& law_of(const Joint& joint, std::size_t row) {
  ATL_ASSERT(row < joint.row_count(), row, joint.row_count());
  static constexpr Law locked{.lower = 0, .upper = 0};
  const std::size_t points = joint.point ? 3 : 0;
  return row < points ? locked : joint.law[row - points];
}

void place_joints(const SolveInput& input, double time, double h, std::vector<MovingBody>& bodies,
                  IslandProblem& problem) {
  const IslandPoses poses{input.bodies, bodies, time};
  place_arms(input.joints, poses, problem.joints);
  place_inertia(problem, bodies, h);
  for (DirectJoint& joint : problem.joints) {
    if (joint.is_tendon()) {
      place_terms(input.joints, poses, joint);
    } else {
      place_rows(input.joints[joint.joint], poses.of(joint.first, joint.first_body),
                 poses.of(joint.second, joint.second_body), joint);
    }
    find_still(problem.bodies, joint);
    weigh_rows(input.joints[joint.joint], problem.bodies, false, joint);
    give_rates(input.bodies, joint);
  }
  forget_rows(problem);
}

void weigh_locks(const Joint* joints, IslandProblem& problem) {
  ATL_ASSERT(problem.lock_compliance > 0, problem.lock_compliance);
  for (DirectJoint& joint : problem.joints) {
    const Joint& of = joints[joint.joint];
    weigh_rows(of, problem.bodies, true, joint);
    for (std::size_t r = 0; r < joint.rows; ++r) {
      if (law_of(of, r).locked()) joint.law[r].stiffness = joint.mass[r] / problem.lock_compliance;
    }
  }
}

void forget_still(const DirectJoint& joint, DirectJoint::Rows<double>& values) {
  for (unsigned rest = joint.still; rest != 0; rest &= rest - 1) values[std::countr_zero(rest)] = 0;
}

void find_rates(const std::vector<double>& velocities, const DirectJoint& joint, DirectJoint::Rows<double>& rates) {
  joint.rates_by(velocities.data(), rates.data());
  for (std::size_t r = 0; r < joint.rows; ++r) rates[r] += joint.given[r];
}

void record_rates(const std::vector<double>& velocities, std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    find_rates(velocities, joint, joint.rate_before);
  }
}

void begin_laws(const Joint* joints, double h, IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    const Joint& of = joints[joint.joint];
    release_locks(of, joint);
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      const Law& law = law_of(of, r);
      if (law.locked()) continue;
      joint.law[r] = RowLaw::of(law, joint.at[r], joint.row_mass(r), h, problem.lock_compliance);
      joint.beyond[r] = left_beyond(law, joint.at[r].value, h * tuning::closing_speed);
      joint.back[r] = 0;
      if (law.looks_back()) joint.law[r].start_at(joint.rate_before[r]);
      start_rate(law, problem.contacts.empty(), joint, r);
    }
  }
}

void start_at_limit(DirectJoint& joint, std::size_t row) {
  constexpr double beyond = 1e-12;
  const RowLaw& law = joint.law[row];
  double& rate = joint.rate[row];
  if (joint.limit[row] < 0) rate = std::min(rate, law.lower_rate - beyond * (1 + std::abs(law.lower_rate)));
  if (joint.limit[row] > 0) rate = std::max(rate, law.upper_rate + beyond * (1 + std::abs(law.upper_rate)));
}

int count_rows_at_ends(const std::vector<DirectJoint>& all) {
  int count = 0;
  for (const DirectJoint& joint : all) {
    count += static_cast<int>(std::count_if(joint.limit.begin(),
                                            joint.limit.begin() + static_cast<std::ptrdiff_t>(joint.rows),
                                            [](int end) { return end != 0; }));
  }
  return count;
}

void stop_at_ends(std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      RowLaw& law = joint.law[r];
      const double back = law.lower_rate > 0 ? law.lower_rate : std::min(law.upper_rate, 0.0);
      if (law.locked || std::abs(back) <= tuning::resting_speed) continue;
      joint.back[r] = back;
      end_rate(law, back) = 0;
      joint.rate[r] = joint.rate_before[r];
      start_at_limit(joint, r);
    }
  }
}

bool any_goes_back(const std::vector<DirectJoint>& all) {
  return std::any_of(all.begin(), all.end(), [](const DirectJoint& joint) {
    return std::any_of(joint.back.begin(), joint.back.begin() + static_cast<std::ptrdiff_t>(joint.rows),
                       [](double back) { return back != 0; });
  });
}

void begin_going_back(std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    joint.kept_rate = joint.rate;
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      if (joint.back[r] != 0) end_rate(joint.law[r], joint.back[r]) = joint.back[r];
    }
  }
}

void end_going_back(std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    joint.rate = joint.kept_rate;
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      if (joint.back[r] != 0) end_rate(joint.law[r], joint.back[r]) = 0;
    }
  }
}

void find_falls(const Joint* joints, double h, IslandProblem& problem, BalanceSearch& search) {
  for (DirectJoint& joint : problem.joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const Law& law = law_of(joints[joint.joint], r);
      const double there = joint.at[r].value + h * joint.rate[r];
      if (law.restitution == 0 || joint.limit[r] != 0 || (law.lower <= there && there <= law.upper)) continue;
      joint.impact[r].falls = fall_along(joints, problem, search, joint, r);
    }
  }
}

void record_impacts(const Joint* joints, double h, std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const Law& law = law_of(joints[joint.joint], r);
      if (law.restitution == 0) continue;
      joint.impact[r] = joint.limit[r] != 0 ? LimitImpact{}
                                            : LimitImpact::of(law, joint.at[r].value, joint.impact[r].falls,
                                                              joint.rate_before[r], joint.rate[r], h);
    }
  }
}

void record_armature_rates(const Joint* joints, const std::vector<double>& velocities, std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    if (!joints[joint.joint].is_actuated()) continue;
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      if (law_of(joints[joint.joint], r).armature == 0) continue;
      joint.kept[r] = joint.rate_by(velocities, r, joint.given[r]) + joint.bend[r];
    }
  }
}

void hold_rows(const Joint* joints, IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    const Joint& of = joints[joint.joint];
    release_locks(of, joint);
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      const Law& law = law_of(of, r);
      if (law.locked()) continue;
      const RowLaw before = joint.law[r];
      joint.law[r] = {};
      joint.limit[r] = static_cast<std::int8_t>(before.limit(joint.rate[r]));
      joint.motor_bound[r] = static_cast<std::int8_t>(before.motor_bound(joint.rate[r]));
      joint.friction_bound[r] = static_cast<std::int8_t>(before.friction_bound(joint.rate[r]));
      // Rows have turned with the bodies, and an armature pays for what that makes of its rate.
      joint.law[r].spring_slope = law.armature;
      joint.law[r].spring_rate = joint.kept[r];
      joint.bounces[r] = law.restitution > 0 && joint.limit[r] * joint.impact[r].end > 0;
      if (joint.is_still(r) || !before.holds(joint.rate[r])) continue;
      joint.law[r].locked = true;
      joint.law[r].stiffness = joint.mass[r] / problem.lock_compliance;
      if (joint.bounces[r]) joint.law[r].lock_rate = joint.impact[r].leaving_late;
    }
  }
}

void follow_tension(IslandProblem& problem, double h) {
  for (DirectJoint& joint : problem.joints) {
    const Vector3 force = joint.linear_impulse(joint.lasting) / h;
    joint.tension += tuning::tension_smoothing * (force - joint.tension);
  }
}

void write_back_joints(const SolveInput& input, const std::vector<DirectJoint>& joints) {
  const double over_h = input.settings.substeps / input.dt;
  const double together = input.settings.refinement;  // as of substeps that were asked for
  for (const DirectJoint& from : joints) {
    Joint& joint = input.joints[from.joint];
    for (std::size_t i = 0; i < from.terms; ++i) joint.term[i].position = from.term[i].row.position;
    joint.tension = from.tension;
    joint.force.setZero();
    joint.torque.setZero();
    std::size_t r = 0;
    if (joint.point) {
      for (; r < 3; ++r) joint.point_impulse[static_cast<Eigen::Index>(r)] = together * from.lasting[r];
      joint.force = over_h * Eigen::Map<const Vector3>(from.lasting.data());
    }
    for (std::size_t k = 0; r < from.rows; ++r, ++k) {
      const JointRow& at = from.at[r];
      joint.impulse[k] = together * from.lasting[r];
      joint.position[k] = from.position[r];
      joint.limit[k] = from.limit[r];
      joint.motor_bound[k] = from.motor_bound[r];
      joint.friction_bound[k] = from.friction_bound[r];
      if (from.is_tendon()) {
        joint.force.x() = over_h * from.lasting[r];
        continue;  // it has no arms, which a torque would go by
      }
      joint.force += over_h * from.lasting[r] * at.linear;
      joint.torque += over_h * from.lasting[r] * (at.angular_second - from.arm_second.cross(at.linear));
    }
  }
}

}  // namespace atl::solver
