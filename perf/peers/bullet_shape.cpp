#include "bullet_shape.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>

#include <algorithm>

namespace peer {
namespace {

btScalar scalar(double x) { return static_cast<btScalar>(x); }

}  // namespace

btVector3 to_bullet(const atl::Vector3& v) { return {scalar(v.x()), scalar(v.y()), scalar(v.z())}; }

btTransform to_bullet(const atl::Pose& pose) {
  const atl::Quaternion& q = pose.orientation;
  return btTransform(btQuaternion(scalar(q.x()), scalar(q.y()), scalar(q.z()), scalar(q.w())),
                     to_bullet(pose.position));
}

atl::Vector3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

atl::Pose from_bullet(const btTransform& transform) {
  const btQuaternion q = transform.getRotation();
  return {from_bullet(transform.getOrigin()), atl::Quaternion(q.w(), q.x(), q.y(), q.z()).normalized()};
}

btCollisionShape* BulletShapes::keep(std::unique_ptr<btCollisionShape> shape) {
  shapes_.push_back(std::move(shape));
  return shapes_.back().get();
}

struct BulletShapes::Maker {
  BulletShapes& store;

  template <typename Shape, typename... Arguments>
  Part centred(Arguments... arguments) const {
    return {store.keep(std::make_unique<Shape>(arguments...)), btTransform::getIdentity()};
  }

  Part operator()(const atl::Box& box) const { return centred<btBoxShape>(to_bullet(box.half_extents)); }
  Part operator()(const atl::Sphere& sphere) const { return centred<btSphereShape>(scalar(sphere.radius)); }
  Part operator()(const atl::Capsule& capsule) const {
    return centred<btCapsuleShapeZ>(scalar(capsule.radius), scalar(2 * capsule.half_height));
  }
  Part operator()(const atl::Cylinder& cylinder) const {
    return centred<btCylinderShapeZ>(to_bullet({cylinder.radius, cylinder.radius, cylinder.half_height}));
  }
  Part operator()(const atl::Cone& cone) const {
    const Part part = centred<btConeShapeZ>(scalar(cone.radius), scalar(2 * cone.half_height));
    part.shape->setMargin(0);
    return part;
  }
  // Two balls of different radii, and their hull.
  Part operator()(const atl::TaperedCapsule& capsule) const {
    const btVector3 middles[] = {{0, 0, scalar(-capsule.half_height)}, {0, 0, scalar(capsule.half_height)}};
    const btScalar radii[] = {scalar(capsule.radii[0]), scalar(capsule.radii[1])};
    return centred<btMultiSphereShape>(middles, radii, 2);
  }
  Part operator()(const atl::Ellipsoid&) const { throw atl::Error("Bullet has no ellipsoids"); }
  Part operator()(const atl::HalfSpace& half_space) const {
    return centred<btStaticPlaneShape>(to_bullet(half_space.normal.normalized()), scalar(half_space.offset));
  }

  Part operator()(const atl::ConvexHull& hull) const {
    auto shape = std::make_unique<btConvexHullShape>();
    for (const atl::Vector3& vertex : hull.vertices()) shape->addPoint(to_bullet(vertex), false);
    shape->recalcLocalAabb();
    shape->setMargin(0);
    return {store.keep(std::move(shape)), btTransform::getIdentity()};
  }

  Part operator()(const atl::TriangleMesh& mesh) const {
    auto triangles = std::make_unique<btTriangleMesh>();
    for (const atl::TriangleMesh::Indices& corners : mesh.triangles()) {
      const auto vertices = mesh.vertices();
      triangles->addTriangle(to_bullet(vertices[corners[0]]), to_bullet(vertices[corners[1]]),
                             to_bullet(vertices[corners[2]]));
    }
    store.meshes_.push_back(std::move(triangles));
    const Part part = centred<btBvhTriangleMeshShape>(store.meshes_.back().get(), true);
    part.shape->setMargin(0);
    return part;
  }

  // Bullet centres the grid, in height too.
  Part operator()(const atl::HeightField& field) const {
    store.heights_.emplace_back(field.heights().begin(), field.heights().end());
    const std::vector<float>& heights = store.heights_.back();
    const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
    const int columns = static_cast<int>(field.columns()), rows = static_cast<int>(field.rows());
    constexpr int up = 2;
    constexpr bool flip = true;  // diagonals as Atoll's
    const Part part =
        centred<btHeightfieldTerrainShape>(columns, rows, heights.data(), btScalar(*low), btScalar(*high), up, flip);
    part.shape->setLocalScaling({scalar(field.spacing_x()), scalar(field.spacing_y()), 1});
    part.shape->setMargin(0);
    const atl::Vector3 middle = {(columns - 1) * field.spacing_x() / 2, (rows - 1) * field.spacing_y() / 2,
                                 (double{*low} + double{*high}) / 2};
    return {part.shape, to_bullet(atl::Pose{.position = middle})};
  }

  Part operator()(const atl::Compound&) const { throw atl::Error("the Bullet driver found a compound in a compound"); }
};

btCollisionShape* BulletShapes::add(const Solid& solid) {
  std::vector<Part> parts;
  for (const peer::Part& part : solid.parts) {
    parts.push_back(std::visit(Maker{*this}, part.shape));
    parts.back().place = to_bullet(part.pose) * parts.back().place;
  }
  if (parts.size() == 1 && parts[0].place == btTransform::getIdentity()) return parts[0].shape;
  auto compound = std::make_unique<btCompoundShape>();
  for (const Part& part : parts) compound->addChildShape(part.place, part.shape);
  return keep(std::move(compound));
}

}  // namespace peer
