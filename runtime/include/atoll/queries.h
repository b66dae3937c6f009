#pragma once
/// Questions about where a world's bodies are: rays, shapes that are moved, overlaps, closest points.

#include <atoll/body.h>
#include <atoll/world.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace atl {

/// The points origin + s * direction for distances s (m) of [0, max_distance].
struct Ray {
  Vector3 origin = Vector3::Zero();                               ///< m
  Vector3 direction = {0, 0, -1};                                 ///< of any length but zero: normalised on use
  double max_distance = std::numeric_limits<double>::infinity();  ///< m, >= 0
  bool both_sides = false;                                        ///< hits triangles from behind too
};

/// A convex solid at a place. A point is QueryShape{.position = p}.
struct QueryShape {
  std::optional<ConvexShape> shape = {};  ///< none: a point
  Vector3 position = Vector3::Zero();     ///< m, of the shape's frame
  Quaternion orientation = Quaternion::Identity();
};

/// A convex solid that is moved straight, without turning.
struct ShapeCast {
  ConvexShape shape = Sphere{};
  Vector3 position = Vector3::Zero();  ///< m, of the shape's frame at the start
  Quaternion orientation = Quaternion::Identity();
  Vector3 translation = Vector3::Zero();  ///< m
};

/// Which bodies count.
struct QueryFilter {
  /// Works like a CollisionFilter without a group: each one's mask must have a bit of the other's category.
  std::uint32_t category = ~0u;
  std::uint32_t mask = ~0u;
  bool static_bodies = true;
  bool kinematic_bodies = true;
  bool dynamic_bodies = true;
  bool sensors = false;                 ///< of these types
  std::span<const BodyId> ignore = {};  ///< ids of removed bodies do no harm
  /// Finds only what this body may touch, in place of category and mask: by the filters of both and of their children,
  /// disabled pairs, joints, and what a contact filter has refused. That is asked of what is near the body, not by
  /// queries. Neither the body itself is found, nor sensors. Error on a stale id.
  std::optional<BodyId> as = {};
  /// Asked last, with the number of the child in a compound (else 0); none: all count. In batches it is called from
  /// several threads at once. It may not throw.
  std::function<bool(BodyId body, std::uint32_t child)> predicate = {};
};

struct RayHit {
  BodyId body;
  std::uint32_t child = 0;                ///< in a compound, else 0
  double distance = 0;                    ///< m
  Vector3 point = Vector3::Zero();        ///< m
  Vector3 normal = Vector3::UnitZ();      ///< unit, of the side that was hit
  std::optional<std::uint32_t> triangle;  ///< of a mesh, or of a height field (2 c and 2 c + 1 in cell c)
  /// The ray starts in the interior of a solid: then distance = 0, and the normal is the shortest way out.
  bool started_inside = false;
  double depth = 0;  ///< m: how far that is, else 0
};

struct ShapeHit {
  BodyId body;
  std::uint32_t child = 0;
  double distance = 0;                    ///< m, along the translation, that the shape can be moved
  Vector3 point = Vector3::Zero();        ///< m, on the body
  Vector3 normal = Vector3::UnitZ();      ///< unit, from the body to the shape
  std::optional<std::uint32_t> triangle;  ///< as RayHit's
  /// The two overlap before any motion: then distance = 0, and the shape gets free soonest along the normal.
  bool started_overlapping = false;
  double depth = 0;  ///< m: by so much, else 0
};

/// The nearest points of a shape and a body. If they overlap, the distance is negative: moved along the normal by so
/// much, which is the shortest way out, the shape gets free. That is accurate to 1e-4 of the smaller one's inner
/// radius, and to a tenth of it where a capsule's axis is deep in another solid. Triangles push shapes out by their
/// fronts; one that is crossed from behind is at distance 0.
struct ClosestPoint {
  BodyId body;
  std::uint32_t child = 0;
  double distance = 0;                    ///< m, below 0 where they overlap
  Vector3 on_body = Vector3::Zero();      ///< m, the deepest point where they overlap
  Vector3 on_shape = Vector3::Zero();     ///< m, likewise
  Vector3 normal = Vector3::UnitZ();      ///< unit, from the body to the shape
  std::optional<std::uint32_t> triangle;  ///< as RayHit's
};

/// Answers for a world as it is, at the bodies' present poses. Doesn't change it: any number of threads may ask at
/// once, as long as nobody steps or changes the world. The world must outlive this and must not be moved.
///
/// Equal bodies give equal answers: hits come by distance, and those at the same distance by body index, then child.
/// The triangles of meshes and height fields have no inside: what lies behind them is not overlapped. Rays and
/// shapes that are moved pass through them from behind.
///
/// Every call throws Error on a number that is not finite, a direction or orientation that is zero, or a shape whose
/// sizes are not positive, naming it. Batches are answered in parallel by the world's threads, in the order asked.
class Queries {
 public:
  explicit Queries(const World& world);

  std::optional<RayHit> cast_ray(const Ray& ray, const QueryFilter& filter = {}) const;
  /// One hit for each body (or child) that the ray meets.
  std::vector<RayHit> cast_ray_through(const Ray& ray, const QueryFilter& filter = {}) const;
  /// True if the ray hits anything: cheaper than asking for the first hit.
  bool is_blocked(const Ray& ray, const QueryFilter& filter = {}) const;

  /// Accurate to 1e-7 of the shape's inner radius; `distance` is never too far.
  std::optional<ShapeHit> cast_shape(const ShapeCast& cast, const QueryFilter& filter = {}) const;
  std::vector<ShapeHit> cast_shape_through(const ShapeCast& cast, const QueryFilter& filter = {}) const;

  /// Bodies that touch or overlap the shape, each once, in order of index.
  std::vector<BodyId> overlapping(const QueryShape& shape, const QueryFilter& filter = {}) const;

  /// max_distance (m) >= 0 and finite. Of several that overlap the shape, the deepest.
  std::optional<ClosestPoint> closest_point(const QueryShape& shape, double max_distance,
                                            const QueryFilter& filter = {}) const;
  /// The closest point of each body (or child) within max_distance, by distance. With max_distance = 0: what overlaps
  /// the shape, how deep, and which way out.
  std::vector<ClosestPoint> nearby(const QueryShape& shape, double max_distance, const QueryFilter& filter = {}) const;

  std::vector<std::optional<RayHit>> cast_rays(std::span<const Ray> rays, const QueryFilter& filter = {}) const;
  std::vector<std::uint8_t> are_blocked(std::span<const Ray> rays, const QueryFilter& filter = {}) const;
  std::vector<std::optional<ShapeHit>> cast_shapes(std::span<const ShapeCast> casts,
                                                   const QueryFilter& filter = {}) const;
  std::vector<std::vector<BodyId>> overlapping(std::span<const QueryShape> shapes,
                                               const QueryFilter& filter = {}) const;
  std::vector<std::optional<ClosestPoint>> closest_points(std::span<const QueryShape> shapes, double max_distance,
                                                          const QueryFilter& filter = {}) const;

 private:
  const World* world_;
};

}  // namespace atl
