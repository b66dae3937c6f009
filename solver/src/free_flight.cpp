#include <solver/free_flight.h>
#include <solver/motion_locks.h>
#include <solver/trigonometry.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {
namespace {

void move_linear(BodyTable& bodies, std::uint32_t body, const Vector3& acceleration, double dt, int substeps) {
  auto position = bodies.position(body);
  auto velocity = bodies.velocity(body);
  const double damping = bodies.linear_damping[body];
  if (damping == 0) {
    position += dt * velocity + (0.5 * dt * dt) * acceleration;
    velocity += dt * acceleration;
    return;
  }
  const double h = dt / substeps;
  for (int i = 0; i < substeps; ++i) {
    const Vector3 start = velocity;
    velocity = (velocity + h * acceleration) / (1 + h * damping);
    position += (0.5 * h) * (start + velocity);
  }
}

// Rate of change of the rotation vector of a body since the start of a step, in its frame then, that spins at w in its
// frame now: Bortz, "A new mathematical formulation for strapdown inertial navigation", 1971, to third order in the
// vector. Where w is constant so is the rate, and a steady spin is followed exactly.
Vector3 rotation_rate(const Vector3& turned, const Vector3& w) {
  const Vector3 drift = turned.cross(w);
  return w + 0.5 * drift + (1.0 / 12) * turned.cross(drift);
}

void move_gyroscopic(BodyTable& bodies, std::uint32_t body, double dt, int substeps) {
  // Steps short enough that a fast top turns less than a twentieth of a radian in each. Where moments differ by more
  // than a dozen times, what a turn makes of the spin about the least counts for more: a needle's grows by its whole
  // momentum over that moment.
  constexpr double ordinary = 16;
  const Vector3& moments = bodies.moments[body];
  const double ratio = moments.maxCoeff() / moments.minCoeff();
  const double turn = bodies.angular_velocity(body).norm() * dt * std::sqrt(std::max(1.0, ratio / ordinary));
  const int steps = std::max(substeps, static_cast<int>(std::min(turn / 0.05, 4096.0)));
  const double h = dt / steps;
  const Matrix3& inverse_inertia = bodies.inverse_inertia[body];
  Quaternion orientation = bodies.orientation(body);
  Vector3 momentum =
      orientation * (bodies.inertia[body] * (orientation.conjugate() * Vector3(bodies.angular_velocity(body))));
  const double damping = 1 / (1 + h * bodies.angular_damping[body]);
  for (int i = 0; i < steps; ++i) {
    momentum += h * bodies.torque(body);
    const Vector3 start = orientation.conjugate() * momentum;  // in the frame of the rotation vector
    const auto rate = [&](const Vector3& turned) {
      return rotation_rate(turned, inverse_inertia * (rotation_by(-turned) * start));
    };
    const Vector3 k1 = inverse_inertia * start;
    const Vector3 k2 = rate(0.5 * h * k1);
    const Vector3 k3 = rate(0.5 * h * k2);
    const Vector3 k4 = rate(h * k3);
    orientation = (orientation * rotation_by((h / 6) * (k1 + 2 * k2 + 2 * k3 + k4))).normalized();
    momentum *= damping;
  }
  bodies.set_orientation(body, orientation);
  bodies.angular_velocity(body) = orientation * (inverse_inertia * (orientation.conjugate() * momentum));
}

void turn_by(BodyTable& bodies, std::uint32_t body, const Vector3& rotation_vector) {
  bodies.set_orientation(body, (rotation_by(rotation_vector) * bodies.orientation(body)).normalized());
}

// A body whose inertia is the same about all axes that it may turn about, or is taken to be.
void move_isotropic(BodyTable& bodies, std::uint32_t body, double dt, int substeps) {
  auto w = bodies.angular_velocity(body);
  const Vector3 acceleration = angular_locks(bodies.locks[body]) != 0
                                   ? angular_response(bodies, body, bodies.torque(body))
                                   : Vector3(bodies.inverse_inertia[body](0, 0) * bodies.torque(body));
  const double damping = bodies.angular_damping[body];
  const int steps = damping == 0 ? 1 : substeps;
  const double h = dt / steps;
  for (int i = 0; i < steps; ++i) {
    const Vector3 start = w;
    w = (w + h * acceleration) / (1 + h * damping);
    turn_by(bodies, body, (0.5 * h) * (start + w));
  }
}

}  // namespace

Quaternion rotation_by(const Vector3& rotation_vector) {
  const double angle = rotation_vector.norm();
  const SineCosine half = sine_cosine(0.5 * angle);
  // sin(x/2) / x tends to 1/2.
  const double scale = angle > 1e-8 ? half.sine / angle : 0.5;
  const Vector3 v = scale * rotation_vector;
  return {half.cosine, v.x(), v.y(), v.z()};
}

void move_free_body(BodyTable& bodies, std::uint32_t body, const Vector3& gravity, double dt, int substeps,
                    FastBodies& fast) {
  const BodyPose start{bodies.position(body), bodies.orientation(body)};
  move_linear(bodies, body, linear_acceleration(bodies, body, gravity), dt, substeps);
  if (bodies.gyroscopic[body]) {
    move_gyroscopic(bodies, body, dt, substeps);
  } else {
    move_isotropic(bodies, body, dt, substeps);
  }
  note_motion(bodies, body, start, dt, fast);
}

void move_kinematic_body(BodyTable& bodies, std::uint32_t body, double dt, FastBodies& fast) {
  const BodyPose start{bodies.position(body), bodies.orientation(body)};
  bodies.position(body) += dt * bodies.velocity(body);
  turn_by(bodies, body, dt * bodies.angular_velocity(body));
  note_motion(bodies, body, start, dt, fast);
}

}  // namespace atl::solver
