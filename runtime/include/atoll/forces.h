#pragma once

#include <atoll/types.h>

#include <Eigen/Core>

namespace atl {

class World;

/// The argument of a force law: the forces at one moment within a step. See World::step(double, const ForceLaw&).
class Forces {
 public:
  /// `bodies` columns, all zero. For World.
  Forces(const World& world, Eigen::Index bodies) : world_(world) {
    force_.setZero(3, bodies);
    torque_.setZero(3, bodies);
  }

  /// The world at this moment. A law may read it, but must not change it in any other way than by these forces.
  const World& world() const { return world_; }
  double time() const { return time_; }  ///< s since the step began, in [0, dt]

  /// Adds a force (N) through the centre of mass, and a torque (N m). Throws Error on a stale id, or on what is not
  /// finite.
  void add(BodyId id, const Vector3& force, const Vector3& torque = Vector3::Zero());
  /// Adds a force (N) at a world-frame point (m).
  void add_at(BodyId id, const Vector3& force, const Vector3& point);

  /// The same in bulk, one column a body index (BodyId::index), as World::positions() has them: to be added to, or set
  /// as a whole. Zero as the law is called. Those of bodies that are not dynamic do nothing; a body with what is not
  /// finite goes into quarantine.
  Eigen::Map<Eigen::Matrix3Xd> forces() { return {force_.data(), 3, force_.cols()}; }     ///< N
  Eigen::Map<Eigen::Matrix3Xd> torques() { return {torque_.data(), 3, torque_.cols()}; }  ///< N m

 private:
  friend class ForcedStep;

  const World& world_;
  double time_ = 0;
  Eigen::Matrix3Xd force_;
  Eigen::Matrix3Xd torque_;
};

}  // namespace atl
