#include <jobs/assert.h>
#include <solver/constraints/contact_arm.h>
#include <solver/integrate/free_flight.h>
#include <solver/tuning.h>

#include <algorithm>

namespace atl::solver {
namespace {

// A turn without the part about an axis. One by half a turn across it has none.
Quaternion swing_of(const Quaternion& turn, const Vector3& axis) {
  const Vector3 about = turn.vec().dot(axis) * axis;
  const Quaternion twist(turn.w(), about.x(), about.y(), about.z());
  if (twist.squaredNorm() < 1e-12) return turn;
  return turn * twist.normalized().conjugate();
}

// m: of the ball that a tapered capsule touches with, by where on its side the contact is. All in the shape's frame.
double radius_at(const collision::Shape& shape, const Vector3& point, const Vector3& outward) {
  const double low = outward.z() * shape.radius - shape.half_height;
  const double high = outward.z() * shape.top_radius + shape.half_height;
  const double part = high > low ? std::clamp((point.z() - low) / (high - low), 0.0, 1.0) : 0;
  return shape.radius + part * (shape.top_radius - shape.radius);
}

// m: the radius by which an ellipsoid curves where its outward normal is n, along its way over the surface below as it
// turns. With A = diag(a^2) and H = |a n| the radii of curvature are those of A / H - (A n) (A n)^T / H^3, the second
// derivative of how far it reaches along n, across n. All in the shape's frame.
double curvature_radius(const Vector3& half_axes, const Vector3& outward, const Vector3& spin) {
  const Vector3 squares = half_axes.cwiseAbs2();
  const double reach = half_axes.cwiseProduct(outward).norm();
  const Vector3 touched = squares.cwiseProduct(outward) / reach;
  Vector3 way = spin.cross(outward);
  const double length = way.norm();
  way = length > 0 ? Vector3(way / length) : outward.unitOrthogonal();
  const double aside = way.dot(touched);
  return (squares.dot(way.cwiseAbs2()) - aside * aside) / reach;
}

}  // namespace

ContactArm contact_arm(const BodyTable& bodies, std::uint32_t body, const collision::ColliderTable& colliders,
                       std::uint32_t collider, const Vector3& anchor, const Vector3& outward) {
  ATL_ASSERT(!(std::abs(outward.squaredNorm() - 1) > 1e-5), body, collider, outward.norm());
  ATL_ASSERT(colliders.body[collider] == body, collider, body, colliders.body[collider]);
  // A ball is touched on the line through its centre.
  if (bodies.ball[body]) return {.rim = outward.dot(anchor) * outward};
  if (!bodies.rolls[body]) return {.pivot = anchor};
  const collision::Shape& shape = colliders.shape[collider];
  switch (shape.kind) {
    case collision::ShapeKind::Sphere:
    case collision::ShapeKind::Capsule: {
      const Vector3 rim = shape.radius * outward;
      return {.pivot = anchor - rim, .rim = rim};
    }
    case collision::ShapeKind::Cylinder:
    case collision::ShapeKind::Cone: {
      const collision::Pose& local = colliders.local[collider];
      const Quaternion orientation = bodies.orientation(body);
      const Vector3 axis = orientation * (local.orientation * Vector3::UnitZ());
      const Vector3 from_centre = anchor - orientation * local.position;
      const Vector3 rim = from_centre - from_centre.dot(axis) * axis;
      return {anchor - rim, rim, axis};
    }
    case collision::ShapeKind::Ellipsoid:
    case collision::ShapeKind::TaperedCapsule: {
      const collision::Pose& local = colliders.local[collider];
      const Quaternion to_shape = (bodies.orientation(body) * local.orientation).conjugate();
      const Vector3 seen = to_shape * outward;
      double radius = 0;
      if (shape.kind == collision::ShapeKind::Ellipsoid) {
        radius = curvature_radius(shape.half_extents, seen, to_shape * bodies.angular_velocity(body));
      } else {
        radius = radius_at(shape, to_shape * (anchor - bodies.orientation(body) * local.position), seen);
      }
      const Vector3 rim = radius * outward;
      return {.pivot = anchor - rim, .rim = rim};
    }
    default:
      return {.pivot = anchor};
  }
}

bool is_round(collision::ShapeKind kind) {
  return kind == collision::ShapeKind::Sphere || kind == collision::ShapeKind::Capsule || collision::is_round(kind) ||
         collision::is_smooth(kind);
}

Vector3 turned_arm(const ContactArm& arm, const Vector3& turn, const Vector3& normal) {
  const Quaternion by = rotation_by(turn);
  if (arm.axis.isZero(0)) return by * arm.pivot + arm.rim;
  const double along = arm.axis.dot(normal);
  const Vector3 without_spin = turn - turn.dot(arm.axis) * arm.axis;
  const double along_rim = without_spin.dot(normal) * along / std::max(1 - along * along, tuning::min_lean);
  // A spin goes with its axis, which it doesn't turn.
  const Vector3 on_axis = arm.pivot.dot(arm.axis) * arm.axis;
  const Quaternion tilt = rotation_by(without_spin + along_rim * arm.axis);
  return by * (arm.pivot - on_axis) + tilt * (on_axis + arm.rim);
}

double line_turn(const ContactArm& arm, const Vector3& turn, const Vector3& normal) {
  const Vector3 flat = arm.axis - arm.axis.dot(normal) * normal;
  return normal.dot(flat.cross(turn.cross(arm.axis))) / std::max(flat.squaredNorm(), tuning::min_lean);
}

double gained_along(const ContactArm& arm, const Vector3& off, const Quaternion& turn, const Vector3& normal) {
  const auto gain = [&](const Quaternion& by, const Vector3& of) { return normal.dot(by * of - of); };
  if (arm.axis.isZero(0)) return gain(turn, arm.pivot + off);
  return gain(turn, arm.pivot) + gain(swing_of(turn, arm.axis), arm.rim + off);
}

bool turns_in_step(const BodyTable& bodies, std::uint32_t body, double dt) {
  return dt * bodies.angular_velocity(body).norm() > tuning::min_turn && !bodies.ball[body];
}

Vector3 half_turn(const BodyTable& bodies, std::uint32_t body, double dt) {
  if (!turns_in_step(bodies, body, dt)) return Vector3::Zero();
  const Vector3 turn = dt * bodies.angular_velocity(body);
  const double square = turn.squaredNorm() / (tuning::known_turn * tuning::known_turn);
  return 0.5 / (1 + square * square) * turn;
}

}  // namespace atl::solver
