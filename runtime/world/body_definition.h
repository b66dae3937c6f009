#pragma once

#include <atoll/body.h>
#include <collision/shapes/hull.h>
#include <solver/integrate/body_table.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace atl {

/// One convex solid, half-space or surface of a body.
struct CheckedCollider {
  collision::Shape shape;
  collision::Pose local;                 // in the body's frame
  std::shared_ptr<const void> geometry;  // what the shape points to, if anything
  std::uint64_t content = 0;             // hash of that
  double density_factor = 1;             // as CompoundChild's
  // Set for a compound's child that has its own material or filter.
  std::optional<Material> material = {};
  std::optional<CollisionFilter> filter = {};

  collision::PlacedShape in_frame_of(const Vector3& centre) const {
    collision::PlacedShape placed = collision::centred(shape, local);
    placed.pose.position -= centre;
    return placed;
  }
};

/// The properties of a body that never change, in the terms of the layers below.
struct BodyConstants {
  BodyType type = BodyType::Static;
  bool continuous = false;
  bool sensor = false;
  bool notices_static = false;
  bool notices_sensors = false;
  std::optional<double> contact_event_force = {};  // N
  Material material = {};
  std::vector<Material> materials = {};  // of numbers from 1 on, of a surface's triangles
  std::uint8_t locks = 0;                // see solver/integrate/motion_locks.h; 0 unless dynamic
  // Dynamic bodies alone have these three.
  bool may_sleep = true;
  std::optional<double> max_speed = {};          // m/s
  std::optional<double> max_angular_speed = {};  // rad/s
  double gravity_scale = 1;
  double linear_damping = 0;               // 1/s
  double angular_damping = 0;              // 1/s
  std::vector<CheckedCollider> colliders;  // one for each child of a compound
  Vector3 centre = Vector3::Zero();        // of mass, body frame
  double inverse_mass = 0;
  Matrix3 inertia = Matrix3::Zero();
  Matrix3 inverse_inertia = Matrix3::Zero();
  bool gyroscopic = false;
  // For gyroscopic bodies: the axes, in the body's frame, in which the inertia is diagonal, and the moments about them.
  Quaternion principal_axes = Quaternion::Identity();
  Vector3 moments = Vector3::Zero();
};

/// A definition that has passed all checks.
struct CheckedBody {
  BodyConstants constants;
  Vector3 position;        // of the body frame
  Quaternion orientation;  // unit
  Vector3 velocity = Vector3::Zero();
  Vector3 angular_velocity = Vector3::Zero();
  solver::SurfaceMotion surface = {};
  CollisionFilter filter = {};
  bool awake = true;
  std::string name;
  std::uint64_t user_data = 0;
};

/// Calls visit(material) for those of all colliders.
template <typename Visit>
void for_each_material(const BodyConstants& body, const Visit& visit) {
  for (const CheckedCollider& collider : body.colliders) visit(collider.material ? *collider.material : body.material);
  for (const Material& material : body.materials) visit(material);
}
/// Coulomb coefficient, in the direction in which it is largest.
double max_friction(const Material& material);
bool has_own_materials(const BodyConstants& body);
bool has_own_filters(const BodyConstants& body);

/// kg m^2: what contacts see of lesser moments, see solver/contact_inertia.h. 0 if the body has none, as any solid of
/// uniform density.
double min_moment_of(const BodyConstants& body);

/// Throws Error naming the field, the value and what was expected.
CheckedBody check(const BodyDef& def);

/// The shape that these colliders come from; of a compound of one that is as good as its child, the child.
Shape shape_of(const BodyConstants& body);
MotionLocks locks_of(std::uint8_t bits);

/// `field` names the material.
void check(const char* field, const Material& material);

/// True if an inertia is finite, symmetric, and positive definite to the rounding of its factor. Definitions, files and
/// snapshots are all held to this one test.
bool is_inertia(const Matrix3& inertia);
/// True if a dynamic body's inertia, its inverse and its principal axes belong together.
bool has_consistent_inertia(const BodyConstants& body);

/// Gives a body other shapes at the mass that it has, and what follows from both. Throws Error that names `field` if
/// they can't be a body's of its type.
void give_shape(const char* field, const Shape& shape, BodyConstants& body);

/// Gives a dynamic body another mass, and moments in proportion. Throws Error that names `field` if single precision
/// doesn't hold them.
void give_mass(const char* field, double mass, BodyConstants& body);

// For the calls that change a body later, and for queries. Each throws as check() does; `what` names the argument.
Quaternion checked_orientation(const char* what, const Quaternion& value);
/// The public name of a shape kind.
const char* name_of(collision::ShapeKind kind);
/// The same of one that has no volume, and so no finite mass; null for solids.
const char* massless_name(collision::ShapeKind kind);

std::vector<CheckedCollider> checked_colliders(const char* what, const Shape& shape);

}  // namespace atl
