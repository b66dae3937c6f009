#include <jobs/assert.h>
#include <solver/constraints/row_law.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace atl::solver {
namespace {

constexpr double unlimited_rate = 1e30;  // m/s or rad/s
constexpr double min_hold = 1e-12;       // of what rounding leaves of a very soft spring

// kg or kg m^2, that a spring or servo goes with: see RowLaw::of(). `force_of(mass)` is its force.
template <typename ForceOf>
double mass_for(const ForceOf& force_of, const RowMass& mass, double h) {
  const LinearForce alone = force_of(mass.alone).on_share(mass.share);
  return force_of(mass.joined).is_overdamped() || alone.is_stiff(h) ? mass.joined : mass.alone;
}

// Tells if a rate, in m/s or rad/s, isn't the one at which a motor or dry friction holds a coordinate.
bool is_behind(double behind, double rate) { return std::abs(behind) > tuning::motor_behind * (1 + std::abs(rate)); }

}  // namespace

LinearForce force_on(const Law& law, const JointRow& at, double mass, bool servo_at_bound) {
  LinearForce both;
  if (!(mass > 0)) return both;
  const double moved = mass + law.armature;
  if (law.springs()) both = LinearForce::of_spring(law, moved, at.share);
  if (law.is_servo() && !servo_at_bound) both.add(LinearForce::of_servo(law, moved, at.share));
  return both;
}

int servo_bound(const Law& law, const JointRow& at, double rate) {
  const double asked = LinearForce::of_servo(law, 1, at.share).at(at.value, rate);
  return RowLaw::bound_at(asked, law.motor_force);
}

LinearForce LinearForce::of_spring(const Law& law, double mass, double share) {
  ATL_ASSERT(mass > 0, mass);
  const double omega = 2 * std::numbers::pi * law.spring_hertz;
  const double part = std::min(1.0, share * share);
  return {.square_of_omega = part * omega * omega + law.stiffness / mass,
          .decay = 2 * part * omega * law.damping_ratio + law.damping / mass,
          .rest = law.rest};
}

LinearForce LinearForce::of_servo(const Law& law, double mass, double share) {
  ATL_ASSERT(mass > 0, mass);
  return {.square_of_omega = law.servo_stiffness / mass,
          .decay = law.servo_damping / mass,
          .rest = law.servo_target,
          .beside = law.servo_damping * share * law.motor_speed / mass};
}

void LinearForce::add(const LinearForce& other) {
  const double both = square_of_omega + other.square_of_omega;
  if (both > 0) rest = (square_of_omega * rest + other.square_of_omega * other.rest) / both;
  square_of_omega = both;
  decay += other.decay;
  beside += other.beside;
}

double LinearForce::fastest() const { return std::max(std::sqrt(square_of_omega), decay); }

bool LinearForce::is_stiff(double h) const { return fastest() * h > SpringStep::max_phase; }

bool has_stiff_spring(const Law& law, const JointRow& at, double mass, double h) {
  return law.springs() && mass > 0 && LinearForce::of_spring(law, mass + law.armature, at.share).is_stiff(h);
}

LinearStep LinearStep::of_spring(const Law& law, const JointRow& at, double mass, double alone, double h,
                                 double max_closed, double mass_share) {
  const double moved = mass + law.armature, stiffened = (alone + law.armature) / moved;
  LinearForce force = LinearForce::of_spring(law, alone + law.armature, at.share);
  force.square_of_omega *= stiffened / mass_share;
  force.decay *= stiffened / mass_share;
  const SpringStep step = SpringStep::of(std::sqrt(force.square_of_omega), force.decay, h, max_closed);
  const double pull = step.pull * (at.value - law.rest);
  if (law.armature == 0) return {mass_share * step.hold, mass_share * step.keep, -mass_share * pull};
  const double own = law.armature / mass, share = mass_share * (moved / mass);
  return {own + share * step.hold, own + share * step.keep, -share * pull};
}

LinearStep LinearStep::of_servo(const Law& law, const JointRow& at, double mass, double h, double max_closed,
                                double mass_share) {
  const double moved = mass + law.armature, share = mass_share * (moved / mass);
  const LinearForce force = LinearForce::of_servo(law, moved, at.share).on_share(mass_share);
  const SpringStep step = SpringStep::of(std::sqrt(force.square_of_omega), force.decay, h, max_closed);
  return {share * step.hold, share * step.keep, share * (h * force.beside - step.pull * (at.value - force.rest))};
}

RowLaw RowLaw::of(const Law& law, const JointRow& at, const RowMass& mass, double h, double compliance,
                  double max_closed) {
  ATL_ASSERT(h > 0, h);
  ATL_ASSERT(!(compliance < 0), compliance);
  const double effective_mass = mass.alone;
  RowLaw row;
  row.stiffness = compliance > 0 ? effective_mass / compliance : 0;
  row.locked = law.locked();
  if (row.locked) return row;
  // An infinite end stays infinite.
  row.lower_rate = std::min((law.lower - at.value) / h, tuning::closing_speed);
  row.upper_rate = std::max((law.upper - at.value) / h, -tuning::closing_speed);
  row.motor_speed = at.share * law.motor_speed;
  row.motor_impulse = h * law.motor_force;
  row.friction_impulse = h * law.friction;
  ATL_ASSERT(!(row.motor_impulse < 0) && !(row.friction_impulse < 0), row.motor_impulse, row.friction_impulse);
  if (compliance > 0) {
    row.soften_motor(effective_mass);
    row.soften_friction(effective_mass);
  }
  if (!(effective_mass > 0)) return row;
  if (law.springs() || law.armature > 0) {
    const auto force_of = [&](double of) { return LinearForce::of_spring(law, of + law.armature, at.share); };
    const double moved = mass_for(force_of, mass, h);
    const LinearStep spring = LinearStep::of_spring(law, at, moved, effective_mass, h, max_closed, mass.share);
    const double hold = std::max(spring.hold, min_hold);
    row.spring_slope = moved * hold;
    row.spring_rate = spring.shift / hold;
    row.spring_keeps = spring.keep / hold;
  }
  if (law.is_servo()) {
    const auto force_of = [&](double of) { return LinearForce::of_servo(law, of + law.armature, at.share); };
    const double moved = mass_for(force_of, mass, h);
    const LinearStep servo = LinearStep::of_servo(law, at, moved, h, max_closed, mass.share);
    const double hold = std::max(servo.hold, min_hold);
    row.motor_slope = moved * hold;
    row.motor_speed = servo.shift / hold;
    row.motor_keeps = servo.keep / hold;
  }
  return row;
}

RowLaw RowLaw::of_kick(const Law& law, const JointRow& at, const RowMass& mass, double h, int sign, double rate,
                       double end_rate, int limit, int motor_bound) {
  const bool saturated = motor_bound != 0;
  const auto force_of = [&](double of) { return force_on(law, at, of, saturated); };
  const double effective_mass = mass_for(force_of, mass, h);
  RowLaw row;
  row.locked = law.locked();
  if (row.locked) return row;
  if (limit < 0) row.lower_rate = end_rate;
  if (limit > 0) row.upper_rate = end_rate;
  const double time = 0.5 * h;
  const double moved = effective_mass + law.armature;
  const bool turns = effective_mass > 0;
  const LinearForce spring = turns && law.springs() ? LinearForce::of_spring(law, moved, at.share) : LinearForce{};
  const LinearForce servo = turns && law.is_servo() ? LinearForce::of_servo(law, moved, at.share) : LinearForce{};
  // The impulse is `given`, less the slope times the rate after the kick.
  double given = law.armature * rate, slope = law.armature;
  const auto add = [&](const LinearForce& force) {
    given += sign * time * moved * force.at(at.value, sign < 0 ? rate : 0);
    if (sign > 0) slope += time * moved * force.decay;
  };
  row.motor_impulse = time * law.motor_force;
  row.motor_speed = at.share * law.motor_speed;
  // A motor that is not at its speed has been pulling with all it has.
  if (sign < 0 && !law.is_servo()) {
    const double behind = row.motor_speed - rate;
    const bool pulls = law.motor_force < Law::unlimited && is_behind(behind, rate);
    if (pulls) motor_bound = behind > 0 ? 1 : -1;
    row.motor_speed = rate;
  }
  // Whatever a motor gives beside: taken back in one kick alone, its force would come short in every step.
  const auto is_stiff = [&](bool servo_at_bound) {
    return force_on(law, at, effective_mass, servo_at_bound).on_share(mass.share).is_stiff(h);
  };
  const bool stiff = is_stiff(saturated);
  if (stiff) {
    row.motor_speed = rate;
    if (law.springs()) row.motor_impulse = Law::unlimited;
  } else if (law.is_servo() && is_stiff(false)) {  // or it gave more than it has where it comes to its bound
    row.motor_impulse = 0;
  } else if (law.drives() && sign < 0 && motor_bound != 0) {
    given -= motor_bound * row.motor_impulse;
    row.motor_impulse = 0;
  } else if (law.is_servo() && sign < 0) {
    given -= std::clamp(time * moved * servo.at(at.value, rate), -row.motor_impulse, row.motor_impulse);
    row.motor_impulse = 0;
  } else if (law.is_servo() && turns) {
    row.motor_slope = std::max(time * moved * servo.decay, min_hold * effective_mass);
    row.motor_speed = time * moved * servo.at(at.value, 0) / row.motor_slope;
  }
  if (!stiff) {
    add(spring);
    row.friction_impulse = time * law.friction;
    // A coordinate that sticks does so before the kick as well. One that slides was held back with all there is.
    if (sign < 0) row.friction_speed = rate;
    if (sign < 0 && is_behind(rate, rate)) given += std::copysign(std::exchange(row.friction_impulse, 0), rate);
  }
  const double held = std::max(slope, min_hold * effective_mass);
  if ((given == 0 && slope == 0) || held == 0) return row;  // or it would move nothing
  row.spring_slope = held;
  row.spring_rate = given / row.spring_slope;
  return row;
}

double kick_correction(const Law& law, const JointRow& at, const RowMass& mass, double h, double rate,
                       double acceleration) {
  const bool saturated = law.is_servo() && servo_bound(law, at, rate) != 0;
  const auto force_of = [&](double of) { return force_on(law, at, of, saturated); };
  const double effective_mass = mass_for(force_of, mass, h);
  const double moved = effective_mass + law.armature;
  if (!(effective_mass > 0)) return 0;
  const LinearForce force = force_of(effective_mass);
  const double by_rate = h * h / 6 * force.square_of_omega, by_acceleration = h * h / 6 * force.decay;
  if (force.on_share(mass.share).is_stiff(h) || by_rate > 0.5 * h * force.decay) return 0;
  ATL_ASSERT(!(by_rate < 0) && !(by_acceleration < 0), by_rate, by_acceleration);
  return moved * (by_rate * rate + by_acceleration * acceleration);
}

void RowLaw::soften_motor(double effective_mass) {
  if (motor_impulse > 0 && motor_slope == 0) motor_slope = effective_mass / tuning::friction_compliance;
}

void RowLaw::soften_friction(double effective_mass) {
  if (friction_impulse > 0) friction_slope = effective_mass / tuning::friction_compliance;
}

// Newton's method, with steps kept between rates that are known to be too low and too high. It ends soon, since the law
// is piecewise linear with few pieces.
double RowLaw::rate_from(double free, double response) const {
  ATL_ASSERT(!(response < 0), response);
  constexpr int max_rounds = 60;
  double low = -unlimited_rate, high = unlimited_rate, rate = free;
  for (int round = 0; round < max_rounds; ++round) {
    const double above = rate - free - response * impulse(rate);
    (above > 0 ? high : low) = rate;
    const double next = rate - above / (1 + response * slope(rate));
    if (next == rate) break;
    rate = next > low && next < high ? next : 0.5 * (low + high);
  }
  return rate;
}

double fall_by_own_spring(const Law& law, const JointRow& at, double mass, bool servo_at_bound, double h) {
  ATL_ASSERT(h > 0, h);
  const LinearForce force = force_on(law, at, mass, servo_at_bound);
  const SpringStep spring = SpringStep::of(std::sqrt(force.square_of_omega), force.decay, h);
  return spring.pull / ((1 + spring.hold) * h);
}

LimitImpact LimitImpact::of(const Law& law, double position, double falls, double rate, double free_rate, double h) {
  ATL_ASSERT(h > 0, h);
  ATL_ASSERT(!(law.lower > law.upper), law.lower, law.upper);
  const double there = position + h * free_rate;
  const int end = there < law.lower ? -1 : there > law.upper ? 1 : 0;
  if (end == 0) return {};
  // Seen from the end that it hits, the coordinate has room > 0 left and comes at a speed > 0.
  const double room = std::max(end < 0 ? position - law.lower : law.upper - position, 0.0);
  const double at_start = end * (free_rate - rate) / h;
  const double acceleration = at_start - falls * room;  // at the end of the range
  const double start = end * rate + 0.5 * h * at_start;
  const double square = start * start + (1 - 0.25 * h * h * falls) * (at_start + acceleration) * room;
  const double speed = start > 0 && square > 0 ? law.restitution * std::sqrt(square) : 0;
  if (!(speed > h * acceleration)) return {.rests = true};
  return {.end = end, .leaving = -end * speed, .leaving_late = -end * (speed + 0.5 * h * acceleration)};
}

}  // namespace atl::solver
