#include <features/with_continuous.h>
#include <features/with_joints.h>
#include <jobs/assert.h>
#include <solver/integrate/motion.h>
#include <solver/integrate/state_bounds.h>
#include <solver/integrate/trigonometry.h>

#include <cmath>

namespace atl::solver {

double kinetic_energy(const BodyTable& bodies, std::uint32_t body) {
  const Vector3 spin = bodies.orientation(body).conjugate() * bodies.angular_velocity(body);
  return 0.5 *
         (bodies.velocity(body).squaredNorm() / bodies.inverse_mass[body] + spin.dot(bodies.inertia[body] * spin));
}

double kinetic_energy(const BodyTable& bodies, std::span<const std::uint32_t> of) {
  double sum = 0;
  for (const std::uint32_t body : of) sum += kinetic_energy(bodies, body);
  return sum;
}

Quaternion turned(const Vector3& turn, const Quaternion& orientation) {
  const double angle = turn.norm();
  const SineCosine half = sine_cosine(0.5 * angle);
  const Vector3 vector = (angle > 0 ? half.sine / angle : 0.5) * turn;
  return (Quaternion(half.cosine, vector.x(), vector.y(), vector.z()) * orientation).normalized();
}

void slow_down(BodyTable& bodies, std::span<const std::uint32_t> of, Momentum momentum, double energy, double rotors) {
  Vector3 kept = Vector3::Zero();  // m/s
  ATL_ASSERT(!(energy < 0) && !(rotors < 0), energy, rotors);
  double theirs = kinetic_energy(bodies, of) + rotors;
  if (momentum == Momentum::Keep) {
    double mass = 0;
    for (const std::uint32_t body : of) {
      mass += 1 / bodies.inverse_mass[body];
      ATL_ASSERT(bodies.inverse_mass[body] > 0, body, bodies.inverse_mass[body]);
      kept += bodies.velocity(body) / bodies.inverse_mass[body];
    }
    kept *= 1 / mass;
    theirs -= 0.5 * mass * kept.squaredNorm();
  }
  const double scale = energy < theirs ? std::sqrt(1 - energy / theirs) : 0;
  for (const std::uint32_t body : of) {
    bodies.velocity(body) = kept + scale * (bodies.velocity(body) - kept);
    bodies.angular_velocity(body) *= scale;
  }
}

bool changes_steadily(const Vector3& gained, const Vector3& gained_spin, double acceleration, double dt,
                      double radius) {
  constexpr double steady = 4;
  const double max = steady * dt * acceleration;
  return gained.norm() <= max && radius * gained_spin.norm() <= max;
}

void record_motion(BodyTable& bodies, collision::MotionBounds& bounds, std::uint32_t body, const BodyPose& start,
                   double dt, MovedBodies& notes) {
  const double radius = bodies.radius[body];
  ATL_ASSERT(dt > 0, body, dt);
  ATL_ASSERT(!(radius < 0), body, radius);
  const double chord = turn_chord(start.orientation, bodies.orientation(body));
  const double moved = (bodies.position(body) - start.position).norm() + radius * chord;
  bodies.turned[body] += chord;
  const double speed = bodies.velocity(body).norm();
  const double spin = bodies.angular_velocity(body).norm();
  const bool fast = bounds.moved(body, moved, (speed + spin * radius) * dt);
  const bool sound =
      is_in_place(bodies.position(body), bodies.orientation(body)) && speed <= top_speed && spin <= top_spin;
  if (fast || !sound) notes.fast.push_back({body, start});
  if (with_joints && with_continuous && bodies.joined[body]) notes.joined.push_back({body, start});
}

}  // namespace atl::solver
