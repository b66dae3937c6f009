#pragma once
/// The themes of the suite, a file each, and what they share.

#include <atoll/world.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "../suite.h"

namespace atl::physics {

inline constexpr double g = 9.81;  ///< m/s^2
inline constexpr double pi = std::numbers::pi;

void add_sliding(std::vector<PhysicsCase>& cases);
void add_impacts(std::vector<PhysicsCase>& cases);
void add_rolling(std::vector<PhysicsCase>& cases);
void add_bowls(std::vector<PhysicsCase>& cases);
void add_spins(std::vector<PhysicsCase>& cases);
void add_springs(std::vector<PhysicsCase>& cases);
void add_mechanisms(std::vector<PhysicsCase>& cases);
void add_pendulums(std::vector<PhysicsCase>& cases);
void add_statics(std::vector<PhysicsCase>& cases);
void add_energies(std::vector<PhysicsCase>& cases);
void add_granular(std::vector<PhysicsCase>& cases);
void add_invariances(std::vector<PhysicsCase>& cases);

/// A world at the defaults but for the resolution's substeps.
World make_world(const Resolution& at, double gravity = g, Settings settings = {});
/// Steps for `seconds`, to the nearest whole step.
template <typename AfterStep>
void run(World& world, const Resolution& at, double seconds, const AfterStep& after) {
  const int steps = static_cast<int>(std::lround(seconds / at.dt));
  for (int i = 0; i < steps; ++i) {
    world.step(at.dt);
    after((i + 1) * at.dt);
  }
}
void run(World& world, const Resolution& at, double seconds);

/// In [0, 1), the same everywhere.
inline double uniform(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

/// Integrates y' = rates(y), both vectors of Eigen's, over `seconds` in steps of at most `longest` s: the classical
/// Runge-Kutta method.
template <typename State, typename Rates>
State integrated(State y, double seconds, double longest, const Rates& rates) {
  const int steps = static_cast<int>(std::ceil(seconds / longest));
  const double h = seconds / steps;
  for (int i = 0; i < steps; ++i) {
    const State k1 = rates(y);
    const State k2 = rates(State(y + h / 2 * k1));
    const State k3 = rates(State(y + h / 2 * k2));
    const State k4 = rates(State(y + h * k3));
    y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return y;
}

BodyId add_ground(World& world, const Material& material = {});
/// kg m^2 of a body in the world frame, about its centre of mass.
Matrix3 world_inertia(const World& world, BodyId id, const Matrix3& own);
double kinetic_energy(const World& world, BodyId id, const Matrix3& own_inertia);
Quaternion turn_about(const Vector3& axis, double angle);

}  // namespace atl::physics
