#pragma once

#include <atoll/material.h>
#include <atoll/shapes.h>
#include <atoll/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace atl {

enum class BodyType {
  Static,     ///< never moves, infinite mass
  Kinematic,  ///< moves at the velocity it is given, infinite mass
  Dynamic,    ///< moves under forces and contacts
};

/// An axis of the world.
enum class Axis : std::uint8_t { X, Y, Z };

/// Which motions along and about the world's axes x, y and z a dynamic body is without, whatever acts on it. Forces,
/// contacts, joints and velocities that are asked for lose their part along what is locked, and nothing else; poses may
/// be set to any. A locked body turns about its free axes as one whose inertia is that about these, without gyroscopic
/// torque.
struct MotionLocks {
  std::array<bool, 3> linear = {};
  std::array<bool, 3> angular = {};

  /// Keeps a body in its plane across an axis: it neither moves along that axis nor turns about the two others.
  static constexpr MotionLocks plane(Axis across) {
    MotionLocks locks;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool is_normal = axis == static_cast<std::size_t>(across);
      locks.linear[axis] = is_normal;
      locks.angular[axis] = !is_normal;
    }
    return locks;
  }
  bool operator==(const MotionLocks&) const = default;
};

/// Everything a body starts with. All values must be finite.
struct BodyDef {
  BodyType type = BodyType::Dynamic;
  Shape shape = Box{};
  Vector3 position = Vector3::Zero();               ///< m, world frame, of the body frame's origin
  Quaternion orientation = Quaternion::Identity();  ///< normalised on use, must not be zero
  Vector3 velocity = Vector3::Zero();               ///< m/s, world frame, of the centre of mass; zero for static bodies
  Vector3 angular_velocity = Vector3::Zero();       ///< rad/s, world frame; zero for static bodies
  double density = 1000;                            ///< kg/m^3, > 0; used where mass is not given
  std::optional<double> mass = {};                  ///< kg, > 0; inertia follows from shape and mass
  /// kg m^2, body frame, about the centre of mass: symmetric, positive definite, principal moments
  /// obeying the triangle inequality. Needs mass. Moments below a tenth of the mass times the square of the shape's
  /// inner radius, which no solid of one density has, count as that much where the body touches others, but for islands
  /// with joints. Those below a millionth of the largest count as that much everywhere: solvers resolve no less.
  std::optional<Matrix3> inertia = {};
  /// m, body frame: where its weight is, whatever its shape. Needs inertia. The shape's own, if left out.
  std::optional<Vector3> centre_of_mass = {};
  Material material = {};
  /// Materials of the triangles of a TriangleMesh, or cells of a HeightField, that have numbers: number k > 0 stands
  /// for materials[k - 1]. A contact has triangles of one material, so what lies across a border has a contact on each
  /// side.
  std::vector<Material> materials = {};
  /// m/s, body frame: how fast the surface runs along the body, as a conveyor's belt. Friction sees its part in the
  /// tangent plane of a contact; the body itself stays.
  Vector3 surface_velocity = Vector3::Zero();
  /// rad/s, body frame, about its origin: how fast the surface turns on the body, as a turntable. It adds its cross
  /// product with a contact's place to the surface's velocity there, and itself to what torsional and rolling friction
  /// see.
  Vector3 surface_angular_velocity = Vector3::Zero();
  double gravity_scale = 1;    ///< multiplies the world's gravity
  double linear_damping = 0;   ///< 1/s, >= 0: v' = -c v
  double angular_damping = 0;  ///< 1/s, >= 0: w' = -c w
  MotionLocks locks = {};      ///< of dynamic bodies
  /// m/s and rad/s, > 0, of dynamic bodies: no faster as a step begins and as it ends. Within a step, forces and
  /// contacts may add to it.
  std::optional<double> max_speed = {};
  std::optional<double> max_angular_speed = {};
  /// False: with Settings::sleeping, a dynamic body at rest is asleep as it is added, until something wakes it.
  bool awake = true;
  bool may_sleep = true;  ///< false: it stays awake, and so does what it touches or is joined to
  CollisionFilter filter = {};
  /// Looks for what the body may have passed through after every step in which it moved at all. Without it that is
  /// done in steps in which it moved farther than three quarters of its inner radius. It ends the step where it first
  /// met something that no contact had foreseen; what it touched already it slides along. Bodies that joints connect
  /// end it together, all where they were at that time, so that no joint is torn; as that costs all of them the rest of
  /// the step, one that doesn't ask for it by this is stopped only by what would get deeper into it than half its inner
  /// radius. In a build without ATOLL_WITH_CONTINUOUS nothing is swept, and true throws.
  bool continuous = false;
  /// Touches nothing, and tells which bodies are in it instead: World::sensor_events() and World::bodies_in(). Its
  /// shape is a solid. Queries pass it by unless they ask for sensors. One that is `continuous` also tells of what is
  /// in it neither as a step begins nor as it ends, but passes through, as both move and turn evenly from where they
  /// were to where they are.
  bool sensor = false;
  bool notices_static = false;   ///< a sensor: static bodies, too
  bool notices_sensors = false;  ///< a sensor: other sensors, too, which need not notice it
  /// N, >= 0: with Settings::contact_events, these tell of contacts of this body that go on, too, while they carry at
  /// least this. Of two bodies' values and Settings::contact_event_force, the least counts.
  std::optional<double> contact_event_force = {};
  /// For people, and World::find_body(): UTF-8 without control characters. Bodies may share one.
  std::string name = {};
  std::uint64_t user_data = 0;  ///< yours: World keeps it, and saves it with the body, and never looks at it
};

/// Mass, centre of mass and inertia of a body, as a world takes them from its definition. Throws Error unless the body
/// is dynamic and its definition usable.
MassProperties body_mass(const BodyDef& def);

}  // namespace atl
