#include <atoll/error.h>
#include <solver/integrate/motion_locks.h>

#include <algorithm>
#include <cmath>

#include "state/world_definition.h"
#include "world/body_definition.h"
#include "world/refuse.h"

namespace atl {
namespace {

using collision::Shape;
using collision::ShapeKind;

bool is_size(double value) { return value >= numbers.min && value <= numbers.max; }
bool are_sizes(const Vector3& values) { return is_size(values.x()) && is_size(values.y()) && is_size(values.z()); }
bool is_number(double value) { return std::abs(value) <= numbers.max; }
// maxCoeff() may pass over what is not a number.
bool is_number(const Vector3& value) { return is_number(value.x()) && is_number(value.y()) && is_number(value.z()); }
bool is_not_negative(double value) { return value >= 0 && value <= numbers.max; }
bool is_unit(double squared_length) { return std::abs(squared_length - 1) < 1e-9; }

bool is_valid(const Material& material) {
  return is_not_negative(material.friction) && is_not_negative(material.friction_across) &&
         Vector3(material.friction_direction.data()).allFinite() && material.restitution >= 0 &&
         material.restitution <= 1 && is_not_negative(material.rolling_friction) &&
         is_not_negative(material.torsional_friction) && material.friction_rule <= CombineRule::Max &&
         material.restitution_rule <= CombineRule::Max;
}

bool are_same(const Shape& a, const Shape& b) {
  return a.half_extents == b.half_extents && a.radius == b.radius && a.top_radius == b.top_radius &&
         a.half_height == b.half_height && a.normal == b.normal && a.offset == b.offset &&
         a.bounding_radius == b.bounding_radius && a.inner_radius == b.inner_radius;
}

// True if its sizes are valid, and everything else follows from them.
bool is_valid(const Shape& shape) {
  const auto is_round = [&](Shape (*make)(double, double)) {
    return is_size(shape.radius) && is_size(shape.half_height) &&
           are_same(shape, make(shape.radius, shape.half_height));
  };
  switch (shape.kind) {
    case ShapeKind::Sphere:
      return is_size(shape.radius) && are_same(shape, Shape::sphere(shape.radius));
    case ShapeKind::Capsule:
      return is_round(Shape::capsule);
    case ShapeKind::Cylinder:
      return is_round(Shape::cylinder);
    case ShapeKind::Cone:
      return is_round(Shape::cone);
    case ShapeKind::Box:
      return are_sizes(shape.half_extents) && are_same(shape, Shape::box(shape.half_extents));
    case ShapeKind::Ellipsoid:
      return are_sizes(shape.half_extents) && are_same(shape, Shape::ellipsoid(shape.half_extents));
    case ShapeKind::TaperedCapsule:
      return is_size(shape.radius) && is_size(shape.top_radius) && is_size(shape.half_height) &&
             collision::parts_balls(shape.radius, shape.top_radius, shape.half_height) &&
             are_same(shape, Shape::tapered_capsule(shape.radius, shape.top_radius, shape.half_height));
    case ShapeKind::HalfSpace:
      return is_unit(shape.normal.squaredNorm()) && is_number(shape.offset) &&
             are_same(shape, Shape::half_space(shape.normal, shape.offset));
    default:  // these two are made anew with the geometry
      return shape.bounding_radius > 0 && shape.inner_radius > 0;
  }
}

bool is_valid(const CheckedCollider& collider) {
  return is_valid(collider.shape) && is_number(collider.local.position) &&
         is_unit(collider.local.orientation.squaredNorm()) && collider.density_factor >= numbers.min &&
         collider.density_factor <= numbers.max && (!collider.material || is_valid(*collider.material));
}

bool has_valid_mass(const BodyConstants& body) {
  if (body.type != BodyType::Dynamic) {
    return body.inverse_mass == 0 && body.inverse_inertia.isZero(0) && !body.gyroscopic;
  }
  constexpr double rounding = 1e-9;
  const double mass = 1 / body.inverse_mass;
  if (!(mass >= loads.min * (1 - rounding) && mass <= loads.max * (1 + rounding))) return false;
  if (body.gyroscopic && solver::angular_locks(body.locks) != 0) return false;  // it can't turn freely
  return has_consistent_inertia(body);
}

}  // namespace

const char* constants_fault(const BodyConstants& body) {
  if (!is_valid(body.material) ||
      !std::ranges::all_of(body.materials, [](const Material& each) { return is_valid(each); }) ||
      !is_number(body.gravity_scale) || !is_not_negative(body.linear_damping) ||
      !is_not_negative(body.angular_damping)) {
    return "a body of an invalid material, gravity scale or damping";
  }
  if (body.contact_event_force && !is_not_negative(*body.contact_event_force)) return "a body that asks for no force";
  if (!is_number(body.centre)) return "a body without a valid centre of mass";
  for (const CheckedCollider& collider : body.colliders) {
    if (!is_valid(collider)) return "a shape with invalid numbers";
    if (massless_name(collider.shape.kind) == nullptr) continue;
    if (body.type == BodyType::Dynamic || body.sensor || body.colliders.size() > 1) {
      return "a surface or half-space where there can be none";
    }
  }
  if (!has_valid_mass(body)) return "a body without a valid mass and inertia";
  return nullptr;
}

}  // namespace atl
