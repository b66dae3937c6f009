#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "direct/island_joints.h"
#include "direct/island_solves.h"
#include "direct/joint_leapfrog.h"

namespace atl::solver {
namespace {

// m or rad: how far a row is from where it is held; 0 of what is free.
double gap_of(const Joint& of, const DirectJoint& joint, std::size_t row, double value) {
  const Law& law = law_of(of, row);
  if (law.locked()) return value - law.lower;
  const int limit = joint.law[row].limit(joint.rate[row]);
  return limit == 0 ? 0 : value - (limit < 0 ? law.lower : law.upper) - joint.beyond[row];
}

// Finds the gaps of all rows of a joint at these poses.
void find_gaps(const Joint* joints, const DirectJoint& joint, const IslandPoses& poses,
               DirectJoint::Rows<double>& gap) {
  const Joint& of = joints[joint.joint];
  if (joint.is_tendon()) {
    double length = 0;
    for (std::size_t i = 0; i < joint.terms; ++i) {
      length += term_at(joints, joint, i, poses, joint.term[i].row.position).value;
    }
    gap[0] = gap_of(of, joint, 0, length);
    return;
  }
  const BodyPose first = poses.of(joint.first, joint.first_body);
  const BodyPose second = poses.of(joint.second, joint.second_body);
  std::size_t r = 0;
  if (of.point) {
    const Vector3 offset = (second.position - first.position) +
                           (second.orientation * of.anchor_second - first.orientation * of.anchor_first);
    for (; r < 3; ++r) gap[r] = offset[static_cast<Eigen::Index>(r)];
  }
  if (r == joint.rows) return forget_still(joint, gap);
  const JointFrames frames = joint_frames(of, first.position, first.orientation, second.position, second.orientation);
  for (std::size_t k = 0; r < joint.rows; ++r, ++k) {
    gap[r] = gap_of(of, joint, r, law_row(of, k, frames, joint.position[r]).at.value);
  }
  forget_still(joint, gap);
}

double widest(const DirectJoint& joint, const DirectJoint::Rows<double>& gap) {
  double max = 0;
  for (std::size_t r = 0; r < joint.rows; ++r) {
    max = std::max(max, std::abs(gap[r]));
  }
  return max;
}

double widest_gap(const Joint* joints, const std::vector<DirectJoint>& all, const IslandPoses& poses) {
  double max = 0;
  DirectJoint::Rows<double> gap;
  for (const DirectJoint& joint : all) {
    find_gaps(joints, joint, poses, gap);
    max = std::max(max, widest(joint, gap));
  }
  return max;
}

// Keeps all gaps. Returns the widest.
double update_gaps(const Joint* joints, const IslandPoses& poses, std::vector<DirectJoint>& all) {
  double max = 0;
  for (DirectJoint& joint : all) {
    find_gaps(joints, joint, poses, joint.gap);
    max = std::max(max, widest(joint, joint.gap));
  }
  return max;
}

// m or rad, of what would close joints.
double longest_move(const std::vector<double>& by) {
  double max = 0;
  for (std::size_t i = 0; i < by.size(); i += 3) max = std::max(max, Eigen::Map<const Vector3>(&by[i]).norm());
  return max;
}

// Moves bodies by a part of the closing motion if no gap is wider than `max_gap` then. Returns whether they are moved.
bool move_if_closer(const SolveInput& input, double time, double share, double max_gap, std::vector<MovingBody>& bodies,
                    const IslandMotions& motions) {
  for (MovingBody& body : bodies) body.before = body.now;
  move(bodies, share, motions.search.direction);
  if (widest_gap(input.joints, motions.problem.joints, {input.bodies, bodies, time}) <= max_gap) return true;
  for (MovingBody& body : bodies) body.now = body.before;
  return false;
}

// Moves bodies by as much of the closing motion as closes anything. Returns how much that was, or 0 if nothing does.
double move_closer(const SolveInput& input, double time, double gap_before, std::vector<MovingBody>& bodies,
                   const IslandMotions& motions) {
  const double max_gap = std::max(gap_before, tuning::open_gap);
  double share = std::min(1.0, tuning::far_at_rest / longest_move(motions.search.direction));
  for (int round = 0; round < tuning::max_shortenings; ++round, share *= 0.25) {
    if (move_if_closer(input, time, share, max_gap, bodies, motions)) return share;
  }
  return 0;
}

// Bodies keep the velocities by which joints were closed, and rotors turn with them, unless that makes energy. Returns
// whether they do.
bool gain_by_closing(const Joint* joints, std::span<const MovingBody> bodies, double scale, IslandMotions& motions) {
  std::vector<double>& direction = motions.search.direction;
  std::vector<double>& after = motions.search.gradient;
  IslandProblem& problem = motions.problem;
  for (std::size_t i = 0; i < direction.size(); ++i) after[i] = motions.lasting[i] + scale * direction[i];
  const bool alone = problem.contacts.empty();
  const double given = scale * work_of_bases(problem, &DirectJoint::closing);
  if (gains_energy(joints, problem, bodies, given, motions.lasting, after, Rotors::Keep)) return false;
  for (DirectJoint& joint : problem.joints) {
    if (!alone || !joints[joint.joint].is_actuated()) continue;
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) joint.kept[r] += scale * joint.rate_by(direction, r);
  }
  motions.lasting.swap(after);
  return true;
}

// Coordinates go with the bodies: of those that are a rate only nothing else tells where they are.
void follow_coordinates(const std::vector<double>& direction, double share, std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    joint.move_terms(direction, share);
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      joint.position[r] += share * joint.rate_by(direction, r);
    }
  }
}

// Finds the impulses of the closing motion.
void find_closing_impulses(IslandProblem& problem, const BalanceSearch& search) {
  const double* impulse = search.matrix.joints() != nullptr ? search.impulses.data() : nullptr;
  for (DirectJoint& joint : problem.joints) {
    if (impulse != nullptr) {
      std::copy_n(impulse, joint.rows, joint.closing.begin());
      impulse += joint.rows;
      continue;
    }
    DirectJoint::Rows<double> rates;
    joint.rates_by(search.direction.data(), rates.data());
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const double slope = joint.gap[r] != 0 ? joint.law[r].slope(joint.rate[r]) : 0;
      joint.closing[r] = -slope * (joint.gap[r] + rates[r]);
    }
  }
}

// Takes the impulses of a substep for those of a closing motion.
void close_as_pulled(double h, std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    for (std::size_t r = 0; r < joint.rows; ++r) joint.closing[r] = h * joint.lasting[r];
  }
}

void add_closing_impulses(double scale, std::vector<DirectJoint>& all) {
  for (DirectJoint& joint : all) {
    for (std::size_t r = 0; r < joint.rows; ++r) joint.lasting[r] += scale * joint.closing[r];
  }
}

}  // namespace

// By Newton's method: by one step along the rows of the substep's start, and where gaps are left, along rows that
// follow, with the curvature of gaps. Under what presses on joints, where that is not near, along rows that follow
// alone; what pulled on them in the substep is then the first guess of what closes them.
void close_joints(const SolveInput& input, double time, double h, std::vector<MovingBody>& bodies,
                  IslandMotions& motions) {
  IslandProblem& problem = motions.problem;
  const bool has_contacts = !problem.contacts.empty();
  const IslandPoses poses{input.bodies, bodies, time};
  double max = update_gaps(input.joints, poses, problem.joints);
  double share = 1;
  for (int round = 0; round == 0 || (max > tuning::open_gap && round < tuning::max_closing_steps); ++round) {
    if (round > 0 || (has_contacts && max > tuning::open_gap)) {
      place_joints(input, time, h, bodies, problem);
      if (round == 0) close_as_pulled(h, problem.joints);
      add_closing_stiffness(input.joints, problem);
      if (motions.search.matrix.joints() == nullptr) weigh_locks(input.joints, problem);
      if (!motions.search.matrix.factor(problem)) return restore_masses(input.bodies, problem);
    } else if (!has_contacts && !is_factored(problem) && !motions.search.matrix.factor(problem)) {
      return;
    }
    find_closing_motion(problem, motions.search, [](const DirectJoint& joint, std::size_t r) { return joint.gap[r]; });
    find_closing_impulses(problem, motions.search);
    restore_masses(input.bodies, problem);
    // A small gap that closes by short moves needs no line search: Newton's step leaves less.
    const double longest = longest_move(motions.search.direction);
    const bool near = max <= tuning::open_gap && longest * longest <= tuning::open_gap;
    const double share_before = share;
    share = near ? 1 : move_closer(input, time, max, bodies, motions);
    if (near) move(bodies, 1, motions.search.direction);
    // A motion that can't be shortened enough still tells how gaps curve, for the next one.
    if (share == 0 && share_before == 0) break;
    follow_coordinates(motions.search.direction, share, problem.joints);
    if (motions.pushes || gain_by_closing(input.joints, bodies, share / h, motions)) {
      add_closing_impulses(share / h, problem.joints);
    }
    if (near) break;
    max = update_gaps(input.joints, poses, problem.joints);
  }
  follow_tension(problem, h);
}

bool settle_joints(const SolveInput& input, std::vector<MovingBody>& bodies, IslandMotions& motions) {
  const IslandPoses poses{input.bodies, bodies, input.dt};
  const double max = update_gaps(input.joints, poses, motions.problem.joints);
  if (max <= tuning::settled_gap) return true;
  find_closing_motion(motions.problem, motions.search,
                      [](const DirectJoint& joint, std::size_t r) { return joint.law[r].locked ? joint.gap[r] : 0; });
  if (longest_move(motions.search.direction) > tuning::far_at_rest) return false;
  if (!move_if_closer(input, input.dt, 1, max, bodies, motions)) return false;
  turn_inertia(bodies);
  follow_coordinates(motions.search.direction, 1, motions.problem.joints);
  return max <= tuning::open_gap;
}

}  // namespace atl::solver
