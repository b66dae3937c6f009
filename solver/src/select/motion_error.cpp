#include <jobs/assert.h>
#include <solver/select/motion_error.h>
#include <solver/tuning.h>

#include <cmath>

namespace atl::solver {
namespace {

// m/s.
MotionError::Acceleration velocity_of(const BodyTable& bodies, std::uint32_t body) {
  MotionError::Acceleration velocity;
  for (int i = 0; i < 3; ++i) {
    velocity[i] = static_cast<float>(bodies.velocity(body)[i]);
    velocity[i + 3] = static_cast<float>(bodies.radius[body] * bodies.angular_velocity(body)[i]);
  }
  return velocity;
}

}  // namespace

void MotionError::forget_all() {
  acceleration_.clear();
  before_.clear();
}

void MotionError::forget(std::uint32_t body) {
  if (body < acceleration_.size()) acceleration_[body] = unknown;
}

void MotionError::begin(const BodyTable& bodies, std::span<const std::uint32_t> of) {
  acceleration_.resize(bodies.size(), unknown);
  before_.resize(bodies.size());
  for (const std::uint32_t body : of) before_[body] = velocity_of(bodies, body);
}

double MotionError::end(const BodyTable& bodies, std::uint32_t body, double dt, double substep) {
  ATL_ASSERT(body < before_.size() && before_.size() <= acceleration_.size(), body, before_.size(),
             acceleration_.size());
  ATL_ASSERT(dt > 0 && substep > 0, dt, substep);
  const Acceleration velocity = velocity_of(bodies, body);
  Acceleration& last = acceleration_[body];
  const bool first = last == unknown;
  double linear = 0, angular = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    const auto now = static_cast<float>((velocity[i] - before_[body][i]) / dt);
    const double change = now - last[i];
    (i < 3 ? linear : angular) += change * change;
    last[i] = now;
  }
  const double change = (std::sqrt(linear) + std::sqrt(angular)) / dt;
  const double error = tuning::motion_error_share * substep * substep * change;
  return first || !std::isfinite(error) ? 0 : error;
}

void MotionError::restore(std::uint32_t body, std::size_t bodies, const Acceleration& acceleration) {
  acceleration_.resize(bodies, unknown);
  acceleration_[body] = acceleration;
}

}  // namespace atl::solver
