#pragma once

#include <solver/constraints/joint.h>
#include <solver/constraints/spring_step.h>

#include <algorithm>
#include <cstdint>

namespace atl::solver {

/// kg or kg m^2: how heavy a coordinate is.
struct RowMass {
  double alone = 0;   ///< of the two bodies, if nothing else held them
  double joined = 0;  ///< with all that joints hold to them, or `alone` where nobody has found that
  double share = 1;   ///< the part of it that the coordinate's own springs move, where others act along with them
};

/// A spring and what else is linear along a coordinate: stiffness and damping by mass, with a force beside.
struct LinearForce {
  double square_of_omega = 0;  ///< 1/s^2
  double decay = 0;            ///< 1/s
  double rest = 0;             ///< m or rad
  double beside = 0;           ///< m/s^2 or rad/s^2, at rest

  /// The force of the law's spring at a distance from zero, or of its servo; the mass is in kg or kg m^2, and above 0.
  /// If the coordinate's rate is only a share of the turning about its axis, the frequency and the motor's speed are
  /// those of the turning.
  static LinearForce of_spring(const Law& law, double mass, double share = 1);
  static LinearForce of_servo(const Law& law, double mass, double share = 1);
  void add(const LinearForce& other);
  /// On a part of the mass.
  LinearForce on_share(double share) const { return {square_of_omega / share, decay / share, rest, beside / share}; }
  double fastest() const;  ///< 1/s, of its frequency and its decay
  bool is_overdamped() const { return decay > 0 && decay * decay >= 4 * square_of_omega; }
  /// Tells if steps of h seconds are too long to follow it: see SpringStep::max_phase.
  bool is_stiff(double h) const;
  double at(double position, double rate) const { return beside - square_of_omega * (position - rest) - decay * rate; }
};

/// A spring and a servo together, on a coordinate of such a mass (kg or kg m^2). A servo that gives all the force it
/// has is no spring: it pulls alike wherever the coordinate goes.
LinearForce force_on(const Law& law, const JointRow& at, double mass, bool servo_at_bound);
/// Tells a spring that is too fast for steps of h seconds on a coordinate of such a mass (kg or kg m^2).
bool has_stiff_spring(const Law& law, const JointRow& at, double mass, double h);

/// -1 where a servo would pull backwards by more than it has, 1 forwards, else 0.
int servo_bound(const Law& law, const JointRow& at, double rate);

/// A linear law over one step, as a function of the rate u before it and of the free rate u0: see SpringStep. Any other
/// impulse changes the rate by 1 / (1 + hold) of what it would do without the law.
struct LinearStep {
  double hold = 0;
  double keep = 0;
  double shift = 0;  ///< m/s or rad/s, to be added

  /// The step of a spring, with the inertia that the law adds to `mass`, which is that of the coordinate without it.
  /// The spring's frequency is that with `alone`, the mass along the row if nothing else holds the bodies. `max_closed`
  /// as SpringStep has it.
  static LinearStep of_spring(const Law& law, const JointRow& at, double mass, double alone, double h,
                              double max_closed = SpringStep::unlimited, double mass_share = 1);
  /// The step of a servo, without that inertia: a servo goes with a spring, or with none.
  static LinearStep of_servo(const Law& law, const JointRow& at, double mass, double h,
                             double max_closed = SpringStep::unlimited, double mass_share = 1);
};

/// A Law over a time step: the impulse along a coordinate as a function of the rate that it ends with. It falls as the
/// rate rises, piece by piece linear: what locks and stops is at least very slightly soft, the rest is as it is said to
/// be.
struct RowLaw {
  bool locked = false;
  double stiffness = 0;                 ///< N s by m/s, of what locks and stops
  double lock_rate = 0;                 ///< m/s or rad/s, at which a lock has no impulse
  double lower_rate = -Law::unlimited;  ///< at which the ends of the range are reached
  double upper_rate = Law::unlimited;
  double motor_speed = 0, motor_impulse = 0;        ///< at which it does nothing, and the most that it has; 0 without
  double motor_slope = 0;                           ///< of impulse by rate; else it is as stiff as a lock
  double motor_keeps = 0;                           ///< see spring_keeps
  double friction_speed = 0, friction_impulse = 0;  ///< at which it does nothing, and the most that it has
  double friction_slope = 0;                        ///< of impulse by rate; else it is as stiff as a lock
  double spring_slope = 0, spring_rate = 0;  ///< of impulse by rate, and the rate at which there is none; 0 without
  double spring_keeps = 0;                   ///< how the rate before the step adds to that

  /// h in s; what locks gives by `compliance` over the mass, or is left to the caller where that is 0. At rest before
  /// the step. What is damped more than it swings goes with all that is joined: the exact decay of less would hold it
  /// back by more than it does; and so does what would be too fast for the step without, which would be damped for
  /// nothing. What swings else goes with the least mass that it can have, or it might ring up. Springs and
  /// servos close at most `max_closed` of the distance from where they rest: see SpringStep.
  static RowLaw of(const Law& law, const JointRow& at, const RowMass& mass, double h, double compliance = 0,
                   double max_closed = SpringStep::unlimited);
  /// The same at a rate before the step's forces, once.
  void start_at(double rate) {
    spring_rate += spring_keeps * rate;
    motor_speed += motor_keeps * rate;
  }

  /// Adds to the rate before the step, but only as dampers see it: what turns with an armature of its own keeps that.
  void damp_by(double rate, double armature) {
    if (spring_slope > 0) spring_rate += (spring_keeps - armature / spring_slope) * rate;
    motor_speed += motor_keeps * rate;
  }

  /// The law over a kick: half a step in which velocities change and positions stay, by which a leapfrog's rates come
  /// level with its positions (`sign` 1) or fall behind them (-1, its exact inverse). `rate` before the kick's forces,
  /// and `end_rate` after them at an end of the range, which `limit` tells; `limit` and `motor_bound` as Joint has
  /// them. A stiff spring's coordinate keeps its rate: the forces on it are in balance over a step, or steps don't see
  /// what they do.
  static RowLaw of_kick(const Law& law, const JointRow& at, const RowMass& mass, double h, int sign, double rate,
                        double end_rate, int limit, int motor_bound);

  /// Gives a motor, and dry friction, the softness of contacts' friction, more than that of ends of ranges.
  void soften_motor(double effective_mass);
  void soften_friction(double effective_mass);

  double impulse(double rate) const;
  /// The rate that this brings a coordinate to from a rate without, where an impulse changes it by `response` times
  /// that.
  double rate_from(double free, double response) const;
  double motor_impulse_at(double rate) const;
  double friction_at(double rate) const;
  /// Impulse by rate, not negative.
  double slope(double rate) const;
  /// A bit for each piece that the rate is on: the same pieces have the same slope.
  std::uint8_t pieces(double rate) const;
  /// True if the position is held: locked, or at an end of the range.
  bool holds(double rate) const { return locked || rate < lower_rate || rate > upper_rate; }
  int limit(double rate) const { return locked ? 0 : rate < lower_rate ? -1 : rate > upper_rate ? 1 : 0; }
  /// -1 where the motor pulls backwards with all it has, 1 forwards, else 0; likewise friction.
  int motor_bound(double rate) const;
  int friction_bound(double rate) const;
  /// The bound (-1 or 1) that a force of at most `max` is at if `wanted` is asked of it, else 0.
  static int bound_at(double wanted, double max) { return wanted > max ? 1 : wanted < -max ? -1 : 0; }

 private:
  double drive() const { return motor_slope > 0 ? motor_slope : stiffness; }
  double friction_drive() const { return friction_slope > 0 ? friction_slope : stiffness; }
};

inline double RowLaw::friction_at(double rate) const {
  return friction_impulse > 0
             ? std::clamp(-friction_drive() * (rate - friction_speed), -friction_impulse, friction_impulse)
             : 0;
}

inline double RowLaw::motor_impulse_at(double rate) const {
  return motor_impulse > 0 ? std::clamp(-drive() * (rate - motor_speed), -motor_impulse, motor_impulse) : 0;
}

inline double RowLaw::impulse(double rate) const {
  if (locked) return -stiffness * (rate - lock_rate);
  double sum = -spring_slope * (rate - spring_rate);
  if (rate < lower_rate) sum += stiffness * (lower_rate - rate);
  if (rate > upper_rate) sum -= stiffness * (rate - upper_rate);
  return sum + motor_impulse_at(rate) + friction_at(rate);
}

inline int RowLaw::motor_bound(double rate) const {
  return motor_impulse > 0 ? bound_at(-drive() * (rate - motor_speed), motor_impulse) : 0;
}

inline int RowLaw::friction_bound(double rate) const {
  return friction_impulse > 0 ? bound_at(-friction_drive() * (rate - friction_speed), friction_impulse) : 0;
}

inline double RowLaw::slope(double rate) const {
  if (locked) return stiffness;
  double sum = spring_slope;
  if (limit(rate) != 0) sum += stiffness;
  if (motor_impulse > 0 && motor_bound(rate) == 0) sum += drive();
  if (friction_impulse > 0 && friction_bound(rate) == 0) sum += friction_drive();
  return sum;
}

inline std::uint8_t RowLaw::pieces(double rate) const {
  if (locked) return 0;
  const bool moves = motor_impulse > 0 && motor_bound(rate) == 0;
  const bool sticks = friction_impulse > 0 && friction_bound(rate) == 0;
  return static_cast<std::uint8_t>((limit(rate) != 0 ? 1 : 0) | (moves ? 2 : 0) | (sticks ? 4 : 0));
}

/// N s or N m s: by how much the impulse of a damped spring or servo over half a step of h seconds is more than that of
/// a force which stays what it is at the step's whole end: h^2 / 6 of the force's rate of change, at the coordinate's
/// rate and acceleration there. None of a spring with less damping than that, for which the leapfrog has to be
/// reversible.
double kick_correction(const Law& law, const JointRow& at, const RowMass& mass, double h, double rate,
                       double acceleration);

/// 1/s^2: by how much the acceleration along a coordinate of such a mass (kg or kg m^2) falls by its way, with a spring
/// or servo of its own alone.
double fall_by_own_spring(const Law& law, const JointRow& at, double mass, bool servo_at_bound, double h);

/// The bounce of a coordinate at an end of its range within a step.
struct LimitImpact {
  int end = 0;              ///< -1 the lower, 1 the upper; 0 if there is none
  bool rests = false;       ///< at an end, from which it doesn't come back
  double falls = 0;         ///< 1/s^2, of the acceleration by the way, where springs make it
  double leaving = 0;       ///< m/s or rad/s, the rate after it, where the position is now
  double leaving_late = 0;  ///< the same half a step behind the position, where substeps have rates

  /// Finds the bounce from `position` at a `rate` that would be `free_rate` after h seconds if nothing held it, both
  /// half a step behind positions; by Newton's law of restitution. Springs make the acceleration fall along the way, by
  /// `falls` (1/s^2). A bounce that would be over within the step counts as rest.
  static LimitImpact of(const Law& law, double position, double falls, double rate, double free_rate, double h);
};

}  // namespace atl::solver
