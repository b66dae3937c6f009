#pragma once

#include <jobs/append.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>
#include <jobs/shared_values.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace atl::solver {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

enum class Mobility : std::uint8_t { Fixed, Kinematic, Dynamic };

/// How a surface runs along its body, which stays. Body frame, about its origin.
struct SurfaceMotion {
  Vector3 velocity = Vector3::Zero();          ///< m/s, of what is at the origin
  Vector3 angular_velocity = Vector3::Zero();  ///< rad/s

  bool is_zero() const { return velocity.isZero(0) && angular_velocity.isZero(0); }
};

/// The properties of a body's surface beyond plain friction. See atoll/body.h.
struct Surface {
  SurfaceMotion motion;
  Vector3 centre = Vector3::Zero();  ///< m, body frame, of mass
  double rolling_friction = 0;       ///< m
  double torsional_friction = 0;     ///< m
  bool uneven = false;               ///< friction may depend on the direction

  bool is_plain() const { return motion.is_zero() && rolling_friction == 0 && torsional_friction == 0 && !uneven; }
};

/// State and mass properties of all bodies of a world as flat arrays, one entry a body index. It lasts from step to
/// step; the data that a step computes with are made from it (see SolverBodies). Large values that never change and are
/// alike for many bodies, above all for fixed ones, are stored once.
struct BodyTable {
  jobs::CompactArray<double> positions;           ///< 3 a body, m
  jobs::CompactArray<double> orientations;        ///< 4 a body: x, y, z, w
  jobs::CompactArray<double> velocities;          ///< 3 a body, m/s
  jobs::CompactArray<double> angular_velocities;  ///< 3 a body, rad/s
  jobs::CompactArray<double> forces;              ///< 3 a body, N, for the next step only; empty until the first push
  jobs::CompactArray<double> torques;             ///< 3 a body, N m, likewise

  jobs::CompactArray<Mobility> mobility;
  jobs::CompactArray<double> inverse_mass;      ///< 1/kg; 0 unless dynamic
  jobs::CompactArray<std::uint8_t> gyroscopic;  ///< 1 if the inertia depends on the direction
  /// kg m^2, body frame; zero unless dynamic
  jobs::SharedValues<Matrix3> inertia = jobs::SharedValues<Matrix3>(Matrix3::Zero());
  /// Body frame; zero unless dynamic.
  jobs::SharedValues<Matrix3> inverse_inertia = jobs::SharedValues<Matrix3>(Matrix3::Zero());
  /// Body frame, in which the inertia is diagonal; of gyroscopic bodies.
  jobs::SharedValues<Quaternion> principal_axes = jobs::SharedValues<Quaternion>(Quaternion::Identity());
  /// kg m^2, about these.
  jobs::SharedValues<Vector3> moments = jobs::SharedValues<Vector3>(Vector3::Zero());
  jobs::CompactArray<std::uint8_t> locks;  ///< locked axes, see motion_locks.h
  jobs::CompactArray<std::uint8_t> ball;   ///< 1 for a sphere about the centre of mass: it looks the same turned
  jobs::CompactArray<std::uint8_t> rolls;  ///< 1 for what has round shapes and is no ball: see contact_arm.h
  jobs::CompactArray<Surface> surfaces;    ///< empty while all are plain
  jobs::CompactArray<double> min_moment;   ///< kg m^2, see contact_inertia.h; 0 or empty where there is no need
  jobs::CompactArray<double> gravity_scale;
  jobs::CompactArray<double> linear_damping;   ///< 1/s
  jobs::CompactArray<double> angular_damping;  ///< 1/s

  jobs::CompactArray<double> radius;        ///< m, of the shapes about the centre of mass; 0 where unbounded
  jobs::CompactArray<double> turned;        ///< sum of all turns' chords 2 sin(angle / 2): an odometer
  jobs::CompactArray<std::uint8_t> joined;  ///< 1 for dynamic bodies that joints act on

  std::size_t size() const { return mobility.size(); }
  void resize(std::size_t count);
  /// See jobs/arrays.h. Without the surfaces.
  auto arrays() const {
    return std::tie(positions, orientations, velocities, angular_velocities, forces, torques, mobility, inverse_mass,
                    gyroscopic, inertia, inverse_inertia, principal_axes, moments, locks, ball, rolls, min_moment,
                    gravity_scale, linear_damping, angular_damping, radius, turned, joined);
  }

  auto position(std::size_t body) { return Eigen::Map<Vector3>(positions.data() + 3 * body); }
  auto position(std::size_t body) const { return Eigen::Map<const Vector3>(positions.data() + 3 * body); }
  auto velocity(std::size_t body) { return Eigen::Map<Vector3>(velocities.data() + 3 * body); }
  auto velocity(std::size_t body) const { return Eigen::Map<const Vector3>(velocities.data() + 3 * body); }
  auto angular_velocity(std::size_t body) { return Eigen::Map<Vector3>(angular_velocities.data() + 3 * body); }
  auto angular_velocity(std::size_t body) const {
    return Eigen::Map<const Vector3>(angular_velocities.data() + 3 * body);
  }
  /// m/s, of a point at an arm from the centre of mass.
  Vector3 velocity_at(std::size_t body, const Vector3& arm) const {
    return velocity(body) + angular_velocity(body).cross(arm);
  }
  Vector3 force(std::size_t body) const { return forces.empty() ? Vector3::Zero() : Vector3(&forces[3 * body]); }
  Vector3 torque(std::size_t body) const { return torques.empty() ? Vector3::Zero() : Vector3(&torques[3 * body]); }
  void push(std::size_t body, const Vector3& force, const Vector3& torque);
  void clear_push(std::size_t body);

  Quaternion orientation(std::size_t body) const {
    const double* q = orientations.data() + 4 * body;
    return {q[3], q[0], q[1], q[2]};
  }
  void set_orientation(std::size_t body, const Quaternion& q) {
    Eigen::Map<Eigen::Vector4d>(orientations.data() + 4 * body) = q.coeffs();
  }
};

inline void BodyTable::push(std::size_t body, const Vector3& force, const Vector3& torque) {
  forces.resize(3 * size(), 0.0);
  torques.resize(3 * size(), 0.0);
  Eigen::Map<Vector3>(&forces[3 * body]) += force;
  Eigen::Map<Vector3>(&torques[3 * body]) += torque;
}

inline void BodyTable::clear_push(std::size_t body) {
  for (jobs::CompactArray<double>* rows : {&forces, &torques}) {
    if (!rows->empty()) std::fill_n(rows->data() + 3 * body, 3, 0.0);
  }
}

inline void BodyTable::resize(std::size_t count) {
  const bool one_more = count == size() + 1;
  if (!forces.empty()) forces.resize(3 * count, 0.0);
  if (!torques.empty()) torques.resize(3 * count, 0.0);
  for (jobs::CompactArray<double>* rows : {&positions, &velocities, &angular_velocities}) {
    if (one_more) {
      for (int i = 0; i < 3; ++i) rows->push_back(0.0);
    } else {
      rows->resize(3 * count, 0.0);
    }
  }
  if (one_more) {
    for (int i = 0; i < 4; ++i) orientations.push_back(0.0);
  } else {
    orientations.resize(4 * count, 0.0);
  }
  jobs::append(mobility, count, Mobility::Fixed);
  jobs::append(inverse_mass, count, 0.0);
  inertia.resize(count);
  inverse_inertia.resize(count);
  principal_axes.resize(count);
  moments.resize(count);
  if (!surfaces.empty()) surfaces.resize(count);
  if (!min_moment.empty()) jobs::append(min_moment, count, 0.0);
  jobs::append(gravity_scale, count, 1.0);
  for (jobs::CompactArray<std::uint8_t>* flags : {&gyroscopic, &locks, &ball, &rolls, &joined}) {
    jobs::append(*flags, count, std::uint8_t{0});
  }
  for (jobs::CompactArray<double>* values : {&linear_damping, &angular_damping, &radius, &turned}) {
    jobs::append(*values, count, 0.0);
  }
}

}  // namespace atl::solver
