#include <jobs/assert.h>
#include <solver/constraints/arm_stiffness.h>
#include <solver/constraints/contact_inertia.h>
#include <solver/direct/moving_bodies.h>
#include <solver/integrate/motion_locks.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "integrate/matrix3.h"

namespace atl::solver {
namespace {

// m/s, of what a body touches against it, at most.
double approach_speed(const BodyTable& table, const IslandMembers& members, std::uint32_t body) {
  double max = 0;
  for (const collision::TouchingPair& pair : members.contacts) {
    if (pair.first != body && pair.second != body) continue;
    max = std::max(max, (table.velocity(pair.first) - table.velocity(pair.second)).norm());
  }
  return max;
}

// Adds to inertia how bodies that joints pull on resist turning. `pull`: on the second body of a joint.
template <typename Pull>
void add_arm_stiffness(IslandProblem& problem, double scale, const Pull& pull) {
  for (const DirectJoint& joint : problem.joints) {
    const Vector3 on_second = pull(joint);
    const auto add = [&](std::uint32_t body, const Vector3& arm, const Vector3& force) {
      if (body == no_body || !(arm.dot(force) > 0)) return;
      add_scaled(problem.bodies[body].inertia, scale, arm_stiffness(arm, force));
    };
    add(joint.first, joint.arm_first, -on_second);
    add(joint.second, joint.arm_second, on_second);
  }
  for (DirectBody& body : problem.bodies) body.inverse_inertia = inverse_inertia_with(body.locks, body.inertia);
}

void take_mass(const BodyTable& table, DirectBody& body) {
  const double inverse = table.inverse_mass[body.body];
  ATL_ASSERT(inverse > 0, body.body, inverse);
  body.weigh(1 / inverse, inverse);
}

// kg, by the impulses of the closing motion: how a rod that pulls holds its ends from going aside.
double stiffness_of_rod(const Joint& of, const DirectJoint& joint) {
  double sum = 0;
  for (std::size_t r = joint.point_rows(), k = 0; r < joint.rows; ++r, ++k) {
    const double length = joint.at[r].value;
    if (of.coordinate[k] == Coordinate::Distance && length > 0) sum += std::max(-joint.closing[r], 0.0) / length;
  }
  return sum;
}

}  // namespace

void set_inertia_half_way(const BodyTable& table, DirectBody& body) {
  const Matrix3 rotation = (rotation_by(body.half_turn) * table.orientation(body.body)).toRotationMatrix();
  body.inertia = rotation * table.inertia[body.body] * rotation.transpose();
  body.inverse_inertia = rotation * table.inverse_inertia[body.body] * rotation.transpose();
}

bool load_bodies(const SolveInput& input, const IslandMembers& members, IslandProblem& problem,
                 std::vector<MovingBody>& bodies) {
  const BodyTable& table = input.bodies;
  const bool joined = !members.joints.empty();
  bodies.resize(members.bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t body = members.bodies[i];
    MovingBody& moving = bodies[i];
    moving.tumbles = table.gyroscopic[body] != 0;
    if (!joined && moving.tumbles && !(input.dt * table.angular_velocity(body).norm() <= tuning::max_tumble))
      return false;
    if (joined && moving.tumbles) moving.top = SplitTop(table.moments[body], table.principal_axes[body]);
    moving.now = moving.start = {table.position(body), table.orientation(body)};
    moving.body_inertia = table.inertia[body];
    moving.acceleration = linear_acceleration(table, body, input.gravity);

    DirectBody& of = problem.bodies[i];
    of.body = body;
    of.locks = table.locks[body];
    of.spin = table.angular_velocity(body);
    of.half_turn = joined ? Vector3::Zero() : half_turn(table, body, input.dt);
    take_mass(table, of);
    if (!joined && is_seen_heavier(table, body)) {
      const double swing = swing_in_contact(table, body, approach_speed(table, members, body), input.dt);
      of.inertia = inertia_in_contact(table, body, swing);
      of.inverse_inertia = inverse_inertia_in_contact(table, body, swing);
    } else if (!members.contacts.empty()) {  // which these are weighed with
      set_inertia_half_way(table, of);
    }
    of.radius = std::sqrt((joined ? table.inertia[body] : of.inertia).trace() / (3 * of.mass));
    ATL_ASSERT(of.radius > 0, body, of.radius);
    linear_part(problem.velocity, i) = table.velocity(body);
    angular_part(problem.velocity, i) = table.angular_velocity(body);
  }
  return true;
}

Vector3 turning(const DirectBody& body, const MovingBody& moving, const Vector3& torque) {
  if (torque.isZero(0)) return Vector3::Zero();
  return product(inverse_inertia_with(body.locks, moving.inertia), torque);
}

void free_velocities_of_kick(const BodyTable& table, double time, std::span<const MovingBody> bodies,
                             IslandProblem& problem) {
  problem.free = problem.velocity;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const DirectBody& body = problem.bodies[i];
    linear_part(problem.free, i) += time * bodies[i].acceleration;
    angular_part(problem.free, i) += time * turning(body, bodies[i], table.torque(body.body));
  }
}

void turn_inertia(std::span<MovingBody> bodies) {
  for (MovingBody& body : bodies) {
    const Matrix3 rotation = body.now.orientation.toRotationMatrix();
    body.inertia = symmetric_product(product(rotation, body.body_inertia), rotation);
  }
}

void place_inertia(IslandProblem& problem, std::span<MovingBody> bodies, double h) {
  turn_inertia(bodies);
  for (std::size_t i = 0; i < bodies.size(); ++i) problem.bodies[i].inertia = bodies[i].inertia;
  add_arm_stiffness(problem, h * h, [](const DirectJoint& joint) { return joint.tension; });
}

void add_closing_stiffness(const Joint* joints, IslandProblem& problem) {
  add_arm_stiffness(problem, 1, [](const DirectJoint& joint) { return joint.linear_impulse(joint.closing); });
  for (const DirectJoint& joint : problem.joints) {
    const double stiffness = stiffness_of_rod(joints[joint.joint], joint);
    if (stiffness == 0) continue;
    for (const std::uint32_t end : {joint.first, joint.second}) {
      if (end == no_body) continue;
      DirectBody& body = problem.bodies[end];
      const double mass = body.mass + 2 * stiffness;
      body.weigh(mass, 1 / mass);
    }
  }
}

void restore_masses(const BodyTable& table, IslandProblem& problem) {
  for (DirectBody& body : problem.bodies) take_mass(table, body);
}

void move(std::span<MovingBody> bodies, double share, const std::vector<double>& by) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    BodyPose& pose = bodies[i].now;
    pose.position += share * linear_part(by, i);
    pose.orientation = turned(share * angular_part(by, i), pose.orientation);
  }
}

}  // namespace atl::solver
