#include <features/with_continuous.h>
#include <features/with_joints.h>
#include <solver/integrate/motion.h>
#include <solver/integrate/state_bounds.h>

#include <cmath>

namespace atl::solver {

double kinetic_energy(const BodyTable& bodies, std::uint32_t body) {
  const Vector3 spin = bodies.orientation(body).conjugate() * bodies.angular_velocity(body);
  return 0.5 *
         (bodies.velocity(body).squaredNorm() / bodies.inverse_mass[body] + spin.dot(bodies.inertia[body] * spin));
}

void slow_down(BodyTable& bodies, std::uint32_t body, double energy) {
  const double own = kinetic_energy(bodies, body);
  const double scale = energy < own ? std::sqrt(1 - energy / own) : 0;
  bodies.velocity(body) *= scale;
  bodies.angular_velocity(body) *= scale;
}

bool changes_steadily(const Vector3& gained, const Vector3& gained_spin, const Vector3& acceleration, double dt,
                      double radius) {
  constexpr double steady = 4;
  const double most = steady * dt * steady * dt * acceleration.squaredNorm();
  return gained.squaredNorm() <= most && gained_spin.squaredNorm() * radius * radius <= most;
}

void note_motion(BodyTable& bodies, collision::MotionBounds& bounds, std::uint32_t body, const BodyPose& start,
                 double dt, MovedBodies& notes) {
  const double radius = bodies.radius[body];
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
