#include "linkages.h"

namespace atl::physics {

World mechanism_world(const Resolution& at, double gravity) {
  return make_world(at, gravity, {.joint_solver = JointSolver::Direct});
}

BodyId add_floor(World& world) {
  return world.add_body({.type = BodyType::Static, .shape = Sphere{0.01}, .filter = no_contact});
}

JointId add_hinge(World& world, BodyId first, BodyId second, const Vector3& place, const Vector3& axis,
                  const JointAxis& angle) {
  return world.add_joint(joint_at(world, HingeJoint{angle}, first, second, place, axis));
}

Part add_part(World& world, double mass, const Vector3& moments, const Pose& pose, const Vector3& velocity,
              const Vector3& spin) {
  const Matrix3 inertia = moments.asDiagonal();
  const BodyId body = world.add_body({.shape = Sphere{0.01},
                                      .position = pose.position,
                                      .orientation = pose.orientation,
                                      .velocity = velocity,
                                      .angular_velocity = spin,
                                      .mass = mass,
                                      .inertia = inertia,
                                      .filter = no_contact});
  return {body, inertia};
}

Vector3 angular_momentum(const World& world, const std::vector<Part>& parts) {
  double mass = 0;
  Vector3 centre = Vector3::Zero();
  for (const Part& part : parts) {
    mass += world.mass(part.body);
    centre += world.mass(part.body) * world.centre_of_mass(part.body);
  }
  centre /= mass;
  Vector3 sum = Vector3::Zero();
  for (const auto& [body, inertia] : parts) {
    sum += world_inertia(world, body, inertia) * world.angular_velocity(body) +
           world.mass(body) * (world.centre_of_mass(body) - centre).cross(world.velocity(body));
  }
  return sum;
}

BodyId Rods::add(const Vector3& tail, const Vector3& head, const Vector3& velocity) {
  const Vector3 along = head - tail;
  const double moment = along.squaredNorm() / 12;
  rods_.push_back(add_part(world_, 1, {1e-6, moment, moment},
                           {0.5 * (tail + head), turn_between(Vector3::UnitX(), along)}, velocity));
  return rods_.back().body;
}

double Rods::energy() const {
  double sum = 0;
  for (const auto& [rod, inertia] : rods_) {
    sum += kinetic_energy(world_, rod, inertia) - world_.mass(rod) * world_.gravity().dot(world_.centre_of_mass(rod));
  }
  return sum;
}

}  // namespace atl::physics
