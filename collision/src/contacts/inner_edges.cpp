#include <collision/contacts/inner_edges.h>
#include <collision/narrowphase/distance.h>
#include <collision/shapes/hull.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace atl::collision {
namespace {

// Sine of the angle between two normals, below which they count as parallel: some rounding of normals in single
// precision.
constexpr double least_lean = 1e-4;
// The same sine for a normal that is that of a face of the moving shape, which rests on flush solids not quite flat
// with that face.
constexpr double least_lean_of_face = 0.045;
// Part of a contact's size by which flush surfaces may be out of line: a step of a hundredth is to stop things.
constexpr double flush = 1e-3;
// Cosine of the angle between a contact's normal and that of a face in whose plane it is taken to be: the normal may be
// that of a face of the other shape, which tilts.
constexpr double along_face = 0.999;
constexpr std::uint32_t among_several = ~0u;

// The two colliders of a contact of which one stands still.
struct FixedSide {
  std::uint32_t mover, collider;
  bool is_first;  // what stands still is
};

// Returns false if it isn't that just one of them stands still.
bool fixed_side_of(const Contact& contact, std::span<const std::uint8_t> mobility, FixedSide& side) {
  const bool first = mobility[contact.body_first] == 0, second = mobility[contact.body_second] == 0;
  if (first == second) return false;
  side = first ? FixedSide{contact.pair.second, contact.pair.first, true}
               : FixedSide{contact.pair.first, contact.pair.second, false};
  return true;
}

Vector3 vector_of(const float* v) { return Eigen::Map<const Eigen::Vector3f>(v).cast<double>(); }

// The normal of the face of a shape to which a direction, in its frame, is nearly normal.
std::optional<Vector3> face_along(const Shape& shape, const Vector3& direction) {
  std::optional<Vector3> nearest;
  double most = along_face;
  const auto offer = [&](const Vector3& normal) {
    if (normal.dot(direction) < most) return;
    most = normal.dot(direction);
    nearest = normal;
  };
  if (shape.kind == ShapeKind::Box) {
    for (int k = 0; k < 3; ++k) offer(std::copysign(1.0, direction[k]) * Vector3::Unit(k));
  } else if (shape.kind == ShapeKind::Cylinder || shape.kind == ShapeKind::Cone) {
    offer(std::copysign(1.0, direction.z()) * Vector3::UnitZ());
  } else if (shape.kind == ShapeKind::Hull) {
    for (const Hull::Plane& plane : shape.hull->planes) offer(plane.normal);
  }
  return nearest;
}

// m, along a direction in the world.
double reach_of(const ContactUpdateInput& input, std::uint32_t collider, const Vector3& direction) {
  const Pose pose = input.colliders.pose(collider, input.poses);
  const Vector3 own = pose.orientation.conjugate() * direction;
  return direction.dot(pose.position) + reach_along(input.colliders.shape[collider], own);
}

// Calls visit(p) for the points of a contact on what stands still, m.
template <typename Visit>
void each_point(const Contact& contact, const ContactManifold& manifold, const PoseView& poses, bool fixed_is_first,
                const Visit& visit) {
  const std::uint32_t mover = fixed_is_first ? contact.body_second : contact.body_first;
  const Vector3 centre =
      poses.position(mover) + vector_of(fixed_is_first ? manifold.anchor_second : manifold.anchor_first);
  const Vector3 normal = (fixed_is_first ? 1.0 : -1.0) * vector_of(manifold.normal);
  const Tangents frame = tangents(manifold.normal);
  for (std::size_t i = 0; i < contact.count; ++i) {
    visit(Vector3(centre + static_cast<double>(manifold.x[i]) * vector_of(frame.first.data()) +
                  static_cast<double>(manifold.y[i]) * vector_of(frame.second.data()) -
                  0.5 * static_cast<double>(manifold.separation[i]) * normal));
  }
}

}  // namespace

void InnerEdges::list(const ContactCache& cache, const ContactUpdateInput& input,
                      std::span<const TouchingPair> touching) {
  const ColliderTable& colliders = input.colliders;
  const PoseView& poses = input.poses;
  last_.resize(colliders.size(), 0);
  on_fixed_.clear();
  bool any = false;
  FixedSide side;
  for (const TouchingPair& pair : touching) {
    if (!fixed_side_of(cache.contacts[pair.slot], input.mobility, side)) continue;
    std::uint32_t& last = last_[side.mover];
    any |= last != 0 && last != side.collider + 1;
    last = last == 0 || last == side.collider + 1 ? side.collider + 1 : among_several;
  }
  for (const TouchingPair& pair : any ? touching : std::span<const TouchingPair>()) {
    const Contact& contact = cache.contacts[pair.slot];
    if (!fixed_side_of(contact, input.mobility, side) || last_[side.mover] != among_several) continue;
    const ContactManifold& manifold = cache.manifolds[pair.slot];
    const Shape& shape = colliders.shape[side.collider];
    const Quaternion turn = colliders.pose(side.collider, poses).orientation;
    OnFixed found{side.mover, side.collider, pair.slot};
    found.normal = (side.is_first ? 1.0 : -1.0) * vector_of(manifold.normal);
    const std::optional<Vector3> face = face_along(shape, turn.conjugate() * found.normal);
    found.plane = face ? Vector3(turn * *face) : found.normal;
    const Vector3 against = colliders.pose(side.mover, poses).orientation.conjugate() * -found.normal;
    const std::optional<Vector3> own = face_along(colliders.shape[side.mover], against);
    found.least_lean = own && (*own - against).norm() < least_lean ? least_lean_of_face : least_lean;
    if (is_convex_solid(shape.kind)) {
      found.offset = reach_of(input, side.collider, found.plane);
    } else {
      found.offset = -std::numeric_limits<double>::infinity();
      each_point(contact, manifold, poses, side.is_first,
                 [&](const Vector3& p) { found.offset = std::max(found.offset, found.plane.dot(p)); });
    }
    on_fixed_.push_back(found);
  }
  for (const TouchingPair& pair : touching) {
    last_[cache.contacts[pair.slot].pair.first] = last_[cache.contacts[pair.slot].pair.second] = 0;
  }
}

// Tells if the shape that stands still in a contact reaches just to the plane of another contact: a solid with all of
// it, a surface where it is touched.
bool InnerEdges::ends_at(const ContactCache& cache, const ContactUpdateInput& input, const OnFixed& contact,
                         const OnFixed& other) {
  const ColliderTable& colliders = input.colliders;
  const PoseView& poses = input.poses;
  const Contact& of = cache.contacts[contact.slot];
  const Shape& shape = colliders.shape[contact.collider];
  const double most = flush * static_cast<double>(of.size);
  if (is_convex_solid(shape.kind)) {
    return std::abs(reach_of(input, contact.collider, other.plane) - other.offset) <= most;
  }
  if (shape.kind == ShapeKind::HalfSpace) return false;
  const Pose pose = colliders.pose(contact.collider, poses);
  bool ends = true;
  each_point(of, cache.manifolds[contact.slot], poses, of.pair.first == contact.collider, [&](const Vector3& p) {
    const Pose above{p + 3 * most * other.plane, Quaternion::Identity()};
    ends = ends && std::abs(other.plane.dot(p) - other.offset) <= most &&
           !overlaps(Shape::sphere(most), above, shape, pose);
  });
  return ends;
}

void InnerEdges::find_of_mover(const ContactCache& cache, const ContactUpdateInput& input,
                               std::span<const OnFixed> contacts) {
  for (const OnFixed& contact : contacts) {
    const auto hides_it = [&](const OnFixed& other) {
      return other.collider != contact.collider && contact.normal.cross(other.plane).norm() >= contact.least_lean &&
             ends_at(cache, input, contact, other);
    };
    if (std::ranges::any_of(contacts, hides_it)) inner_.push_back(contact.slot);
  }
}

std::span<const std::uint32_t> InnerEdges::find(const ContactCache& cache, const ContactUpdateInput& input,
                                                std::span<const TouchingPair> touching) {
  inner_.clear();
  list(cache, input, touching);
  std::ranges::stable_sort(on_fixed_, {}, &OnFixed::mover);
  for (auto first = on_fixed_.begin(); first != on_fixed_.end();) {
    const auto end =
        std::find_if(first, on_fixed_.end(), [&](const OnFixed& one) { return one.mover != first->mover; });
    find_of_mover(cache, input, {first, end});
    first = end;
  }
  std::ranges::sort(inner_);
  return inner_;
}

}  // namespace atl::collision
