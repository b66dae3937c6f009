#pragma once
/// Bullet's shapes, vectors and transforms for Atoll's.

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

#include "solid.h"

namespace peer {

btVector3 to_bullet(const atl::Vector3& v);
btTransform to_bullet(const atl::Pose& pose);
atl::Vector3 from_bullet(const btVector3& v);
atl::Pose from_bullet(const btTransform& transform);

/// Owns shapes, with all that they point to.
///
/// Bullet keeps a collision margin (4 cm) inside boxes and cylinders, whose size is as given, and rounds their edges by
/// it where GJK handles them. Around cones, hulls and surfaces it would lie outside, so there it is zero.
class BulletShapes {
 public:
  /// A compound, unless one part in the solid's own frame is all there is.
  btCollisionShape* add(const Solid& solid);

 private:
  struct Maker;
  struct Part {
    btCollisionShape* shape;
    btTransform place;  // in the frame of Atoll's shape
  };

  btCollisionShape* keep(std::unique_ptr<btCollisionShape> shape);

  std::vector<std::vector<float>> heights_;
  std::vector<std::unique_ptr<btStridingMeshInterface>> meshes_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;  // after what they point to
};

}  // namespace peer
