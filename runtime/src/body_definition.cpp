#include "body_definition.h"

#include <atoll/error.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <sstream>

namespace atl {
namespace {

template <typename Value>
std::string text(const Value& value) {
  std::ostringstream out;
  if constexpr (std::is_arithmetic_v<Value>) {
    out << value;
  } else {
    const Eigen::IOFormat flat(Eigen::StreamPrecision, Eigen::DontAlignCols, ", ", "; ", "", "", "(", ")");
    out << value.reshaped(1, value.size()).format(flat);
  }
  return out.str();
}

template <typename Value>
[[noreturn]] void refuse(const std::string& field, const Value& found, const char* expected) {
  throw Error(field + " is " + text(found) + "; expected " + expected);
}

void check_positive(const std::string& field, double value) {
  if (!(std::isfinite(value) && value > 0)) refuse(field, value, "a finite number above 0");
}

void check_not_negative(const std::string& field, double value) {
  if (!(std::isfinite(value) && value >= 0)) refuse(field, value, "a finite number not below 0");
}

collision::Shape check_shape(const Box& box) {
  if (!box.half_extents.allFinite() || !(box.half_extents.minCoeff() > 0)) {
    refuse("BodyDef.shape: Box.half_extents", box.half_extents, "three finite numbers above 0");
  }
  return collision::Shape::box(box.half_extents);
}

collision::Shape check_shape(const Sphere& sphere) {
  check_positive("BodyDef.shape: Sphere.radius", sphere.radius);
  return collision::Shape::sphere(sphere.radius);
}

collision::Shape check_shape(const HalfSpace& half_space) {
  const double length = half_space.normal.norm();
  if (!half_space.normal.allFinite() || !(length > 0)) {
    refuse("BodyDef.shape: HalfSpace.normal", half_space.normal, "a finite vector that is not zero");
  }
  if (!std::isfinite(half_space.offset)) {
    refuse("BodyDef.shape: HalfSpace.offset", half_space.offset, "a finite number");
  }
  return collision::Shape::half_space(half_space.normal / length, half_space.offset);
}

// A rigid body's principal moments can't be just any: each is at most the sum of the other two.
void check_inertia(const Matrix3& inertia) {
  const char* expected =
      "a finite, symmetric, positive definite matrix whose largest principal moment is at most the sum of the others";
  const double scale = inertia.cwiseAbs().maxCoeff();
  if (!inertia.allFinite() || (inertia - inertia.transpose()).cwiseAbs().maxCoeff() > 1e-9 * scale) {
    refuse("BodyDef.inertia", inertia, expected);
  }
  const Vector3 moments = Eigen::SelfAdjointEigenSolver<Matrix3>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  if (!(moments[0] > 0) || moments[2] > (moments[0] + moments[1]) * (1 + 1e-9)) {
    refuse("BodyDef.inertia", inertia, expected);
  }
}

void check_mass(const BodyDef& def, CheckedBody& body) {
  check_positive("BodyDef.density", def.density);
  if (def.mass) check_positive("BodyDef.mass", *def.mass);
  if (def.inertia && !def.mass) throw Error("BodyDef.inertia is given without a mass; expected both or neither");
  if (def.inertia) check_inertia(*def.inertia);
  if (def.type != BodyType::Dynamic) return;
  if (body.shape.kind == collision::ShapeKind::HalfSpace) {
    throw Error("BodyDef.shape is a HalfSpace on a dynamic body; expected type Static or Kinematic");
  }
  const double mass = def.mass ? *def.mass : def.density * collision::volume(body.shape);
  body.inertia = def.inertia ? *def.inertia : Matrix3(mass * collision::unit_inertia(body.shape));
  body.inverse_mass = 1 / mass;
  body.inverse_inertia = body.inertia.inverse();
  if (!std::isfinite(body.inverse_mass) || !(body.inverse_mass > 0) || !body.inverse_inertia.allFinite()) {
    refuse("BodyDef: mass", mass, "a mass and inertia whose inverses are finite");
  }
  const double moment = body.inertia(0, 0);
  body.gyroscopic = (body.inertia - moment * Matrix3::Identity()).cwiseAbs().maxCoeff() > 1e-12 * moment;
}

}  // namespace

void check_finite(const char* what, const Vector3& value) {
  if (!value.allFinite()) refuse(what, value, "three finite numbers");
}

Quaternion checked_orientation(const char* what, const Quaternion& value) {
  if (!value.coeffs().allFinite() || !(value.norm() > 1e-6)) {
    refuse(what, value.coeffs(), "a finite quaternion that is not zero (here as x, y, z, w)");
  }
  return value.normalized();
}

CheckedBody check(const BodyDef& def) {
  CheckedBody body;
  body.shape = std::visit([](const auto& shape) { return check_shape(shape); }, def.shape);
  check_finite("BodyDef.position", def.position);
  check_finite("BodyDef.velocity", def.velocity);
  check_finite("BodyDef.angular_velocity", def.angular_velocity);
  body.position = def.position;
  body.orientation = checked_orientation("BodyDef.orientation", def.orientation);
  if (def.type == BodyType::Static) {
    if (!def.velocity.isZero(0)) refuse("BodyDef.velocity", def.velocity, "zero for a static body");
    if (!def.angular_velocity.isZero(0)) {
      refuse("BodyDef.angular_velocity", def.angular_velocity, "zero for a static body");
    }
  }
  check_not_negative("BodyDef.material.friction", def.material.friction);
  if (!(def.material.restitution >= 0 && def.material.restitution <= 1)) {
    refuse("BodyDef.material.restitution", def.material.restitution, "a number in [0, 1]");
  }
  if (!std::isfinite(def.gravity_scale)) refuse("BodyDef.gravity_scale", def.gravity_scale, "a finite number");
  check_not_negative("BodyDef.linear_damping", def.linear_damping);
  check_not_negative("BodyDef.angular_damping", def.angular_damping);
  check_mass(def, body);
  return body;
}

}  // namespace atl
