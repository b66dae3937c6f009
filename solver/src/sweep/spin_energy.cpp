#include <solver/integrate/motion_locks.h>
#include <solver/sweep/spin_energy.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {
namespace {

bool turns_blindly(const BodyTable& bodies, std::uint32_t body, double dt) {
  return bodies.gyroscopic[body] && dt * bodies.angular_velocity(body).norm() > tuning::blind_turn;
}

// J.
double kinetic_energy(const BodyTable& bodies, std::uint32_t body) {
  const Vector3 spin = bodies.orientation(body).conjugate() * bodies.angular_velocity(body);
  return 0.5 *
         (bodies.velocity(body).squaredNorm() / bodies.inverse_mass[body] + spin.dot(bodies.inertia[body] * spin));
}

// J: of motion, and in the forces on bodies, which are the same for all of a step.
double energy_of(const SolveInput& input, std::size_t island) {
  const BodyTable& bodies = input.bodies;
  double sum = 0;
  for (const std::uint32_t body : input.islands.bodies(island, island + 1)) {
    const Vector3 force = linear_acceleration(bodies, body, input.gravity) / bodies.inverse_mass[body];
    sum += kinetic_energy(bodies, body) - force.dot(bodies.position(body));
  }
  return sum;
}

bool contacts_alone_act(const SolveInput& input, std::size_t island) {
  const BodyTable& bodies = input.bodies;
  const auto ids = input.islands.bodies(island, island + 1);
  const auto contacts = input.islands.contacts(island, island + 1);
  const auto is_led = [&](std::uint32_t body) {
    return bodies.mobility[body] == Mobility::Kinematic ||
           (!bodies.surfaces.empty() && !bodies.surfaces[body].velocity.isZero(0));
  };
  return input.islands.joint_count(island) == 0 && input.added_slips == nullptr &&
         std::all_of(ids.begin(), ids.end(), [&](std::uint32_t body) { return bodies.torque(body).isZero(0); }) &&
         std::none_of(contacts.begin(), contacts.end(),
                      [&](const TouchingPair& pair) { return is_led(pair.first) || is_led(pair.second); });
}

}  // namespace

void SpinEnergy::begin(const SolveInput& input, const IslandGroup& group) {
  energies_.clear();
  for (std::size_t island = group.begin; island < group.end; ++island) {
    const auto ids = input.islands.bodies(island, island + 1);
    const bool blind = std::any_of(ids.begin(), ids.end(),
                                   [&](std::uint32_t body) { return turns_blindly(input.bodies, body, input.dt); });
    if (blind && contacts_alone_act(input, island)) energies_.emplace_back(island, energy_of(input, island));
  }
}

void SpinEnergy::bound(const SolveInput& input) const {
  BodyTable& bodies = input.bodies;
  for (const auto& [island, before] : energies_) {
    const double gained = energy_of(input, island) - before;
    if (gained <= 0) continue;
    const auto each_blind = [&](const auto& act) {
      for (const std::uint32_t body : input.islands.bodies(island, island + 1)) {
        if (turns_blindly(bodies, body, input.dt)) act(body);
      }
    };
    double theirs = 0;
    each_blind([&](std::uint32_t body) { theirs += kinetic_energy(bodies, body); });
    const double scale = gained < theirs ? std::sqrt(1 - gained / theirs) : 0;
    each_blind([&](std::uint32_t body) {
      bodies.velocity(body) *= scale;
      bodies.angular_velocity(body) *= scale;
    });
  }
}

}  // namespace atl::solver
