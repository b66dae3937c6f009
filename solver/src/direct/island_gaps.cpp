#include "direct/island_gaps.h"

#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "direct/island_joints.h"

namespace atl::solver {
namespace {

// m or rad: how far a row is from where it is held; 0 of what is free.
double gap_of(const Joint& of, const DirectJoint& joint, std::size_t row, double value) {
  const Law& law = law_of(of, row);
  if (law.locked()) return value - law.lower;
  const int limit = joint.law[row].limit(joint.rate[row]);
  return limit < 0 ? value - law.lower : limit > 0 ? value - law.upper : 0;
}

// Of all rows of a joint, at these poses.
DirectJoint::Rows<double> gaps_of(const Joint& of, const DirectJoint& joint, const IslandPoses& poses) {
  DirectJoint::Rows<double> gap = {};
  const BodyPose first = poses.of(joint.first, joint.first_body);
  const BodyPose second = poses.of(joint.second, joint.second_body);
  std::size_t r = 0;
  if (of.point) {
    const Vector3 offset = (second.position - first.position) +
                           (second.orientation * of.anchor_second - first.orientation * of.anchor_first);
    for (; r < 3; ++r) gap[r] = offset[static_cast<Eigen::Index>(r)];
  }
  if (r == joint.rows) return gap;
  const JointFrames frames = joint_frames(of, first.position, first.orientation, second.position, second.orientation);
  for (std::size_t k = 0; r < joint.rows; ++r, ++k) {
    gap[r] = gap_of(of, joint, r, law_row(of, k, frames, joint.position[r]).at.value);
  }
  return gap;
}

double widest(const DirectJoint& joint, const DirectJoint::Rows<double>& gap) {
  double most = 0;
  for (std::size_t r = 0; r < joint.rows; ++r) {
    if (!joint.torn[r]) most = std::max(most, std::abs(gap[r]));
  }
  return most;
}

// The widest of what is not torn.
double widest_gap(const Joint* joints, const std::vector<DirectJoint>& all, const IslandPoses& poses) {
  double most = 0;
  for (const DirectJoint& joint : all) {
    most = std::max(most, widest(joint, gaps_of(joints[joint.joint], joint, poses)));
  }
  return most;
}

// Keeps all gaps. Returns the widest of what is not torn.
double note_gaps(const Joint* joints, const IslandPoses& poses, std::vector<DirectJoint>& all) {
  double most = 0;
  for (DirectJoint& joint : all) {
    joint.gap = gaps_of(joints[joint.joint], joint, poses);
    most = std::max(most, widest(joint, joint.gap));
  }
  return most;
}

constexpr auto sound_gap = [](const DirectJoint& joint, std::size_t r) { return joint.torn[r] ? 0 : joint.gap[r]; };

// m or rad, of what would close joints.
double longest_move(const std::vector<double>& by) {
  double most = 0;
  for (std::size_t i = 0; i < by.size(); i += 3) most = std::max(most, Eigen::Map<const Vector3>(&by[i]).norm());
  return most;
}

// Moves bodies by as much of the closing motion as closes anything. Returns how much that was, or 0 if nothing does.
double move_closer(const DirectIslandInput& input, double time, double gap_before, std::vector<MovingBody>& bodies,
                   const IslandMotions& motions) {
  for (MovingBody& body : bodies) body.before = body.now;
  double share = std::min(1.0, tuning::far_at_rest / longest_move(motions.search.direction));
  for (int round = 0; round < tuning::most_shortenings; ++round, share *= 0.25) {
    move(bodies, share, motions.search.direction);
    const double gap = widest_gap(input.joints, motions.problem.joints, {input.bodies, bodies, time});
    if (gap <= std::max(gap_before, tuning::open_gap)) return share;
    for (MovingBody& body : bodies) body.now = body.before;
  }
  return 0;
}

// What was apart as the step began is closed by no velocity, or bodies would fly.
void close_tears(double h, std::vector<MovingBody>& bodies, IslandMotions& motions) {
  find_closing_motion(motions.problem, motions.search, [&](const DirectJoint& joint, std::size_t r) {
    return joint.torn[r] ? std::clamp(joint.gap[r], -h * tuning::closing_speed, h * tuning::closing_speed) : 0;
  });
  if (longest_move(motions.search.direction) <= tuning::far_at_rest) move(bodies, 1, motions.search.direction);
}

}  // namespace

bool note_tears(const Joint* joints, std::vector<DirectJoint>& all) {
  bool any = false;
  for (DirectJoint& joint : all) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const Law& law = law_of(joints[joint.joint], r);
      joint.torn[r] = law.locked() && std::abs(joint.at[r].value - law.lower) > tuning::torn;
      any |= joint.torn[r];
    }
  }
  return any;
}

// By Newton's method: by one step along the rows of the substep's start, or where that is not near, along rows that
// follow. There a taut chain of light links would rather turn them far than move what it pulls on; what holds it
// straight is the stiffness of its tension.
void close_joints(const DirectIslandInput& input, double time, double h, bool torn, std::vector<MovingBody>& bodies,
                  IslandMotions& motions) {
  IslandProblem& problem = motions.problem;
  const IslandPoses poses{input.bodies, bodies, time};
  double most = note_gaps(input.joints, poses, problem.joints);
  bool tightens = follow_tension(problem, h);
  for (int round = 0; round == 0 || (most > tuning::open_gap && round < tuning::most_closing_steps); ++round) {
    if (most > tuning::open_gap || tightens) {
      tightens = false;
      place_joints(input, time, h, bodies, problem);
      if (!motions.search.matrix.factor(problem)) return;
    }
    find_closing_motion(problem, motions.search, sound_gap);
    const double share = move_closer(input, time, most, bodies, motions);
    if (share == 0) break;
    if (!motions.pushes) {
      const std::vector<double>& direction = motions.search.direction;
      for (std::size_t i = 0; i < direction.size(); ++i) motions.lasting[i] += share * direction[i] / h;
    }
    add_closing_impulses(problem, motions.search, sound_gap, share / h);
    follow_tension(problem, h);
    most = note_gaps(input.joints, poses, problem.joints);
  }
  if (torn) close_tears(h, bodies, motions);
}

void settle_joints(const DirectIslandInput& input, std::vector<MovingBody>& bodies, IslandMotions& motions) {
  const IslandPoses poses{input.bodies, bodies, input.dt};
  if (note_gaps(input.joints, poses, motions.problem.joints) <= tuning::settled_gap) return;
  find_closing_motion(motions.problem, motions.search, [](const DirectJoint& joint, std::size_t r) {
    return joint.law[r].locked && !joint.torn[r] ? joint.gap[r] : 0;
  });
  if (longest_move(motions.search.direction) <= tuning::far_at_rest) move(bodies, 1, motions.search.direction);
}

}  // namespace atl::solver
