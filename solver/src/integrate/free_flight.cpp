#include <jobs/assert.h>
#include <solver/integrate/free_flight.h>
#include <solver/integrate/motion_locks.h>
#include <solver/integrate/trigonometry.h>

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

// Rotation vector of a turn for h seconds in which the momentum stays as it is in the world, both in the body's frame
// at the start: Magnus' series to fourth order in h, from the derivatives of the spin at the start (Blanes, Casas, Oteo
// and Ros, "The Magnus expansion and some of its applications", 2009, section 2). A steady spin is followed exactly.
Vector3 free_turn(const Vector3& momentum, const Matrix3& inverse_inertia, double h) {
  const auto spin_of = [&](const Vector3& x) -> Vector3 { return inverse_inertia * x; };
  // Euler's equations, l' = l x w, and their derivatives.
  const Vector3& l = momentum;
  const Vector3 w = spin_of(l);
  const Vector3 l1 = l.cross(w);
  const Vector3 w1 = spin_of(l1);
  const Vector3 l2 = l1.cross(w) + l.cross(w1);
  const Vector3 w2 = spin_of(l2);
  const Vector3 l3 = l2.cross(w) + 2 * l1.cross(w1) + l.cross(w2);
  const Vector3 w3 = spin_of(l3);
  const Vector3 cubic = w2 + 0.5 * w.cross(w1);
  const Vector3 quartic = w3 + w.cross(w2);
  return h * (w + h / 2 * (w1 + h / 3 * (cubic + h / 4 * quartic)));
}

// The steps into which a torque-free rotation is divided.
struct RotationSteps {
  double twentieths;  // of a radian, that are turned by, but for what is a great many
  bool splits;        // by SplitTop, in fewer steps than that

  // Steps short enough that a fast top turns less than a twentieth of a radian in each. Where moments differ by more
  // than a dozen times, what a turn makes of the spin about the least counts for more: a needle's grows by its whole
  // momentum over that moment.
  RotationSteps(const Vector3& moments, const Vector3& spin, double dt) {
    ATL_ASSERT(moments.minCoeff() > 0, moments.x(), moments.y(), moments.z());
    constexpr double ordinary = 16;
    constexpr double max = 4096;
    const double ratio = moments.maxCoeff() / moments.minCoeff();
    const double angle = spin.norm() * dt * std::sqrt(std::max(1.0, ratio / ordinary));
    twentieths = std::min(max, angle / 0.05);  // 4096 if it isn't a number
    splits = !(angle / 0.05 < max);
    if (splits) twentieths = max / 16;
  }
};

// J
double energy_of(const BodyTable& bodies, std::uint32_t body, const Quaternion& orientation, const Vector3& momentum) {
  const Vector3 own = orientation.conjugate() * momentum;
  return 0.5 * own.dot(bodies.inverse_inertia[body] * own);
}

// An orientation near by at which a momentum has so much energy: on the great circle of such momenta towards the axis
// with the most or least of it. Along that it is a mean and a sine of twice the angle.
Quaternion with_energy(const BodyTable& bodies, std::uint32_t body, const Quaternion& orientation,
                       const Vector3& momentum, double energy) {
  constexpr double exact = 1e-9;
  const Matrix3& inverse = bodies.inverse_inertia[body];
  const Vector3 own = orientation.conjugate() * momentum;
  const Vector3 spin = inverse * own;
  const double here = 0.5 * own.dot(spin);
  if (!(std::abs(here - energy) > exact * energy)) return orientation;
  int axis = 0;
  here > energy ? bodies.moments[body].maxCoeff(&axis) : bodies.moments[body].minCoeff(&axis);
  const Vector3 extreme = bodies.principal_axes[body] * Vector3::Unit(axis);
  const Vector3 towards = extreme - extreme.dot(own) / own.squaredNorm() * own;
  const Vector3 across = std::sqrt(own.squaredNorm() / towards.squaredNorm()) * towards;
  if (!across.allFinite()) return orientation;
  const double there = 0.5 * across.dot(inverse * across), both = 0.5 * across.dot(spin);
  const double cosine = 0.5 * (here - there);
  const double amplitude = std::sqrt(cosine * cosine + both * both);
  const double wanted = std::clamp((energy - 0.5 * (here + there)) / amplitude, -1.0, 1.0);
  const double top = arctangent(both, cosine), from_top = arctangent(std::sqrt(1 - wanted * wanted), wanted);
  const double twice = std::abs(top - from_top) < std::abs(top + from_top) ? top - from_top : top + from_top;
  const SineCosine turn = sine_cosine(0.5 * twice);
  const Vector3 next = turn.cosine * own + turn.sine * across;
  const Vector3 axis_of_turn = next.cross(own);  // by which the one comes to the other
  const Quaternion between(own.squaredNorm() + next.dot(own), axis_of_turn.x(), axis_of_turn.y(), axis_of_turn.z());
  return (orientation * between.normalized()).normalized();
}

// The orientation after h seconds in which the momentum stays what it is. In steps of many radians a SplitTop would
// not keep the energy of a body with three moments.
Quaternion turned_freely(const BodyTable& bodies, std::uint32_t body, const Quaternion& start, const Vector3& momentum,
                         double h, bool splits) {
  if (splits) {
    const Quaternion end = SplitTop(bodies.moments[body], bodies.principal_axes[body]).turned(start, momentum, h);
    return with_energy(bodies, body, end, momentum, energy_of(bodies, body, start, momentum));
  }
  const Vector3 turn = free_turn(start.conjugate() * momentum, bodies.inverse_inertia[body], h);
  return (start * rotation_by(turn)).normalized();
}

Vector3 momentum_of(const BodyTable& bodies, std::uint32_t body, const Quaternion& orientation, const Vector3& spin) {
  return orientation * (bodies.inertia[body] * (orientation.conjugate() * spin));
}

Vector3 spin_of(const BodyTable& bodies, std::uint32_t body, const Quaternion& orientation, const Vector3& momentum) {
  return orientation * (bodies.inverse_inertia[body] * (orientation.conjugate() * momentum));
}

void move_gyroscopic(BodyTable& bodies, std::uint32_t body, double dt, int substeps) {
  const RotationSteps cut(bodies.moments[body], bodies.angular_velocity(body), dt);
  // A slow one needs fewer steps than there are substeps, if no torque and no damping act in each.
  const bool alone = bodies.torque(body).isZero(0) && bodies.angular_damping[body] == 0;
  const double share = cut.splits ? 1 : std::min(1.0, cut.twentieths);
  const int min = alone ? std::max(1, static_cast<int>(std::ceil(substeps * share))) : substeps;
  const int steps = std::max(min, static_cast<int>(cut.twentieths));
  const double h = dt / steps;
  Quaternion orientation = bodies.orientation(body);
  Vector3 momentum = momentum_of(bodies, body, orientation, bodies.angular_velocity(body));
  const double damping = 1 / (1 + h * bodies.angular_damping[body]);
  for (int i = 0; i < steps; ++i) {
    momentum += h * bodies.torque(body);
    orientation = turned_freely(bodies, body, orientation, momentum, h, cut.splits);
    momentum *= damping;
  }
  bodies.set_orientation(body, orientation);
  bodies.angular_velocity(body) = spin_of(bodies, body, orientation, momentum);
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
  const double square = rotation_vector.squaredNorm();
  double cosine, scale;  // of half the angle, and its sine over the angle
  if (square < 0.004) {
    // Power series; the first terms left out are below 3e-17.
    cosine = 1 - square / 8 * (1 - square / 48 * (1 - square / 120));
    scale = 0.5 - square / 48 * (1 - square / 80 * (1 - square / 168));
  } else {
    const double angle = std::sqrt(square);
    const SineCosine half = sine_cosine(0.5 * angle);
    cosine = half.cosine;
    scale = half.sine / angle;
  }
  const Vector3 v = scale * rotation_vector;
  return {cosine, v.x(), v.y(), v.z()};
}

void turn_back(BodyTable& bodies, std::uint32_t body, const Quaternion& orientation) {
  const Quaternion before = bodies.orientation(body);
  bodies.set_orientation(body, orientation);
  if (!bodies.gyroscopic[body] || angular_locks(bodies.locks[body]) != 0) return;
  const Vector3 in_body = before.conjugate() * bodies.angular_velocity(body);
  bodies.angular_velocity(body) = orientation * in_body;
}

SplitTop::SplitTop(const Vector3& moments, const Quaternion& principal) : principal_(principal) {
  ATL_ASSERT(moments.minCoeff() > 0, moments.x(), moments.y(), moments.z());
  const Vector3 inverse = moments.cwiseInverse();
  // The axis of the top is that whose moment differs most from the nearer of the others.
  double max = -1;
  for (int i = 0; i < 3; ++i) {
    const double a = inverse[(i + 1) % 3], b = inverse[(i + 2) % 3];
    const double apart = std::min(std::abs(inverse[i] - a), std::abs(inverse[i] - b));
    if (!(apart > max)) continue;
    max = apart;
    axis_ = i;
  }
  const double a = inverse[(axis_ + 1) % 3], b = inverse[(axis_ + 2) % 3];
  across_ = 0.5 * (a + b);
  along_ = inverse[axis_] - across_;
  rest_ = 0.5 * (a - b);
  own_axis_ = principal * Vector3::Unit(axis_);
}

Quaternion SplitTop::turned(const Quaternion& start, const Vector3& momentum, double h) const {
  Quaternion q = start * principal_;
  const auto about = [&](int axis, double rate) {
    const double part = (q.conjugate() * momentum)[axis];
    q = q * rotation_by(rate * part * Vector3::Unit(axis));
  };
  const auto rest = [&] {
    about((axis_ + 1) % 3, 0.25 * h * rest_);
    about((axis_ + 2) % 3, -0.5 * h * rest_);
    about((axis_ + 1) % 3, 0.25 * h * rest_);
  };
  rest();
  about(axis_, h * along_);
  q = rotation_by(h * across_ * momentum) * q;
  rest();
  return (q * principal_.conjugate()).normalized();
}

void SplitTop::turn(const Matrix3& inverse_inertia, const Vector3& momentum, double h, Quaternion& orientation,
                    Vector3& spin) const {
  if (rest_ != 0) {
    orientation = turned(orientation, momentum, h);
    spin = orientation * (inverse_inertia * (orientation.conjugate() * momentum));
    return;
  }
  const Vector3 axis = orientation * own_axis_;
  const Quaternion precession = rotation_by(h * across_ * momentum);
  orientation = (precession * (rotation_by(h * along_ * axis.dot(momentum) * axis) * orientation)).normalized();
  spin = precession * spin;
}

void move_free_body(BodyTable& bodies, std::uint32_t body, const Vector3& gravity, double dt, int substeps,
                    collision::MotionBounds& bounds, FastBodies& fast) {
  ATL_ASSERT(dt > 0 && substeps >= 1, body, dt, substeps);
  ATL_ASSERT(bodies.mobility[body] == Mobility::Dynamic, body, static_cast<int>(bodies.mobility[body]));
  const BodyPose start{bodies.position(body), bodies.orientation(body)};
  move_linear(bodies, body, linear_acceleration(bodies, body, gravity), dt, substeps);
  if (bodies.gyroscopic[body]) {
    move_gyroscopic(bodies, body, dt, substeps);
  } else {
    move_isotropic(bodies, body, dt, substeps);
  }
  record_motion(bodies, bounds, body, start, dt, fast.local());
}

BodyPose pose_after(const BodyTable& bodies, std::uint32_t body, double time) {
  if (bodies.mobility[body] == Mobility::Fixed) return {bodies.position(body), bodies.orientation(body)};
  const Quaternion turn = rotation_by(time * bodies.angular_velocity(body));
  return {bodies.position(body) + time * bodies.velocity(body), (turn * bodies.orientation(body)).normalized()};
}

void move_kinematic_body(BodyTable& bodies, std::uint32_t body, double dt, collision::MotionBounds& bounds,
                         FastBodies& fast) {
  ATL_ASSERT(dt > 0, body, dt);
  ATL_ASSERT(bodies.mobility[body] == Mobility::Kinematic, body, static_cast<int>(bodies.mobility[body]));
  const BodyPose start{bodies.position(body), bodies.orientation(body)};
  const BodyPose end = pose_after(bodies, body, dt);
  bodies.position(body) = end.position;
  bodies.set_orientation(body, end.orientation);
  record_motion(bodies, bounds, body, start, dt, fast.local());
}

}  // namespace atl::solver
