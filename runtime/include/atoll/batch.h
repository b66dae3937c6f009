#pragma once

#include <atoll/scene.h>
#include <atoll/types.h>
#include <atoll/world.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace atl {

/// Many worlds of one scene, stepped side by side: for parameter studies, sampling and learning. Each is a World with
/// one thread of its own, and comes to the bits that it comes to by itself: these depend neither on its place, nor on
/// how many there are, nor on the threads. Geometry is shared.
///
/// Arrays over all worlds have one column per body or joint: world after world, and within a world in the scene's
/// order. Bodies and joints that are added to single worlds are in no array; columns of removed ones are zero. Worlds
/// are named by their place; an empty list of places stands for all worlds. Calls throw Error on a place that doesn't
/// exist, on an array of the wrong size, and where World's calls throw it. If World's calls throw for several worlds,
/// the first one's Error is passed on; the other worlds are still done.
///
/// One thread at a time may use a batch.
class Batch {
 public:
  /// `threads`: workers, in [1, 1024]; 0 for as many as the machine has. Throws Error on these, if `worlds` is 0 or
  /// more than there is memory for, and SceneError as build_scene() does.
  Batch(const Scene& scene, std::size_t worlds, int threads = 0);
  ~Batch();
  Batch(Batch&&) noexcept;
  Batch& operator=(Batch&&) noexcept;

  std::size_t size() const;  ///< worlds
  int threads() const;
  const Scene& scene() const;
  /// The same in all worlds, in the scene's order.
  const std::vector<BodyId>& bodies() const;
  const std::vector<JointId>& joints() const;

  /// To ask, or to change by any call: another mass, friction or shape of a body, gravity, settings. It stays where it
  /// is: to move it, or another world there, throws Error.
  World& world(std::size_t place);
  const World& world(std::size_t place) const;
  /// Calls a function for each of these worlds, on the batch's threads, several at a time.
  void for_each(const std::function<void(World&, std::size_t place)>& function,
                std::span<const std::size_t> places = {});

  /// So many steps of dt seconds, in [1e-12, 1], of these worlds, under the scene's constant forces. Each makes them in
  /// a row, while it is in cache: many at once cost less than one by one.
  void step(double dt, int count = 1, std::span<const std::size_t> places = {});

  /// Puts these back to where they started, or to where save_start() was called last: all of their state, with masses
  /// and whatever else was changed.
  void reset(std::span<const std::size_t> places = {});
  /// Lets these start from where they are now.
  void save_start(std::span<const std::size_t> places = {});

  enum class Column {
    Positions,             ///< 3 rows: m, of centres of mass
    Origins,               ///< 3 rows: m, of the bodies' frames
    Orientations,          ///< 4 rows: x, y, z, w
    Velocities,            ///< 3 rows: m/s
    AngularVelocities,     ///< 3 rows: rad/s
    Accelerations,         ///< 3 rows: m/s^2; this and the next as World::accelerations()
    AngularAccelerations,  ///< 3 rows: rad/s^2
    ContactForces,         ///< 3 rows: N; this and the next as World::contact_wrench()
    ContactTorques,        ///< 3 rows: N m
    JointPositions,        ///< 6 rows, of joints: m or rad, of the coordinates as JointState has them
    JointSpeeds,           ///< 6 rows, of joints: m/s or rad/s
    JointMotors,           ///< 6 rows, of joints: N or N m, what motors and servos exert: JointState::motor
    JointForces,           ///< 3 rows, of joints: N; this and the next as JointState has them
    JointTorques,          ///< 3 rows, of joints: N m
  };
  static std::size_t rows_of(Column column);
  /// Reads a column for all bodies, or joints, of all worlds: rows_of(column) numbers each, one after the other.
  void read(Column column, std::span<double> numbers) const;
  friend void read_columns(const Batch& batch, std::span<const Column> columns,
                           std::span<const std::span<double>> numbers, std::span<const std::size_t> places);

  // 3 * bodies().size() numbers a world (orientations 4), worlds in the order of `places`. As World's calls, but for
  // velocities of static bodies and forces on what isn't dynamic, which are passed over.
  void set_poses(std::span<const double> origins, std::span<const double> orientations,
                 std::span<const std::size_t> places = {});
  void set_velocities(std::span<const double> linear, std::span<const double> angular,
                      std::span<const std::size_t> places = {});
  void apply_forces(std::span<const double> forces, std::span<const double> torques,
                    std::span<const std::size_t> places = {});

  // Sets one joint, given by its place in joints(): one number per world.
  void set_motor_speeds(std::size_t joint, std::span<const double> speeds, std::size_t coordinate = 0,
                        std::span<const std::size_t> places = {});
  void set_servo_targets(std::size_t joint, std::span<const double> targets, std::size_t coordinate = 0,
                         std::span<const std::size_t> places = {});
  /// Position (m or rad) and speed (m/s or rad/s) of one coordinate in all worlds: one number per world each.
  void read_joint(std::size_t joint, std::span<double> positions, std::span<double> speeds,
                  std::size_t coordinate = 0) const;

  /// World::state_hash() of all worlds.
  std::vector<std::uint64_t> hashes() const;
  /// How many bodies of each world are in quarantine.
  std::vector<std::size_t> quarantined() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Changes that differ from world to world, made as World's calls make them: one number per world, in the order of
// `places`. A body is given by its place in bodies().

/// m/s^2, 3 numbers a world.
void set_gravities(Batch& batch, std::span<const double> gravities, std::span<const std::size_t> places = {});

/// Numbers of bodies that may differ from world to world: as BodyDef, Material and the shape have them. Sizes are set
/// as by World::set_shape(): the mass stays. Extents are those of a Box, or the half axes of an Ellipsoid.
enum class BodyNumber {
  Mass,
  Friction,
  Restitution,
  RollingFriction,
  TorsionalFriction,
  GravityScale,
  LinearDamping,
  AngularDamping,
  Radius,
  HalfHeight,
  HalfExtentX,
  HalfExtentY,
  HalfExtentZ,
};
/// Numbers along a coordinate of a joint, as JointAxis has them, likewise. It must have the servo, motor or spring.
enum class JointNumber {
  ServoStiffness,
  ServoDamping,
  MaxForce,
  SpringStiffness,
  SpringDamping,
  Friction,
  Armature,
};

/// A number for each of these bodies, world by world. Surfaces: of the body's own material, as shapes that have a
/// material of their own keep it. Masses are those of dynamic bodies.
void set_numbers(Batch& batch, BodyNumber what, std::span<const std::size_t> bodies, std::span<const double> numbers,
                 std::span<const std::size_t> places = {});
/// A number for each of these joints, given by their places in joints(), world by world.
void set_numbers(Batch& batch, JointNumber what, std::span<const std::size_t> joints, std::span<const double> numbers,
                 std::size_t coordinate = 0, std::span<const std::size_t> places = {});

/// kg, a number a world.
inline void set_masses(Batch& batch, std::size_t body, std::span<const double> masses,
                       std::span<const std::size_t> places = {}) {
  set_numbers(batch, BodyNumber::Mass, {&body, 1}, masses, places);
}
/// Sets the friction of the body's own material, one number per world.
inline void set_frictions(Batch& batch, std::size_t body, std::span<const double> frictions,
                          std::span<const std::size_t> places = {}) {
  set_numbers(batch, BodyNumber::Friction, {&body, 1}, frictions, places);
}

/// Reads several columns of these worlds, or all, in one pass over them, for little more than one takes: a span each,
/// with the worlds in the order of places, as Batch::read() has them.
void read_columns(const Batch& batch, std::span<const Batch::Column> columns,
                  std::span<const std::span<double>> numbers, std::span<const std::size_t> places = {});

/// True if a column belongs to joints, false if to bodies.
constexpr bool is_of_joints(Batch::Column column) { return column >= Batch::Column::JointPositions; }

inline std::size_t Batch::rows_of(Column column) {
  const bool by_coordinate = is_of_joints(column) && column < Column::JointForces;
  return by_coordinate ? 6 : column == Column::Orientations ? 4 : 3;
}

}  // namespace atl
