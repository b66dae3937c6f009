#include <solver/constraints/arm_stiffness.h>
#include <solver/constraints/contact_inertia.h>
#include <solver/direct/moving_bodies.h>
#include <solver/tuning.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace atl::solver {
namespace {

// m/s, of what a body touches against it, at most.
double approach_speed(const BodyTable& table, const IslandMembers& members, std::uint32_t body) {
  double most = 0;
  for (const collision::TouchingPair& pair : members.contacts) {
    if (pair.first != body && pair.second != body) continue;
    most = std::max(most, (table.velocity(pair.first) - table.velocity(pair.second)).norm());
  }
  return most;
}

}  // namespace

bool load_bodies(const DirectIslandInput& input, const IslandMembers& members, IslandProblem& problem,
                 std::vector<MovingBody>& bodies) {
  const BodyTable& table = input.bodies;
  const bool joined = !members.joints.empty();
  const double solved_time = joined ? input.substep() : input.dt;
  bodies.resize(members.bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t body = members.bodies[i];
    MovingBody& moving = bodies[i];
    moving.tumbles = table.gyroscopic[body] != 0;
    if (moving.tumbles && !(solved_time * table.angular_velocity(body).norm() <= tuning::most_tumble)) return false;
    moving.now = moving.start = {table.position(body), table.orientation(body)};
    moving.body_inertia = table.inertia[body];
    moving.acceleration = input.gravity * table.gravity_scale[body] + table.inverse_mass[body] * table.force(body);

    DirectBody& of = problem.bodies[i];
    of.body = body;
    of.mass = 1 / table.inverse_mass[body];
    if (!joined && is_seen_heavier(table, body)) {
      const double swing = swing_in_contact(table, body, approach_speed(table, members, body), input.dt);
      of.inertia = inertia_in_contact(table, body, swing);
      of.inverse_inertia = inverse_inertia_in_contact(table, body, swing);
    } else {
      const Matrix3 rotation = table.orientation(body).toRotationMatrix();
      of.inertia = rotation * table.inertia[body] * rotation.transpose();
      of.inverse_inertia = rotation * table.inverse_inertia[body] * rotation.transpose();
    }
    of.radius = std::sqrt(of.inertia.trace() / (3 * of.mass));
    linear_part(problem.velocity, i) = table.velocity(body);
    angular_part(problem.velocity, i) = table.angular_velocity(body);
  }
  return true;
}

void place_inertia(IslandProblem& problem, std::span<MovingBody> bodies, double h) {
  for (MovingBody& body : bodies) body.stiffness.setZero();
  for (const DirectJoint& joint : problem.joints) {
    const auto add = [&](std::uint32_t body, const Vector3& arm, const Vector3& force) {
      if (body != no_body) bodies[body].stiffness += arm_stiffness(arm, force);
    };
    add(joint.first, joint.arm_first, -joint.tension);
    add(joint.second, joint.arm_second, joint.tension);
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    MovingBody& body = bodies[i];
    const Matrix3 rotation = body.now.orientation.toRotationMatrix();
    body.inertia = rotation * body.body_inertia * rotation.transpose();
    DirectBody& of = problem.bodies[i];
    of.inertia = body.inertia + h * h * body.stiffness;
    of.inverse_inertia = of.inertia.inverse();
  }
}

void move(std::span<MovingBody> bodies, double share, const std::vector<double>& by) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    BodyPose& pose = bodies[i].now;
    pose.position += share * linear_part(by, i);
    pose.orientation = turned(share * angular_part(by, i), pose.orientation);
  }
}

}  // namespace atl::solver
