#include <collision/contacts/contact.h>
#include <jobs/assert.h>

#include <cmath>

namespace atl::collision {

Tangents tangents(const float normal[3]) {
  const float sign = std::copysign(1.0f, normal[2]);
  const float a = -1.0f / (sign + normal[2]);
  const float b = normal[0] * normal[1] * a;
  return {{1.0f + sign * (normal[0] * normal[0] * a), sign * b, -(sign * normal[0])},
          {b, sign + normal[1] * normal[1] * a, -normal[1]}};
}

void store_features(Contact& contact, const Manifold& manifold, const Pose& incident, double margin, float tolerance) {
  ATL_ASSERT(manifold.count >= 0 && manifold.count <= max_points, manifold.count);
  ATL_ASSERT(!(std::abs(manifold.normal.squaredNorm() - 1) > 1e-6), contact.pair.first, contact.pair.second,
             manifold.normal.norm());
  ATL_ASSERT(!(margin < 0), margin);
  ATL_ASSERT(!(tolerance < 0), tolerance);
  contact.reference_is_second = manifold.reference_is_second;
  contact.on_face = manifold.on_face;
  contact.axis = manifold.axis;
  contact.count = static_cast<std::uint8_t>(manifold.count);
  contact.material = manifold.material;
  contact.margin = static_cast<float>(margin);
  contact.set_tolerance(tolerance);
  contact.gap = 0;

  Vector3 centre = manifold.count > 0 ? Vector3(Vector3::Zero()) : incident.position;
  for (int i = 0; i < manifold.count; ++i) {
    centre += manifold.points[static_cast<std::size_t>(i)].position / manifold.count;
  }
  Eigen::Map<Vector3>(contact.centre_reference.data()) = centre;
  Eigen::Map<Vector3>(contact.centre_incident.data()) = incident.orientation.conjugate() * (centre - incident.position);
  Eigen::Map<Eigen::Vector4f>(contact.orientation.data()) = incident.orientation.coeffs().cast<float>();
  Eigen::Map<Eigen::Vector3f>(contact.normal.data()) = manifold.normal.cast<float>();
  for (std::size_t i = 0; i < max_points; ++i) {
    if (i >= contact.count) {
      contact.points[i] = {0, 0, 0, no_point};
      continue;
    }
    const Manifold::Point& point = manifold.points[i];
    const Eigen::Vector3f offset = (point.position - centre).cast<float>();
    contact.ids[i] = point.id;
    contact.points[i] = {offset.x(), offset.y(), offset.z(), static_cast<float>(point.separation)};
  }
}

}  // namespace atl::collision
