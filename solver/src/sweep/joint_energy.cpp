#include <jobs/assert.h>
#include <solver/sweep/joint_energy.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "integrate/matrix3.h"
#include "integrate/rows3.h"

namespace atl::solver {

void JointEnergy::find_forced(const JointStep& step, const GroupJoints& joints, const GroupTendons& tendons) {
  forced_.clear();
  if (!joints.has_forces() && !tendons.has_forces(step)) return;
  const SolverBodies& bodies = step.bodies;
  forced_.assign(bodies.padded_count(), {});
  const auto add = [&](std::int32_t body, const Vector3& impulse, const Vector3& angular_impulse) {
    const auto local = static_cast<std::size_t>(body);
    add3(forced_[local].linear, inverse_mass_of(bodies, local).cwiseProduct(impulse));
    add3(forced_[local].angular, product(inverse_inertia_of(bodies, local), angular_impulse));
  };
  joints.each_force(step, add);
  tendons.each_force(step, add);
}

// The root of linear s + square s^2 = allowed, by the form without a difference of what may be alike.
double JointEnergy::Change::greatest_scale() const {
  const double root = std::sqrt(linear * linear + 4 * square * allowed);
  return std::clamp(linear > 0 ? 2 * allowed / (linear + root) : (root - linear) / (2 * square), 0.0, 1.0);
}

bool JointEnergy::find_scales(const JoinedMotion& motion, std::uint32_t first_dynamic, double speed) {
  components_.assign(motion.component_count(), {});
  for (std::size_t i = 0; i < motion.body_count(); ++i) {
    if (!motion.is_joined(i)) continue;
    const WorkRow& work = work_[first_dynamic + i];
    Change& change = components_[motion.component_of(i)];
    change.before += work.before;
    change.linear += work.linear;
    change.square += work.square;
    change.allowed += work.half_mass * speed * speed;
  }
  bool any = false;
  for (std::size_t c = 0; c < components_.size(); ++c) {
    Change& change = components_[c];
    if (!motion.is_closed(c)) continue;
    ATL_ASSERT(!(change.before < 0) && !(change.square < 0), c, change.before, change.square);
    const double tolerance = tuning::energy_tolerance * change.before;
    if (!(change.linear + change.square > tolerance + change.allowed)) continue;
    change.scale = static_cast<float>(change.greatest_scale());
    any = true;
  }
  return any;
}

void JointEnergy::scale(const JoinedMotion& motion, std::uint32_t first_dynamic, SolverBodies& bodies) const {
  for (std::size_t i = 0; i < motion.body_count(); ++i) {
    const double scale = scale_of(motion, i);
    if (scale == 1) continue;
    const std::size_t local = first_dynamic + i;
    Vector3 velocity = get3(bodies.free_velocity[local].linear), spin = get3(bodies.free_velocity[local].angular);
    if (!forced_.empty()) {
      velocity += get3(forced_[local].linear);
      spin += get3(forced_[local].angular);
    }
    VelocityRows& now = bodies.velocity[local];
    set3(now.linear, velocity + scale * (get3(now.linear) - velocity));
    set3(now.angular, spin + scale * (get3(now.angular) - spin));
  }
}

void JointEnergy::bound(const JoinedMotion& motion, const JointStep& step, const Kernels& kernels,
                        std::uint32_t first_dynamic, double speed, SolverBodies& bodies, GroupJoints& joints,
                        GroupTendons& tendons) {
  if (!motion.has_closed()) return;
  find_forced(step, joints, tendons);
  work_.resize(bodies.padded_count());
  kernels.find_work(bodies, forced_.empty() ? nullptr : forced_.data(), work_.data(), 0, bodies.padded_count());
  if (!find_scales(motion, first_dynamic, speed)) return;
  scale(motion, first_dynamic, bodies);
  const auto scale_at = [&](std::int32_t body) {
    return scale_of(motion, static_cast<std::size_t>(body) - first_dynamic);
  };
  joints.scale_held(step, scale_at);
  tendons.scale_held(step, scale_at);
}

}  // namespace atl::solver
