#include <solver/constraints/row_law.h>
#include <solver/constraints/spring_step.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {

RowLaw RowLaw::of(const Law& law, double position, double effective_mass, double h, double compliance) {
  RowLaw row;
  row.stiffness = compliance > 0 ? effective_mass / compliance : 0;
  row.locked = law.locked();
  if (row.locked) return row;
  // An infinite end stays infinite.
  row.lower_rate = std::min((law.lower - position) / h, tuning::closing_speed);
  row.upper_rate = std::max((law.upper - position) / h, -tuning::closing_speed);
  row.motor_speed = law.motor_speed;
  row.motor_impulse = h * law.motor_force;
  if (law.springs() && effective_mass > 0) {
    constexpr double least = 1e-12;  // of what rounding leaves of a very soft one
    const SpringStep spring =
        SpringStep::of(std::sqrt(law.square_of_omega(effective_mass)), law.decay(effective_mass), h);
    const double hold = std::max(spring.hold, least);
    row.spring_slope = effective_mass * hold;
    row.spring_rate = -spring.pull * (position - law.rest) / hold;
    row.spring_keeps = spring.keep / hold;
  }
  return row;
}

double RowLaw::impulse(double rate) const {
  if (locked) return -stiffness * (rate - lock_rate);
  double sum = -spring_slope * (rate - spring_rate);
  if (rate < lower_rate) sum += stiffness * (lower_rate - rate);
  if (rate > upper_rate) sum -= stiffness * (rate - upper_rate);
  if (motor_impulse > 0) sum += std::clamp(-stiffness * (rate - motor_speed), -motor_impulse, motor_impulse);
  return sum;
}

int RowLaw::motor_bound(double rate) const {
  if (!(motor_impulse > 0)) return 0;
  const double wanted = -stiffness * (rate - motor_speed);
  return wanted > motor_impulse ? 1 : wanted < -motor_impulse ? -1 : 0;
}

double RowLaw::slope(double rate) const {
  if (locked) return stiffness;
  double sum = spring_slope;
  if (limit(rate) != 0) sum += stiffness;
  if (motor_impulse > 0 && motor_bound(rate) == 0) sum += stiffness;
  return sum;
}

std::uint8_t RowLaw::pieces(double rate) const {
  if (locked) return 0;
  const bool moves = motor_impulse > 0 && motor_bound(rate) == 0;
  return static_cast<std::uint8_t>((limit(rate) != 0 ? 1 : 0) | (moves ? 2 : 0));
}

}  // namespace atl::solver
