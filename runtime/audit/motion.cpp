#include <atoll/errors.h>

namespace atl {

MotionReport measure_motion(std::span<const MovingBody> bodies, const Vector3& gravity) {
  MotionReport report;
  for (const MovingBody& body : bodies) {
    const BodyState& state = body.state;
    const Quaternion turn = state.pose.orientation.normalized();
    const Vector3 centre = state.pose.position + turn * body.mass.centre;
    const Vector3 spin = turn * (body.mass.inertia * (turn.conjugate() * state.angular_velocity));
    report.kinetic += 0.5 * (body.mass.mass * state.velocity.squaredNorm() + state.angular_velocity.dot(spin));
    report.potential -= body.mass.mass * body.gravity_scale * gravity.dot(centre);
    report.momentum += body.mass.mass * state.velocity;
    report.angular_momentum += body.mass.mass * centre.cross(state.velocity) + spin;
  }
  return report;
}

}  // namespace atl
