#pragma once

#include <jobs/scratch.h>
#include <solver/body_table.h>

#include <cstdint>
#include <vector>

namespace atl::solver {

struct BodyPose {
  Vector3 position;  ///< m
  Quaternion orientation;
};

/// A body that may have passed through something in this step, and where it started.
struct FastBody {
  std::uint32_t body;
  BodyPose start;
};

/// By worker; only those bodies cost anything. Order them by body before use.
using FastBodies = jobs::Scratch<std::vector<FastBody>>;

/// 2 sin(angle / 2) of the turn between two orientations: how far a point 1 m from the axis gets, in a straight line.
inline double turn_chord(const Quaternion& from, const Quaternion& to) {
  return 2 * (from.conjugate() * to).vec().norm();
}

/// Keeps account of a body that has moved from `start` in a step of dt seconds: whether it may have used up the
/// slack of its bounds by the end of the next one, and whether it was fast.
void note_motion(BodyTable& bodies, std::uint32_t body, const BodyPose& start, double dt, FastBodies& fast);

}  // namespace atl::solver
