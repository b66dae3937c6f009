// The one file that includes FCL. It is compiled with NDEBUG and FCL's own alignment (see CMakeLists.txt):
// FCL's and Eigen's asserts would abort the process on degenerate shapes, and boxBox2 is twice as fast
// instantiated here, through its overload on plain matrices, as it is in the packaged library.

#include <collision/fcl_narrowphase.h>
#include <fcl/narrowphase/detail/primitive_shape_algorithm/box_box.h>
#include <fcl/narrowphase/detail/primitive_shape_algorithm/sphere_box.h>
#include <fcl/narrowphase/detail/primitive_shape_algorithm/sphere_sphere.h>

#include <vector>

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

}  // namespace atl::collision::fcl_narrowphase
