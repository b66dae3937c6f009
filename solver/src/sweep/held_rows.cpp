#include "sweep/held_rows.h"

#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "integrate/matrix3.h"

namespace atl::solver {
namespace {

// A coordinate that is free, well within its range: it has no impulse in this substep, or a little of it.
bool is_idle(const Law& law, double value) {
  return !law.locked() && !law.drives() && !law.springs() && law.armature == 0 &&
         std::min(value - law.lower, law.upper - value) > tuning::most_closed;
}

}  // namespace

HeldRows::HeldRows(const Joint& joint, const JointFrames& frames, const JointBodies& bodies)
    : joint_(joint), bodies_(bodies) {
  for (std::size_t r = 0; r < joint.rows; ++r) {
    rows_[r] = law_row(joint, r, frames, joint.position[r]);
    turned_[r] = turned_by(rows_[r].at);
    free_response_[r] = turned_[r].response;
  }
  if (joint.point) hold_point(frames);
  for (std::size_t held = 0; held < joint.rows; ++held) {
    if (!joint.law[held].locked() || !can_act(held)) continue;
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const bool before = r < held && joint.law[r].locked();
      if (r != held && !before && !is_idle(joint.law[r], rows_[r].at.value)) hold_locked(held, r);
    }
  }
}

bool HeldRows::can_act(std::size_t r) const {
  const double response = turned_[r].response;
  return response > 0 && std::isfinite(response) && std::isfinite(rows_[r].at.value);
}

HeldRows::Turned HeldRows::turned_by(const JointRow& row) const {
  Turned turned{product(bodies_.inertia_first, row.angular_first), product(bodies_.inertia_second, row.angular_second),
                0};
  turned.response = bodies_.inverse_mass * row.linear.squaredNorm() + row.angular_first.dot(turned.first) +
                    row.angular_second.dot(turned.second);
  return turned;
}

void HeldRows::hold_point(const JointFrames& frames) {
  for (std::size_t r = 0; r < joint_.rows; ++r) {
    JointRow& row = rows_[r].at;
    if (is_idle(joint_.law[r], row.value)) continue;
    const Turned& turned = turned_[r];
    const Vector3 rate = bodies_.inverse_mass * row.linear + turned.second.cross(frames.arm_second) +
                         turned.first.cross(frames.arm_first);
    const Vector3 hold = -product(bodies_.point_mass, rate);
    JointRow with = row;
    with.linear += hold;
    with.angular_first += frames.arm_first.cross(hold);
    with.angular_second += frames.arm_second.cross(hold);
    const Turned turned_with = turned_by(with);
    if (!(turned_with.response > tuning::least_held * turned.response)) continue;
    row = with;
    turned_[r] = turned_with;
    if (joint_.law[r].locked()) row.value += hold.dot(frames.offset);
  }
}

void HeldRows::hold_locked(std::size_t held, std::size_t r) {
  const JointRow& by = rows_[held].at;
  const Turned& by_turned = turned_[held];
  JointRow& row = rows_[r].at;
  Turned& turned = turned_[r];
  const double part = (bodies_.inverse_mass * row.linear.dot(by.linear) + row.angular_first.dot(by_turned.first) +
                       row.angular_second.dot(by_turned.second)) /
                      by_turned.response;
  const double left = turned.response - part * part * by_turned.response;
  if (!(left > tuning::least_held * turned.response)) return;
  row.linear -= part * by.linear;
  row.angular_first -= part * by.angular_first;
  row.angular_second -= part * by.angular_second;
  turned.first -= part * by_turned.first;
  turned.second -= part * by_turned.second;
  turned.response = left;
  if (joint_.law[r].locked()) row.value -= part * (by.value - joint_.law[held].lower);
}

}  // namespace atl::solver
