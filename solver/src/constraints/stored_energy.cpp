#include <solver/constraints/stored_energy.h>
#include <solver/constraints/tendon.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace atl::solver {
namespace {

// J: the potential of a spring at `off` from its rest (m or rad), which was `moved` less far a substep ago: see
// StoredEnergy::of().
double potential_of(double stiffness, double off, double moved) { return 0.5 * stiffness * off * (off - moved); }

double potential_of(const Law& law, double value, double moved) {
  double sum = 0;
  if (law.stiffness > 0) sum += potential_of(law.stiffness, value - law.rest, moved);
  if (law.is_servo() && law.servo_stiffness > 0) {
    const double off = value - law.servo_target, force = law.servo_stiffness * std::abs(off);
    if (force <= law.motor_force) return sum + potential_of(law.servo_stiffness, off, moved);
    const double between = law.servo_stiffness * std::abs(off - 0.5 * moved);
    const double bounded = std::min(between, law.motor_force);
    sum += bounded * (between - 0.5 * bounded) / law.servo_stiffness;
  }
  return sum;
}

bool stores(const Law& law) {
  return !law.locked() && (law.stiffness > 0 || (law.is_servo() && law.servo_stiffness > 0) || law.armature > 0);
}

}  // namespace

void StoredEnergy::add(const Law& law, double value, double rate, double lag) {
  if (law.locked() || !law.acts_as_force()) return;
  springs |= law.stiffness > 0 || (law.is_servo() && law.servo_stiffness > 0);
  potential += potential_of(law, value, lag * rate);
  rotors += 0.5 * law.armature * rate * rate;
}

StoredEnergy StoredEnergy::of(std::uint32_t index, const Joint* joints, const BodyTable& bodies, double lag) {
  StoredEnergy stored;
  const Joint& joint = joints[index];
  if (!stores_energy(joint)) return stored;
  if (joint.is_tendon()) {
    const TendonNow now = tendon_now(joint, joints, bodies);
    stored.add(joint.law[0], now.length, now.rate, lag);
    return stored;
  }
  const JointFrames frames = joint_frames(joint, bodies);
  for (std::size_t k = 0; k < joint.rows; ++k) {
    const JointRow at = law_row(joint, k, frames, joint.position[k]).at;
    stored.add(joint.law[k], at.value,
               at.rate(bodies.velocity(joint.first), bodies.angular_velocity(joint.first),
                       bodies.velocity(joint.second), bodies.angular_velocity(joint.second)),
               lag);
  }
  return stored;
}

bool stores_energy(const Joint& joint) {
  return std::any_of(joint.law.begin(), joint.law.begin() + joint.rows, stores);
}

double max_energy_given(const Joint& joint, double dt) {
  double sum = 0;
  for (const Law& law : std::span(joint.law).first(joint.rows)) {
    if (law.locked()) continue;
    if (law.spring_hertz != 0) return std::numeric_limits<double>::infinity();
    if (law.drives() && law.motor_speed != 0) sum += law.motor_force * std::abs(law.motor_speed) * dt;
  }
  return sum;
}

bool gives_back(const Joint& joint) {
  return std::any_of(joint.law.begin(), joint.law.begin() + joint.rows, [](const Law& law) {
    return !law.locked() && (law.springs() || law.is_servo() || law.restitution > 0);
  });
}

}  // namespace atl::solver
