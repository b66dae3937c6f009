#include <jobs/assert.h>

#include <string>

#include "step/results.h"
#include "world/bodies.h"
#include "world/refuse.h"

namespace atl {
namespace {

void change_by_time(const jobs::CompactArray<double>& now, double dt, std::vector<double>& before) {
  ATL_ASSERT(before.empty() || before.size() == now.size(), before.size(), now.size());
  for (std::size_t i = 0; i < before.size(); ++i) before[i] = (now[i] - before[i]) / dt;
}

}  // namespace

void begin_accelerations(Stores& world) {
  Accelerations& of = world.results.accelerations;
  of.linear.clear();
  of.angular.clear();
  if (!world.settings.accelerations) return;
  of.linear.assign(world.bodies.velocities.begin(), world.bodies.velocities.end());
  of.angular.assign(world.bodies.angular_velocities.begin(), world.bodies.angular_velocities.end());
}

void end_accelerations(Stores& world, double dt) {
  change_by_time(world.bodies.velocities, dt, world.results.accelerations.linear);
  change_by_time(world.bodies.angular_velocities, dt, world.results.accelerations.angular);
}

Eigen::Map<const Eigen::Matrix3Xd> accelerations(const Stores& world, bool angular, const char* call) {
  const Accelerations& of = world.results.accelerations;
  if (!world.settings.accelerations || of.linear.size() != world.bodies.velocities.size()) {
    throw Error(std::string("World::") + call +
                ": found no step with Settings::accelerations to tell of; expected one since it was set, or the world "
                "was restored");
  }
  return {(angular ? of.angular : of.linear).data(), 3, static_cast<Eigen::Index>(of.linear.size() / 3)};
}

Vector3 proper_acceleration(const Stores& world, std::uint32_t body, const Vector3& point) {
  check_finite("World::proper_acceleration: point", point);
  const auto of_body = [&](bool angular) { return accelerations(world, angular, "proper_acceleration").col(body); };
  const solver::BodyTable& bodies = world.bodies;
  const Quaternion orientation = bodies.orientation(body);
  const Vector3 arm = orientation * (point - world.records.centre[body]);
  const Vector3 spin = bodies.angular_velocity(body);
  const Vector3 acceleration = of_body(false) + of_body(true).cross(arm) + spin.cross(spin.cross(arm)) -
                               bodies.gravity_scale[body] * world.gravity;
  return orientation.conjugate() * acceleration;
}

}  // namespace atl
