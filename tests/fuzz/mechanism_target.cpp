// Trees of joints as they come, and some that are none: where a Mechanism is made of one, its coordinates say what the
// world does, and its dynamics hang together, however it is turned and however fast it moves.

#include <cmath>
#include <string>
#include <vector>

#include "definitions.h"
#include "few_steps.h"
#include "finding.h"
#include "target.h"

namespace {

using namespace atl;
using Eigen::VectorXd;

// Relative to what the terms of a sum are as large as.
constexpr double rounding = 1e-9;

template <typename A, typename B>
void require_equal(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b, double scale,
                   const std::string& what) {
  const double off = a.size() == 0 ? 0 : (a - b).cwiseAbs().maxCoeff();
  fuzz::require(off <= rounding * scale, what + " is off by " + std::to_string(off) + " of " + std::to_string(scale));
}

VectorXd numbers(fuzz::Bytes& bytes, std::size_t count, double reach) {
  VectorXd all(static_cast<Eigen::Index>(count));
  for (double& number : all) number = bytes.within(-reach, reach);
  return all;
}

// The bodies move as v says, and weigh what they weigh.
void check_motion(const World& world, const Mechanism& mechanism, const VectorXd& v) {
  const double speed = 1 + v.cwiseAbs().sum();
  require_equal(mechanism.v(), v, 100 * speed, "v");
  Vector3 momentum = Vector3::Zero(), first_moment = Vector3::Zero();
  double mass = 0, reach = 1;
  for (const BodyId body : mechanism.bodies()) {
    const Pose pose = world.pose(body);
    const Vector3 centre = world.centre_of_mass(body);
    reach = std::max(reach, centre.norm());
    const Eigen::MatrixXd jacobian = mechanism.jacobian(body, pose.orientation.conjugate() * (centre - pose.position));
    const VectorXd rates = jacobian * v;
    require_equal(rates.head(3), world.velocity(body), 100 * reach * speed, "a velocity");
    require_equal(rates.tail(3), world.angular_velocity(body), 100 * speed, "an angular velocity");
    mass += world.mass(body);
    momentum += world.mass(body) * world.velocity(body);
    first_moment += world.mass(body) * centre;
  }
  require_equal(mechanism.momentum().linear, momentum, 100 * mass * reach * speed, "momentum");
  require_equal(mechanism.centre_of_mass(), first_moment / mass, reach, "the centre of mass");
  require_equal(mass * mechanism.centre_of_mass_jacobian() * v, momentum, 100 * mass * reach * speed,
                "momentum by the Jacobian");
}

void check_dynamics(const Mechanism& mechanism, const VectorXd& v, const VectorXd& tau) {
  const Eigen::MatrixXd mass = mechanism.mass_matrix();
  const double heaviest = mass.size() == 0 ? 0 : mass.cwiseAbs().maxCoeff();
  require_equal(mass, mass.transpose(), heaviest, "the mass matrix's symmetry");
  fuzz::require(mass.size() == 0 || mass.diagonal().minCoeff() > 0, "a coordinate without inertia");
  const double energy = mechanism.kinetic_energy(), double_energy = v.dot(mass * v);
  fuzz::require(std::abs(2 * energy - double_energy) <= rounding * (1 + heaviest * v.squaredNorm()),
                "kinetic energy is " + std::to_string(energy) + " J, " + std::to_string(double_energy / 2) + " by M");
  const VectorXd acceleration = mechanism.forward_dynamics(tau), bias = mechanism.bias();
  fuzz::require_finite(acceleration, "an acceleration");
  const double scale = tau.norm() + bias.norm() + heaviest * static_cast<double>(v.size()) * acceleration.norm();
  require_equal(mass * acceleration + bias, tau, 10 * scale, "forward dynamics");
  require_equal(mechanism.inverse_dynamics(acceleration), tau, 10 * scale, "inverse dynamics");
}

void check_again(World& world, Mechanism& mechanism, const VectorXd& v) {
  std::vector<Vector3> places;
  double reach = 1;
  for (const BodyId body : mechanism.bodies()) {
    places.push_back(world.centre_of_mass(body));
    reach = std::max(reach, places.back().norm());
  }
  mechanism.set(mechanism.q(), v);
  for (std::size_t i = 0; i < places.size(); ++i) {
    require_equal(world.centre_of_mass(mechanism.bodies()[i]), places[i], 100 * reach, "a place, by q read back,");
  }
}

void check_reach(const World& world, const Mechanism& mechanism, fuzz::Bytes& bytes) {
  const BodyId body = mechanism.bodies()[bytes.below(mechanism.bodies().size())];
  const std::uint64_t before = world.state_hash();
  const Vector3 target = numbers(bytes, 3, 2);
  const InverseKinematics found = mechanism.inverse_kinematics(body, Vector3::Zero(), target);
  fuzz::require_finite(found.q, "q of inverse kinematics");
  fuzz::require(found.position_error >= 0, "an error of inverse kinematics below 0");
  fuzz::require(world.state_hash() == before, "inverse kinematics moves the world");
}

void run(fuzz::Bytes& bytes) {
  World world({.gravity = numbers(bytes, 3, 10)});
  fuzz::Definitions definitions(bytes, fuzz::Numbers::Usual);
  std::vector<BodyId> bodies;
  for (std::uint32_t left = 2 + bytes.below(8); left > 0; --left) {
    const bool moves = !bodies.empty() || bytes.flag();
    BodyDef def = {.type = moves ? BodyType::Dynamic : BodyType::Static,
                   .shape = Box{.half_extents = {bytes.within(0.05, 0.5), bytes.within(0.05, 0.5), 0.2}},
                   .position = numbers(bytes, 3, 2),
                   .orientation = definitions.orientation(),
                   .density = std::pow(10.0, bytes.below(5))};
    def.filter.mask = 0;
    bodies.push_back(world.add_body(def));
    if (bodies.size() == 1) continue;
    const BodyId above = bodies[bytes.below(bodies.size() - 1)];
    try {
      world.add_joint(definitions.joint(world, above, bodies.back()));
    } catch (const Error&) {
    }
  }
  try {
    Mechanism mechanism(world, bodies.front());
    for (int turn = 0; turn < 3; ++turn) {
      const VectorXd v = numbers(bytes, mechanism.nv(), turn == 0 ? 0 : 5);
      mechanism.set(mechanism.integrate(mechanism.q(), numbers(bytes, mechanism.nv(), 2)), v);
      check_motion(world, mechanism, v);
      check_dynamics(mechanism, v, numbers(bytes, mechanism.nv(), 100));
      check_again(world, mechanism, v);
      check_reach(world, mechanism, bytes);
      mechanism.apply(numbers(bytes, mechanism.nv(), 10));
      fuzz::few_steps(world, 2);
    }
  } catch (const Error&) {  // none can be made of these, or what it was made of broke
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  atl::fuzz::Bytes bytes({data, size});
  run(bytes);
  return 0;
}
