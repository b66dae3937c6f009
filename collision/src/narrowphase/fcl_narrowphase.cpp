// The one file that includes FCL. It is compiled with NDEBUG and FCL's own alignment (see CMakeLists.txt):
// FCL's and Eigen's asserts would abort the process on degenerate shapes, and boxBox2 is twice as fast
// instantiated here, through its overload on plain matrices, as it is in the packaged library.

#include <collision/narrowphase/fcl_narrowphase.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/polytope.h>
#include <collision/shapes/shape.h>
#include <fcl/narrowphase/detail/convexity_based_algorithm/gjk_libccd.h>
#include <fcl/narrowphase/detail/primitive_shape_algorithm/box_box.h>
#include <fcl/narrowphase/detail/primitive_shape_algorithm/sphere_box.h>
#include <fcl/narrowphase/detail/primitive_shape_algorithm/sphere_sphere.h>

#include <algorithm>
#include <cmath>
#include <vector>

// Compiled here, with the flags of all else: the packaged library's answers depend on the machine it was built for.
namespace fcl::detail {
template bool sphereSphereIntersect(const Sphere<double>&, const Transform3<double>&, const Sphere<double>&,
                                    const Transform3<double>&, std::vector<ContactPoint<double>>*);
template bool sphereBoxIntersect(const Sphere<double>&, const Transform3<double>&, const Box<double>&,
                                 const Transform3<double>&, std::vector<ContactPoint<double>>*);
}  // namespace fcl::detail

namespace atl::collision::fcl_narrowphase {
namespace {

using Contacts = std::vector<fcl::ContactPoint<double>>;

// FCL returns contacts in a vector; one a thread keeps its memory between calls.
Contacts& contact_buffer() {
  thread_local Contacts contacts = [] {
    Contacts fresh;
    fresh.reserve(8);
    return fresh;
  }();
  contacts.clear();
  return contacts;
}

bool run_box_box(const Vector3& side_first, const Vector3& side_second, const Vector3& position,
                 const Matrix3& rotation, Axis& axis) {
  const Matrix3 identity = Matrix3::Identity();
  const Vector3 origin = Vector3::Zero();
  double depth = 0;
  // Eight is what it finds at most: a lower limit would make it sort and cull points that we don't use.
  fcl::detail::boxBox2(side_first, identity, origin, side_second, rotation, position, axis.normal, &depth, &axis.code,
                       8, contact_buffer());
  axis.separation = -depth;
  return axis.code != 0;
}

// FCL leaves the normal out where centres coincide; any direction parts them.
bool accept(const Contacts& contacts, double margin, Axis& axis) {
  if (contacts.empty()) return false;
  const fcl::ContactPoint<double>& contact = contacts.front();
  axis.normal = contact.normal.squaredNorm() > 0.25 ? contact.normal : Vector3::UnitZ();
  axis.separation = margin - contact.penetration_depth;
  axis.code = 1;
  return true;
}

fcl::Transform3d translation(const Vector3& position) {
  fcl::Transform3d transform = fcl::Transform3d::Identity();
  transform.translation() = position;
  return transform;
}

// A solid as libccd's callbacks see it. The first loops of libccd's refinement have no bound of their own. So a body
// that was asked too often answers with a point so far behind that any loop sees it missed the origin, and ends.
struct Body {
  const Shape* shape;
  Polytope hull;  // of a hull
  Vector3 position = Vector3::Zero();
  Matrix3 rotation = Matrix3::Identity();
  Vector3 centre = Vector3::Zero();  // inner point, shape's frame
  double scale = 1;                  // about the centre
  double grown = 0;                  // m, in all directions
  int questions = 0;

  static constexpr int max_questions = 1000;

  Vector3 support(const Vector3& direction) {
    if (++questions > max_questions) return -1e6 * (shape->bounding_radius + position.norm() + 1) * direction;
    const Vector3 local = rotation.transpose() * direction;
    return position + rotation * local_support(local);
  }

 private:
  // libccd's directions have unit length, but for rounding and the very first one.
  Vector3 local_support(const Vector3& direction) const {
    switch (shape->kind) {
      case ShapeKind::Hull:
        return centre + scale * (hull.vertices[hull.support(direction)] - centre);
      case ShapeKind::Sphere:
      case ShapeKind::Capsule: {
        const double end = direction.z() < 0 ? -shape->half_height : shape->half_height;
        return (shape->radius + grown) / direction.norm() * direction + end * Vector3::UnitZ();
      }
      default:
        return scale * support_point(*shape, direction);
    }
  }
};

Vector3 to_vector(const ccd_vec3_t& v) { return {v.v[0], v.v[1], v.v[2]}; }

void body_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
  // libccd passes on as const what GJKCollide takes as mutable.
  const Vector3 p = static_cast<Body*>(const_cast<void*>(object))->support(to_vector(*direction));
  ccdVec3Set(point, p.x(), p.y(), p.z());
}

void body_centre(const void* object, ccd_vec3_t* centre) {
  const Body& body = *static_cast<const Body*>(object);
  const Vector3 p = body.position + body.rotation * body.centre;
  ccdVec3Set(centre, p.x(), p.y(), p.z());
}

// A body that reaches at least `margin` farther in every direction. Scaling keeps the directions of faces and
// edges, and so what the refinement converges to.
Body grown_body(const Shape& shape, double margin) {
  Body body;
  body.shape = &shape;
  double inner = shape.inner_radius;  // of a sphere about the centre
  switch (shape.kind) {
    case ShapeKind::Sphere:
    case ShapeKind::Capsule:
      body.grown = margin;
      return body;
    case ShapeKind::Cone:
      inner = shape.half_height * std::min(1.0, shape.radius / std::sqrt(shape.radius * shape.radius +
                                                                         4 * shape.half_height * shape.half_height));
      break;
    case ShapeKind::TaperedCapsule:
      inner = 0.5 * (shape.radius + shape.top_radius);
      break;
    case ShapeKind::Hull:
      body.centre = shape.hull->mass.centre;
      body.hull = polytope_of(*shape.hull);
      break;
    default:
      break;
  }
  body.scale = 1 + margin / inner;
  return body;
}

// m, how much farther a grown body reaches along a unit direction than its shape does.
double grown_along(const Body& body, const Vector3& direction) {
  if (body.scale == 1) return body.grown;
  const Vector3 local = body.rotation.transpose() * direction;
  return (body.scale - 1) * (reach_along(*body.shape, local) - body.centre.dot(local));
}

}  // namespace

bool box_box(const Vector3& half_first, const Vector3& half_second, const Vector3& position, const Matrix3& rotation,
             double margin, Axis& axis) {
  if (!position.allFinite() || !rotation.allFinite()) return false;
  const Vector3 side_first = 2 * half_first;
  const Vector3 side_second = 2 * half_second;
  if (run_box_box(side_first, side_second, position, rotation, axis)) return true;
  // FCL drops pairs that don't overlap. With the first box grown by the margin it finds those within it; the
  // caller measures the true separation along the axis.
  return margin > 0 && run_box_box(side_first + Vector3::Constant(2 * margin), side_second, position, rotation, axis);
}

bool sphere_sphere(double radius_first, double radius_second, const Vector3& position, double margin, Axis& axis) {
  if (!position.allFinite()) return false;
  Contacts& contacts = contact_buffer();
  fcl::detail::sphereSphereIntersect(fcl::Sphered(radius_first + margin), translation(Vector3::Zero()),
                                     fcl::Sphered(radius_second), translation(position), &contacts);
  return accept(contacts, margin, axis);
}

bool sphere_box(double radius, const Vector3& half_extents, const Vector3& centre, double margin, Axis& axis) {
  if (!centre.allFinite()) return false;
  Contacts& contacts = contact_buffer();
  const Vector3 sides = 2 * half_extents;
  fcl::detail::sphereBoxIntersect(fcl::Sphered(radius + margin), translation(centre), fcl::Boxd(sides),
                                  translation(Vector3::Zero()), &contacts);
  return accept(contacts, margin, axis);
}

bool convex(const Shape& first_shape, const Shape& second_shape, const Vector3& position, const Matrix3& rotation,
            double margin, Axis& axis) {
  if (!position.allFinite() || !rotation.allFinite()) return false;
  const double size = std::min(first_shape.inner_radius, second_shape.inner_radius);
  const double tolerance = 1e-2 * size;
  const double growth = margin + 1.5 * tolerance;
  const bool grow_first = first_shape.inner_radius >= second_shape.inner_radius;
  Body first = grown_body(first_shape, grow_first ? growth : 0);
  Body second = grown_body(second_shape, grow_first ? 0 : growth);
  second.position = position;
  second.rotation = rotation;
  // The walk to the features that meet makes up for the loose tolerance, which bounds the time for round shapes.
  constexpr unsigned max_iterations = 30;
  Vector3 point;
  double depth = 0;
  Vector3& normal = axis.normal;
  if (!fcl::detail::GJKCollide<double>(&first, body_support, body_centre, &second, body_support, body_centre,
                                       max_iterations, tolerance, &point, &depth, &normal)) {
    return false;
  }
  axis.code = 1;
  // FCL gives no normal for shapes that just touch or whose centres coincide.
  if (!(normal.squaredNorm() > 0.25 && normal.allFinite())) {
    const double distance = position.norm();
    normal = distance > 0 ? Vector3(position / distance) : Vector3::UnitZ();
  }
  normal.normalize();
  axis.separation = grown_along(grow_first ? first : second, grow_first ? normal : Vector3(-normal)) - depth;
  return true;
}

}  // namespace atl::collision::fcl_narrowphase
