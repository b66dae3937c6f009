#include <collision/contacts/inner_edges.h>
#include <collision/contacts/match_points.h>
#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/distance.h>
#include <collision/shapes/hull.h>
#include <jobs/assert.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "contacts/manifold_refresher.h"

namespace atl::collision {
namespace {

// Sine of the angle between two normals, below which they count as parallel: some rounding of normals in single
// precision.
constexpr double min_lean = 1e-4;
// The same sine for a normal that is that of a face of the moving shape, which rests on flush solids not quite flat
// with that face.
constexpr double min_lean_of_face = 0.045;
// Part of a contact's size by which flush surfaces may be out of line: a step of a hundredth is to stop things.
constexpr double flush = 1e-3;
// Cosine of the angle between a contact's normal and that of a face in whose plane it is taken to be: the normal may be
// that of a face of the other shape, which tilts.
constexpr double along_face = 0.999;
constexpr std::uint8_t several = 2;

// The ground's side of a contact: what stands still, or else a body with several colliders.
struct Ground {
  std::uint32_t body;  // `world` for all that stands still
  bool is_first;
};
constexpr std::uint32_t world = ~0u;

std::optional<Ground> ground_of(const Contact& contact, const ContactUpdateInput& input) {
  const auto is_fixed = [&](std::uint32_t body) { return input.mobility[body] == 0; };
  const auto is_compound = [&](std::uint32_t body) {
    return input.colliders.next[input.colliders.first[body]] != ColliderTable::none;
  };
  if (is_fixed(contact.body_first) != is_fixed(contact.body_second)) return Ground{world, is_fixed(contact.body_first)};
  if (is_fixed(contact.body_first)) return {};
  if (is_compound(contact.body_second)) return Ground{contact.body_second, false};
  if (is_compound(contact.body_first)) return Ground{contact.body_first, true};
  return {};
}

std::uint32_t mover_of(const Contact& contact, const Ground& ground) {
  return ground.is_first ? contact.body_second : contact.body_first;
}

Vector3 vector_of(const float* v) { return Eigen::Map<const Eigen::Vector3f>(v).cast<double>(); }

// Calls visit(normal, offset) for the faces of a solid that has only flat ones.
template <typename Visit>
void each_face(const Shape& shape, const Visit& visit) {
  if (shape.kind == ShapeKind::Box) {
    for (int k = 0; k < 3; ++k) {
      for (const double side : {-1.0, 1.0}) visit(Vector3(side * Vector3::Unit(k)), shape.half_extents[k]);
    }
  } else if (shape.kind == ShapeKind::Hull) {
    for (const Hull::Plane& plane : shape.hull->planes) visit(plane.normal, plane.offset);
  }
}

// The normal of the face of a shape to which a direction, in its frame, is nearly normal.
std::optional<Vector3> face_along(const Shape& shape, const Vector3& direction) {
  std::optional<Vector3> nearest;
  double max = along_face;
  const auto offer = [&](const Vector3& normal) {
    if (normal.dot(direction) < max) return;
    max = normal.dot(direction);
    nearest = normal;
  };
  if (shape.kind == ShapeKind::Cylinder || shape.kind == ShapeKind::Cone) {
    offer(std::copysign(1.0, direction.z()) * Vector3::UnitZ());
  } else {
    each_face(shape, [&](const Vector3& normal, double) { offer(normal); });
  }
  return nearest;
}

// m, along a direction in the world.
double reach_of(const ContactUpdateInput& input, std::uint32_t collider, const Vector3& direction) {
  const Pose pose = input.colliders.pose(collider, input.poses);
  const Vector3 own = pose.orientation.conjugate() * direction;
  return direction.dot(pose.position) + reach_along(input.colliders.shape[collider], own);
}

// Calls visit(p) for the points of a contact on the ground, m.
template <typename Visit>
void each_point(const Contact& contact, const ContactManifold& manifold, const PoseView& poses, bool ground_is_first,
                const Visit& visit) {
  const std::uint32_t mover = ground_is_first ? contact.body_second : contact.body_first;
  const Vector3 centre =
      poses.position(mover) + vector_of(ground_is_first ? manifold.anchor_second : manifold.anchor_first);
  const Vector3 normal = (ground_is_first ? 1.0 : -1.0) * vector_of(manifold.normal);
  const Tangents frame = tangents(manifold.normal);
  for (std::size_t i = 0; i < contact.count; ++i) {
    visit(Vector3(centre + static_cast<double>(manifold.x[i]) * vector_of(frame.first.data()) +
                  static_cast<double>(manifold.y[i]) * vector_of(frame.second.data()) -
                  0.5 * static_cast<double>(manifold.separation[i]) * normal));
  }
}

// Puts the contact of a solid with a face's plane in place of one with the ground. `normal` and `offset` are the
// face's, in its frame. Returns by how many points it has more.
int turn_contact(ContactCache& cache, const ContactUpdateInput& input, std::uint32_t slot, std::uint32_t own,
                 std::uint32_t ground, const Vector3& normal, double offset) {
  Contact& contact = cache.contacts[slot];
  const ColliderTable& colliders = input.colliders;
  const Pose solid = colliders.pose(own, input.poses), plane = colliders.pose(ground, input.poses);
  Manifold manifold;
  collide_half_space(colliders.shape[own], Shape::half_space(normal, offset), relative(solid, plane),
                     static_cast<double>(contact.margin), manifold);
  if (manifold.count == 0) return 0;
  const int before = contact.count;
  manifold.reference_is_second = contact.pair.second == ground;
  ContactManifold& stored = cache.manifolds[slot];
  match_points(OldPoints::of(contact, stored), manifold, static_cast<double>(contact.size), stored);
  store_features(contact, manifold, relative(plane, solid), static_cast<double>(contact.margin), contact.tolerance);
  ManifoldRefresher(cache, input).refresh_all({&slot, 1});
  return manifold.count - before;
}

}  // namespace

void InnerEdges::list(const ContactCache& cache, const ContactUpdateInput& input,
                      std::span<const TouchingPair> touching) {
  met_.resize(input.mobility.size(), 0);
  on_ground_.clear();
  bool any = false;
  for (const TouchingPair& pair : touching) {
    const Contact& contact = cache.contacts[pair.slot];
    const std::optional<Ground> ground = ground_of(contact, input);
    if (!ground || contact.part > 0) continue;
    std::uint8_t& met = met_[mover_of(contact, *ground)];
    any |= met > 0;
    met = met > 0 ? several : 1;
  }
  for (const TouchingPair& pair : any ? touching : std::span<const TouchingPair>()) {
    const Contact& contact = cache.contacts[pair.slot];
    const std::optional<Ground> ground = ground_of(contact, input);
    if (!ground || met_[mover_of(contact, *ground)] != several) continue;
    OnGround found{mover_of(contact, *ground), ground->body, contact.pair.first, contact.pair.second, pair.slot};
    if (ground->is_first) std::swap(found.own, found.collider);
    measure(contact, cache.manifolds[pair.slot], input, ground->is_first, found);
    on_ground_.push_back(found);
  }
  for (const TouchingPair& pair : touching) met_[pair.first] = met_[pair.second] = 0;
}

// Finds the ground's plane.
void InnerEdges::measure(const Contact& contact, const ContactManifold& manifold, const ContactUpdateInput& input,
                         bool ground_is_first, OnGround& found) {
  const ColliderTable& colliders = input.colliders;
  const PoseView& poses = input.poses;
  const Shape& shape = colliders.shape[found.collider];
  const Quaternion turn = colliders.pose(found.collider, poses).orientation;
  found.normal = (ground_is_first ? 1.0 : -1.0) * vector_of(manifold.normal);
  const std::optional<Vector3> face = face_along(shape, turn.conjugate() * found.normal);
  found.plane = face ? Vector3(turn * *face) : found.normal;
  found.on_face = face.has_value();
  const Vector3 against = colliders.pose(found.own, poses).orientation.conjugate() * -found.normal;
  const std::optional<Vector3> own = face_along(colliders.shape[found.own], against);
  found.min_lean = own && (*own - against).norm() < min_lean ? min_lean_of_face : min_lean;
  ATL_ASSERT(!(std::abs(found.plane.squaredNorm() - 1) > 1e-5), found.mover, found.collider, found.plane.norm());
  if (is_convex_solid(shape.kind)) {
    found.offset = reach_of(input, found.collider, found.plane);
  } else {
    found.offset = -std::numeric_limits<double>::infinity();
    each_point(contact, manifold, poses, ground_is_first,
               [&](const Vector3& p) { found.offset = std::max(found.offset, found.plane.dot(p)); });
  }
  ATL_ASSERT(std::isfinite(found.offset), found.mover, found.collider, found.offset);
}

// Tells if the shapes of a contact lie on either side of the plane of another contact of the same bodies, and the
// ground's reaches just to it: a solid with all of it, a surface where it is touched.
bool InnerEdges::ends_at(const ContactCache& cache, const ContactUpdateInput& input, const OnGround& contact,
                         const OnGround& other) {
  const ColliderTable& colliders = input.colliders;
  const PoseView& poses = input.poses;
  const Contact& of = cache.contacts[contact.slot];
  const Shape& shape = colliders.shape[contact.collider];
  const double max = flush * static_cast<double>(of.size);
  if (contact.own != other.own && -reach_of(input, contact.own, -other.plane) < other.offset - max) return false;
  if (is_convex_solid(shape.kind)) {
    return std::abs(reach_of(input, contact.collider, other.plane) - other.offset) <= max;
  }
  if (shape.kind == ShapeKind::HalfSpace) return false;
  const Pose pose = colliders.pose(contact.collider, poses);
  bool ends = true;
  each_point(of, cache.manifolds[contact.slot], poses, of.pair.first == contact.collider, [&](const Vector3& p) {
    const Pose above{p + 3 * max * other.plane, Quaternion::Identity()};
    ends =
        ends && std::abs(other.plane.dot(p) - other.offset) <= max && !overlaps(Shape::sphere(max), above, shape, pose);
  });
  return ends;
}

// The face of a solid that rises from the plane of another contact of the same bodies, if an edge of it is what a
// contact is with, and lies in that plane, where the other shape leads up to it. What is below the plane is inside.
std::optional<InnerEdges::Plane> InnerEdges::face_above(const ContactCache& cache, const ContactUpdateInput& input,
                                                        const OnGround& contact, const OnGround& other) {
  const ColliderTable& colliders = input.colliders;
  if (contact.on_face || contact.own != other.own) return {};
  const Vector3 back = contact.normal - contact.normal.dot(other.plane) * other.plane;
  if (!(back.norm() > contact.min_lean)) return {};
  const Contact& of = cache.contacts[contact.slot];
  const ContactManifold& manifold = cache.manifolds[contact.slot];
  const double max = flush * static_cast<double>(of.size);
  const float deepest = *std::min_element(manifold.separation, manifold.separation + of.count);
  const Pose pose = colliders.pose(contact.collider, input.poses);
  const Quaternion seen = pose.orientation.conjugate();
  const Shape& before = colliders.shape[other.collider];
  const Pose pose_before = colliders.pose(other.collider, input.poses);
  std::array<Vector3, max_points> places;  // in the solid's frame
  int count = 0, point = 0;
  bool leads_up = true;
  each_point(of, manifold, input.poses, of.pair.first == contact.collider, [&](const Vector3& p) {
    const double height = other.plane.dot(p) - other.offset;
    if (manifold.separation[point++] > deepest + static_cast<float>(max) || height < -max) return;
    places[static_cast<std::size_t>(count++)] = seen * (p - pose.position);
    const Pose ahead{p + 3 * max * back.normalized(), Quaternion::Identity()};
    leads_up = leads_up && height <= max && overlaps(Shape::sphere(max), ahead, before, pose_before);
  });
  if (!leads_up || count == 0) return {};
  const Vector3 up = seen * other.plane, towards = seen * back;
  std::optional<Plane> above;
  int faces = 0;
  bool is_in_front = false;
  each_face(colliders.shape[contact.collider], [&](const Vector3& normal, double offset) {
    const bool is_on_it = std::all_of(places.begin(), places.begin() + count, [&](const Vector3& place) {
      return std::abs(normal.dot(place) - offset) <= max;
    });
    if (!is_on_it) return;
    ++faces;
    if (!(normal.dot(up) > 0)) return;
    is_in_front = !above && normal.dot(towards) > 0;
    above = Plane{normal, offset};
  });
  if (faces != 2 || !is_in_front) return {};
  return above;
}

void InnerEdges::find_of_mover(ContactCache& cache, const ContactUpdateInput& input, std::span<const OnGround> contacts,
                               ContactUpdate& update) {
  for (const OnGround& contact : contacts) {
    const auto leans = [&](const OnGround& other) {
      return (other.collider != contact.collider || other.own != contact.own) &&
             contact.normal.cross(other.plane).norm() >= contact.min_lean;
    };
    if (std::ranges::any_of(
            contacts, [&](const OnGround& other) { return leans(other) && ends_at(cache, input, contact, other); })) {
      inner_.push_back(contact.slot);
      continue;
    }
    for (const OnGround& other : contacts) {
      const std::optional<Plane> face = leans(other) ? face_above(cache, input, contact, other) : std::nullopt;
      if (!face) continue;
      update.counts.points +=
          turn_contact(cache, input, contact.slot, contact.own, contact.collider, face->normal, face->offset);
      break;
    }
  }
}

std::span<const std::uint32_t> InnerEdges::find(ContactCache& cache, const ContactUpdateInput& input,
                                                ContactUpdate& update) {
  inner_.clear();
  list(cache, input, update.touching);
  const auto meeting = [](const OnGround& one) { return std::pair(one.mover, one.ground); };
  std::ranges::stable_sort(on_ground_, {}, meeting);
  for (auto first = on_ground_.begin(); first != on_ground_.end();) {
    const auto end =
        std::find_if(first, on_ground_.end(), [&](const OnGround& one) { return meeting(one) != meeting(*first); });
    find_of_mover(cache, input, {first, end}, update);
    first = end;
  }
  std::ranges::sort(inner_);
  ATL_ASSERT(std::ranges::adjacent_find(inner_) == inner_.end(), inner_.size());
  return inner_;
}

}  // namespace atl::collision
