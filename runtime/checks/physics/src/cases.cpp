#include "cases.h"

#include <algorithm>
#include <chrono>

namespace atl::physics {

const std::vector<PhysicsCase>& physics_cases() {
  static const std::vector<PhysicsCase> all = [] {
    std::vector<PhysicsCase> cases;
    for (const auto add : {add_sliding, add_impacts, add_rolling, add_bowls, add_spins, add_springs, add_mechanisms,
                           add_pendulums, add_energies, add_statics, add_granular, add_invariances}) {
      add(cases);
    }
    return cases;
  }();
  return all;
}

bool grows(std::span<const PhysicsResult> runs) {
  constexpr double rounding = 1e-6;
  return !(runs.back().error <= std::max(1.05 * runs.front().error, rounding));
}

bool expected(const PhysicsCase& test, std::span<const PhysicsResult> runs) {
  if (!runs.front().expected(test)) return false;
  return runs.size() == 1 || grows(runs) != test.known_growth.empty();
}

PhysicsResult run_case(const PhysicsCase& test, double dt) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  PhysicsResult result;
  result.value = test.measure({.dt = dt > 0 ? dt : test.dt});
  result.error = std::abs(result.value - test.right) / test.scale;
  result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return result;
}

World make_world(const Resolution& at, double gravity, Settings settings) {
  settings.substeps = at.substeps;
  return World({.gravity = {0, 0, -gravity}, .settings = settings});
}

void run(World& world, const Resolution& at, double seconds) {
  run(world, at, seconds, [](double) {});
}

BodyId add_ground(World& world, const Material& material) {
  return world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .material = material});
}

Matrix3 world_inertia(const World& world, BodyId id, const Matrix3& own) {
  const Matrix3 turn = world.pose(id).orientation.toRotationMatrix();
  return turn * own * turn.transpose();
}

double kinetic_energy(const World& world, BodyId id, const Matrix3& own_inertia) {
  const Vector3 spin = world.angular_velocity(id);
  return 0.5 * world.mass(id) * world.velocity(id).squaredNorm() +
         0.5 * spin.dot(world_inertia(world, id, own_inertia) * spin);
}

Quaternion turn_about(const Vector3& axis, double angle) {
  return Quaternion(Eigen::AngleAxisd(angle, axis.normalized()));
}

}  // namespace atl::physics
