#pragma once
/// The few definitions and sums that most tests start from.

#include <atoll/atoll.h>

#include <utility>
#include <vector>

namespace atl::test {

inline constexpr double g = 9.81;       ///< m/s^2
inline constexpr double dt = 1.0 / 60;  ///< s

/// The duration of a substep: the step of all first-order errors below.
inline double substep(double step = dt, const Settings& settings = {}) { return step / settings.substeps; }

inline BodyDef ground(double friction = 0.6) {
  return {.type = BodyType::Static, .shape = HalfSpace{}, .material = {.friction = friction}};
}

inline BodyDef box(const Vector3& position, const Vector3& half_extents = Vector3::Constant(0.5)) {
  return {.shape = Box{half_extents}, .position = position};
}

inline BodyDef sphere(const Vector3& position, double radius = 0.5) {
  return {.shape = Sphere{radius}, .position = position};
}

inline BodyDef static_box(const Vector3& position, const Vector3& half_extents) {
  return {.type = BodyType::Static, .shape = Box{half_extents}, .position = position};
}

inline BodyDef locked(BodyDef def, const MotionLocks& locks) {
  def.locks = locks;
  return def;
}

/// Targets for all errors there are, near enough that islands of small scenes get all kinds of substeps.
inline ErrorTarget all_targets() {
  return {.penetration = 5e-4, .joint_gap = 2e-4, .residual = 0.05, .motion = 5e-3, .max_substeps = 24};
}

/// Steps `count` times and returns the last report.
inline StepReport run(World& world, int count, double step = dt) {
  StepReport report;
  for (int i = 0; i < count; ++i) report = world.step(step);
  return report;
}

/// A column of boxes with edges of `size` that touch without overlap; its bottom is at `base`.
inline std::vector<BodyId> add_stack(World& world, int height, const Vector3& base = Vector3::Zero(), double size = 1) {
  std::vector<BodyId> ids;
  for (int i = 0; i < height; ++i) {
    ids.push_back(world.add_body(box(base + Vector3(0, 0, (i + 0.5) * size), Vector3::Constant(size / 2))));
  }
  return ids;
}

/// Principal moments of a solid box, kg m^2.
inline Vector3 box_inertia(double mass, const Vector3& half_extents) {
  const Vector3 squares = half_extents.cwiseAbs2();
  return mass / 3 * Vector3(squares.y() + squares.z(), squares.z() + squares.x(), squares.x() + squares.y());
}

inline Vector3 momentum(const World& world, const std::vector<BodyId>& ids) {
  Vector3 sum = Vector3::Zero();
  for (BodyId id : ids) sum += world.mass(id) * world.velocity(id);
  return sum;
}

/// Kinetic energy of translation, J.
inline double kinetic_energy(const World& world, const std::vector<BodyId>& ids) {
  double sum = 0;
  for (BodyId id : ids) sum += 0.5 * world.mass(id) * world.velocity(id).squaredNorm();
  return sum;
}

/// Ids of the bodies that can move, and whether all of them are finite.
inline std::vector<BodyId> dynamic_bodies(const World& world, const std::vector<BodyId>& ids) {
  std::vector<BodyId> dynamic;
  for (BodyId id : ids) {
    if (world.type(id) == BodyType::Dynamic) dynamic.push_back(id);
  }
  return dynamic;
}

/// Sum over the manifold points between two bodies of the force on `on`, N.
inline Vector3 contact_force(const World& world, BodyId from, BodyId on) {
  Vector3 sum = Vector3::Zero();
  for (const ContactForce& point : world.contact_forces()) {
    const Vector3 on_b = point.normal_force * point.normal + point.friction;
    if (point.a == from && point.b == on) sum += on_b;
    if (point.a == on && point.b == from) sum -= on_b;
  }
  return sum;
}

}  // namespace atl::test
