#include "world/body_definition.h"

#include <collision/shapes/height_field.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/triangle_mesh.h>
#include <solver/constraints/contact_inertia.h>
#include <solver/integrate/motion_locks.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "world/left_out.h"
#include "world/refuse.h"
#include "world/unit_of.h"

namespace atl {
namespace {

// Appends the colliders of a shape; `what` names it.
struct ShapeCheck {
  std::string what;
  std::vector<CheckedCollider>& colliders;

  void add(const collision::Shape& shape, std::shared_ptr<const void> geometry = {}, std::uint64_t content = 0) const {
    colliders.push_back({shape, {Vector3::Zero(), collision::Quaternion::Identity()}, std::move(geometry), content});
  }

  void check_sizes(const char* member, const Vector3& sizes) const {
    if (!sizes.allFinite() || !(sizes.minCoeff() > 0)) refuse(what + member, sizes, "three finite numbers above 0");
    for (const double size : sizes) check_positive(what + member, size);
  }

  void operator()(const Box& box) const {
    check_sizes(": Box.half_extents", box.half_extents);
    add(collision::Shape::box(box.half_extents));
  }

  void operator()(const Sphere& sphere) const {
    check_positive(what + ": Sphere.radius", sphere.radius);
    add(collision::Shape::sphere(sphere.radius));
  }

  void add_round(const char* name, const auto& solid, collision::Shape (*make)(double, double)) const {
    check_positive(what + ": " + name + ".radius", solid.radius);
    check_positive(what + ": " + name + ".half_height", solid.half_height);
    add(make(solid.radius, solid.half_height));
  }
  void operator()(const Capsule& capsule) const { add_round("Capsule", capsule, collision::Shape::capsule); }
  void operator()(const Cylinder& cylinder) const { add_round("Cylinder", cylinder, collision::Shape::cylinder); }
  void operator()(const Cone& cone) const { add_round("Cone", cone, collision::Shape::cone); }

  void operator()(const Ellipsoid& ellipsoid) const {
    check_sizes(": Ellipsoid.half_axes", ellipsoid.half_axes);
    add(collision::Shape::ellipsoid(ellipsoid.half_axes));
  }

  void operator()(const TaperedCapsule& capsule) const {
    const auto [bottom, top] = capsule.radii;
    check_positive(what + ": TaperedCapsule.radii", bottom);
    check_positive(what + ": TaperedCapsule.radii", top);
    check_positive(what + ": TaperedCapsule.half_height", capsule.half_height);
    if (!collision::parts_balls(bottom, top, capsule.half_height)) {
      refuse(what + ": TaperedCapsule.half_height", capsule.half_height,
             "more than half the difference of its radii: neither ball may hold the other");
    }
    add(collision::Shape::tapered_capsule(bottom, top, capsule.half_height));
  }

  void operator()(const HalfSpace& half_space) const {
    if (!half_space.normal.allFinite() || half_space.normal.isZero(0)) {
      refuse(what + ": HalfSpace.normal", half_space.normal, "a finite vector that is not zero");
    }
    check_number(what + ": HalfSpace.offset", half_space.offset);
    add(collision::Shape::half_space(unit_of(half_space.normal), half_space.offset));
  }

  // These have been checked as they were made.
  void operator()(const ConvexHull& hull) const {
    add(collision::Shape::convex_hull(*hull.data()), hull.data(), hull.data()->content);
  }
  void operator()(const TriangleMesh& mesh) const {
    add(collision::Shape::triangle_mesh(*mesh.data()), mesh.data(), mesh.data()->content);
  }
  void operator()(const HeightField& field) const {
    add(collision::Shape::height_field(*field.data()), field.data(), field.data()->content);
  }

  void operator()(const Compound& compound) const {
    if (compound.children.empty()) throw Error(what + ": Compound.children is empty; expected at least one child");
    for (std::size_t i = 0; i < compound.children.size(); ++i) {
      const CompoundChild& child = compound.children[i];
      const std::string name = what + ": Compound.children[" + std::to_string(i) + "]";
      check_number(name + ".position", child.position);
      check_positive(name + ".density_factor", child.density_factor);
      const Quaternion orientation = checked_orientation((name + ".orientation").c_str(), child.orientation);
      std::visit(ShapeCheck{name, colliders}, child.shape);
      if (child.material) check((name + ".material").c_str(), *child.material);
      colliders.back().local = {child.position, orientation};
      colliders.back().density_factor = child.density_factor;
      colliders.back().material = child.material;
      colliders.back().filter = child.filter;
    }
  }
};

}  // namespace

bool is_inertia(const Matrix3& inertia) {
  if (!inertia.allFinite()) return false;
  const double scale = inertia.cwiseAbs().maxCoeff();
  return (inertia - inertia.transpose()).cwiseAbs().maxCoeff() <= 1e-9 * scale &&
         Eigen::LLT<Matrix3>(inertia / scale).info() == Eigen::Success;
}

bool has_consistent_inertia(const BodyConstants& body) {
  if (!is_inertia(body.inertia) || !is_inertia(body.inverse_inertia)) return false;
  if (!(body.inertia * body.inverse_inertia).isIdentity(1e-4)) return false;
  if (!body.gyroscopic) return true;
  const Matrix3 axes = body.principal_axes.toRotationMatrix();
  return std::abs(body.principal_axes.squaredNorm() - 1) < 1e-9 &&
         body.moments.minCoeff() > 0.999 * solver::resolved_share * body.moments.maxCoeff() &&
         (axes * body.moments.asDiagonal() * axes.transpose()).isApprox(body.inertia, 1e-6);
}

namespace {

// A rigid body's principal moments can't be just any: each is at most the sum of the other two.
void check_inertia(const Matrix3& inertia) {
  const char* expected =
      "a finite, symmetric, positive definite matrix whose largest principal moment is at most the sum of the others";
  if (!is_inertia(inertia)) refuse("BodyDef.inertia", inertia, expected);
  const Vector3 moments = Eigen::SelfAdjointEigenSolver<Matrix3>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  if (moments[2] > (moments[0] + moments[1]) * (1 + 1e-9)) {
    refuse("BodyDef.inertia", inertia, expected);
  }
}

std::uint8_t bits_of(const MotionLocks& locks) {
  unsigned bits = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bits |= (locks.linear[axis] ? 1u : 0u) << axis | (locks.angular[axis] ? 8u : 0u) << axis;
  }
  return static_cast<std::uint8_t>(bits);
}

// Throws unless a body of this type may have these shapes.
void check_type(const char* field, const BodyConstants& body) {
  const char* name = massless_name(body.colliders.front().shape.kind);
  if (name == nullptr) return;
  if (body.sensor) throw Error(std::string(field) + " is a " + name + " on a sensor; expected a solid");
  if (body.type == BodyType::Dynamic) {
    throw Error(std::string(field) + " is a " + name + " on a dynamic body; expected type Static or Kinematic");
  }
}

struct PrincipalInertia {
  Vector3 moments;
  Matrix3 axes;
};

PrincipalInertia principal_inertia(const Matrix3& inertia) {
  if (inertia.isDiagonal()) return {inertia.diagonal(), Matrix3::Identity()};
  const Eigen::SelfAdjointEigenSolver<Matrix3> principal(inertia);
  Matrix3 axes = principal.eigenvectors();
  if (axes.determinant() < 0) axes = -axes;
  return {principal.eigenvalues(), axes};
}

// Throws unless single precision holds a dynamic body's mass and moments, and its inertia is a valid one.
void check_loads(const char* field, double mass, const BodyConstants& body) {
  // There is room for moments of such masses, and their inverses, up to 1e6 m and down to 1e-6 of it.
  constexpr double min_moment = 1e-36, max_moment = 1e36;
  const bool holds_mass = mass >= loads.min && mass <= loads.max;
  const Vector3 moments = body.inertia.diagonal();
  const bool holds_moments = moments.minCoeff() >= min_moment && moments.maxCoeff() <= max_moment;
  if (!holds_mass || !holds_moments || !body.inverse_inertia.allFinite()) {
    refuse(
        field, mass,
        "a mass of 1e-30 to 1e30 kg, and moments of inertia of 1e-36 to 1e36 kg m^2: single precision holds no more");
  }
}

// Sets the constants that follow from the mass properties of a dynamic body.
void take_mass(const MassProperties& properties, BodyConstants& body) {
  check_number("BodyDef: the centre of mass", properties.centre);
  body.centre = properties.centre;
  // Exactly symmetric, as files have it.
  body.inertia = properties.inertia.selfadjointView<Eigen::Upper>();
  body.inverse_mass = 1 / properties.mass;
  PrincipalInertia principal = principal_inertia(body.inertia);
  const double min = solver::resolved_share * principal.moments.maxCoeff();
  if (principal.moments.minCoeff() < min) {
    principal.moments = principal.moments.cwiseMax(min);
    const Matrix3 raised = principal.axes * principal.moments.asDiagonal() * principal.axes.transpose();
    body.inertia = raised.selfadjointView<Eigen::Upper>();
  }
  body.inverse_inertia = body.inertia.inverse();
  const double moment = body.inertia(0, 0);
  // A body that can't turn freely needs no gyroscopic torque.
  body.gyroscopic = solver::angular_locks(body.locks) == 0 &&
                    (body.inertia - moment * Matrix3::Identity()).cwiseAbs().maxCoeff() > 1e-12 * moment;
  body.principal_axes = Quaternion::Identity();
  body.moments.setZero();
  if (body.gyroscopic) {
    body.principal_axes = Quaternion(principal.axes);
    body.moments = principal.moments;
  }
  check_loads("BodyDef: mass", properties.mass, body);
}

// Mass properties from the definition of a dynamic body, whose shape has a volume.
MassProperties mass_of(const BodyDef& def) {
  MassProperties properties = mass_properties(def.shape);
  const double mass = def.mass ? *def.mass : def.density * properties.mass;
  properties.inertia = def.inertia ? *def.inertia : Matrix3(mass / properties.mass * properties.inertia);
  properties.mass = mass;
  if (def.centre_of_mass) properties.centre = *def.centre_of_mass;
  return properties;
}

void check_mass(const BodyDef& def, BodyConstants& body) {
  check_positive("BodyDef.density", def.density, loads);
  if (def.mass) check_positive("BodyDef.mass", *def.mass, loads);
  if (def.inertia && !def.mass) throw Error("BodyDef.inertia is given without a mass; expected both or neither");
  if (def.inertia) check_inertia(*def.inertia);
  if (def.centre_of_mass) {
    if (!def.inertia) throw Error("BodyDef.centre_of_mass is given without an inertia; expected both or neither");
    check_number("BodyDef.centre_of_mass", *def.centre_of_mass);
  }
  if (def.type != BodyType::Dynamic) return;
  take_mass(mass_of(def), body);
}

}  // namespace

double min_moment_of(const BodyConstants& body) {
  if (body.type != BodyType::Dynamic || solver::angular_locks(body.locks) != 0) return 0;
  double radius = std::numeric_limits<double>::infinity();
  for (const CheckedCollider& collider : body.colliders) radius = std::min(radius, collider.shape.inner_radius);
  const double min = solver::min_moment_share / body.inverse_mass * radius * radius;
  const Vector3 moments = body.gyroscopic ? body.moments : Vector3(body.inertia.diagonal());
  if (moments.minCoeff() < min) return min;
  return moments.maxCoeff() > solver::slender_ratio * moments.minCoeff() ? moments.minCoeff() : 0;
}

Quaternion checked_orientation(const char* what, const Quaternion& value) {
  if (!value.coeffs().allFinite() || !(value.coeffs().stableNorm() > 1e-6)) {
    refuse(what, value.coeffs(), "a finite quaternion that is not zero (here as x, y, z, w)");
  }
  return Quaternion(unit_of(value.coeffs()));
}

const char* name_of(collision::ShapeKind kind) {
  constexpr const char* names[] = {"Sphere",    "Capsule",      "Box",        "Cylinder",
                                   "Cone",      "ConvexHull",   "Ellipsoid",  "TaperedCapsule",
                                   "HalfSpace", "TriangleMesh", "HeightField"};
  return names[static_cast<std::size_t>(kind)];
}

const char* massless_name(collision::ShapeKind kind) {
  return collision::is_convex_solid(kind) ? nullptr : name_of(kind);
}

std::vector<CheckedCollider> checked_colliders(const char* what, const Shape& shape) {
  std::vector<CheckedCollider> colliders;
  std::visit(ShapeCheck{what, colliders}, shape);
  return colliders;
}

double max_friction(const Material& material) {
  if (!material.is_directed()) return material.friction;
  return std::max(material.friction, material.friction_across);
}

void check(const char* field, const Material& material) {
  const std::string name = field;
  check_not_negative(name + ".friction", material.friction);
  check_not_negative(name + ".friction_across", material.friction_across);
  check_finite(name + ".friction_direction", Vector3(material.friction_direction.data()));
  if (!(material.restitution >= 0 && material.restitution <= 1)) {
    refuse(name + ".restitution", material.restitution, "a number in [0, 1]");
  }
  check_not_negative(name + ".rolling_friction", material.rolling_friction);
  check_not_negative(name + ".torsional_friction", material.torsional_friction);
  const auto check_rule = [&](const char* member, CombineRule rule) {
    if (rule > CombineRule::Max) refuse(name + member, static_cast<std::uint32_t>(rule), "a value of CombineRule");
  };
  check_rule(".friction_rule", material.friction_rule);
  check_rule(".restitution_rule", material.restitution_rule);
}

namespace {

void check_sleep_and_speeds(const BodyDef& def) {
  if (def.max_speed) check_positive("BodyDef.max_speed", *def.max_speed);
  if (def.max_angular_speed) check_positive("BodyDef.max_angular_speed", *def.max_angular_speed);
  if (def.awake) return;
  if (def.type != BodyType::Dynamic) throw Error("BodyDef.awake is false; expected true of a static or kinematic body");
  if (!def.may_sleep) throw Error("BodyDef.awake is false, and may_sleep is; expected true of one of them");
  if (!def.velocity.isZero(0)) refuse("BodyDef.velocity", def.velocity, "zero for a body that is not awake");
  if (!def.angular_velocity.isZero(0)) {
    refuse("BodyDef.angular_velocity", def.angular_velocity, "zero for a body that is not awake");
  }
}

std::span<const std::uint8_t> material_numbers(const collision::Shape& shape) {
  if (shape.kind == collision::ShapeKind::Mesh) return shape.mesh->materials;
  if (shape.kind == collision::ShapeKind::HeightField) return shape.field->materials;
  return {};
}

void check_material_numbers(const std::string& field, const BodyConstants& body) {
  for (const std::uint8_t number : material_numbers(body.colliders.front().shape)) {
    if (number <= body.materials.size()) continue;
    throw Error(field + ": a triangle or cell of material " + std::to_string(number) + "; expected at most " +
                std::to_string(body.materials.size()) + ", as there are in BodyDef.materials");
  }
}

}  // namespace

CheckedBody check(const BodyDef& def) {
  CheckedBody body;
  BodyConstants& constants = body.constants;
  constants.type = def.type;
  constants.continuous = def.continuous;
  constants.sensor = def.sensor;
  constants.notices_static = def.notices_static;
  constants.notices_sensors = def.notices_sensors;
  if (def.contact_event_force) check_not_negative("BodyDef.contact_event_force", *def.contact_event_force);
  constants.contact_event_force = def.contact_event_force;
  constants.material = def.material;
  constants.materials = def.materials;
  if (def.type == BodyType::Dynamic) constants.locks = bits_of(def.locks);
  check_sleep_and_speeds(def);
  body.awake = def.awake;
  if (def.type == BodyType::Dynamic) {
    constants.may_sleep = def.may_sleep;
    constants.max_speed = def.max_speed;
    constants.max_angular_speed = def.max_angular_speed;
  }
  constants.gravity_scale = def.gravity_scale;
  constants.linear_damping = def.linear_damping;
  constants.angular_damping = def.angular_damping;
  constants.colliders = checked_colliders("BodyDef.shape", def.shape);
  check_type("BodyDef.shape", constants);
  check_finite("BodyDef.position", def.position);
  check_finite("BodyDef.velocity", def.velocity);
  check_finite("BodyDef.angular_velocity", def.angular_velocity);
  body.position = def.position;
  body.velocity = solver::without(solver::linear_locks(constants.locks), def.velocity);
  body.angular_velocity = solver::without(solver::angular_locks(constants.locks), def.angular_velocity);
  body.surface = {def.surface_velocity, def.surface_angular_velocity};
  body.filter = def.filter;
  check_name("BodyDef.name", def.name);
  body.name = def.name;
  body.user_data = def.user_data;
  body.orientation = checked_orientation("BodyDef.orientation", def.orientation);
  if (def.type == BodyType::Static) {
    if (!def.velocity.isZero(0)) refuse("BodyDef.velocity", def.velocity, "zero for a static body");
    if (!def.angular_velocity.isZero(0)) {
      refuse("BodyDef.angular_velocity", def.angular_velocity, "zero for a static body");
    }
  }
  check("BodyDef.material", def.material);
  for (std::size_t i = 0; i < def.materials.size(); ++i) {
    check(("BodyDef.materials[" + std::to_string(i) + "]").c_str(), def.materials[i]);
  }
  check_material_numbers("BodyDef.shape", constants);
  check_finite("BodyDef.surface_velocity", def.surface_velocity);
  check_finite("BodyDef.surface_angular_velocity", def.surface_angular_velocity);
  check_number("BodyDef.gravity_scale", def.gravity_scale);
  check_not_negative("BodyDef.linear_damping", def.linear_damping);
  check_not_negative("BodyDef.angular_damping", def.angular_damping);
  check_mass(def, constants);
  check_built_for(constants);
  check_built_for_surface("BodyDef.surface_velocity", def.surface_velocity);
  check_built_for_surface("BodyDef.surface_angular_velocity", def.surface_angular_velocity);
  return body;
}

MotionLocks locks_of(std::uint8_t bits) {
  MotionLocks locks;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    locks.linear[axis] = (bits >> axis & 1) != 0;
    locks.angular[axis] = (bits >> axis & 8) != 0;
  }
  return locks;
}

namespace {

ConvexShape solid_of(const CheckedCollider& collider) {
  const collision::Shape& shape = collider.shape;
  switch (shape.kind) {
    case collision::ShapeKind::Sphere:
      return Sphere{shape.radius};
    case collision::ShapeKind::Capsule:
      return Capsule{shape.radius, shape.half_height};
    case collision::ShapeKind::Cylinder:
      return Cylinder{shape.radius, shape.half_height};
    case collision::ShapeKind::Cone:
      return Cone{shape.radius, shape.half_height};
    case collision::ShapeKind::Ellipsoid:
      return Ellipsoid{shape.half_extents};
    case collision::ShapeKind::TaperedCapsule:
      return TaperedCapsule{{shape.radius, shape.top_radius}, shape.half_height};
    case collision::ShapeKind::Hull:
      return ConvexHull(std::static_pointer_cast<const collision::Hull>(collider.geometry));
    default:
      return Box{shape.half_extents};
  }
}

bool is_plain(const CheckedCollider& collider) {
  return collider.local.position.isZero(0) && collider.local.orientation.vec().isZero(0) &&
         collider.density_factor == 1 && !collider.material && !collider.filter;
}

}  // namespace

Shape shape_of(const BodyConstants& body) {
  const CheckedCollider& first = body.colliders.front();
  switch (first.shape.kind) {
    case collision::ShapeKind::HalfSpace:
      return HalfSpace{first.shape.normal, first.shape.offset};
    case collision::ShapeKind::Mesh:
      return TriangleMesh(std::static_pointer_cast<const collision::TriangleMesh>(first.geometry));
    case collision::ShapeKind::HeightField:
      return HeightField(std::static_pointer_cast<const collision::HeightField>(first.geometry));
    default:
      break;
  }
  if (body.colliders.size() == 1 && is_plain(first)) {
    return std::visit([](const auto& solid) -> Shape { return solid; }, solid_of(first));
  }
  Compound compound;
  for (const CheckedCollider& collider : body.colliders) {
    compound.children.push_back({solid_of(collider), collider.local.position, collider.local.orientation,
                                 collider.density_factor, collider.material, collider.filter});
  }
  return compound;
}

void give_shape(const char* field, const Shape& shape, BodyConstants& body) {
  body.colliders = checked_colliders(field, shape);
  check_type(field, body);
  check_material_numbers(field, body);
  if (body.type != BodyType::Dynamic) return;
  MassProperties properties = mass_properties(shape);
  const double factor = 1 / (body.inverse_mass * properties.mass);
  properties.inertia *= factor;
  properties.mass = 1 / body.inverse_mass;
  take_mass(properties, body);
}

void give_mass(const char* field, double mass, BodyConstants& body) {
  const double factor = mass * body.inverse_mass;
  body.inverse_mass = 1 / mass;
  body.inertia *= factor;
  body.inverse_inertia /= factor;
  body.moments *= factor;
  check_loads(field, mass, body);
}

bool has_own_materials(const BodyConstants& body) {
  return !body.materials.empty() ||
         std::ranges::any_of(body.colliders, [](const CheckedCollider& c) { return c.material.has_value(); });
}

bool has_own_filters(const BodyConstants& body) {
  return std::ranges::any_of(body.colliders, [](const CheckedCollider& c) { return c.filter.has_value(); });
}

MassProperties body_mass(const BodyDef& def) {
  if (def.type != BodyType::Dynamic) {
    throw Error("body_mass: BodyDef.type is Static or Kinematic; expected Dynamic: others have no finite mass");
  }
  check(def);
  return mass_of(def);
}

}  // namespace atl
