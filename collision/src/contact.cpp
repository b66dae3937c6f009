#include <collision/contact.h>

#include <algorithm>
#include <cmath>

namespace atl::collision {
namespace {

using Vector3f = Eigen::Vector3f;

Vector3f vector(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

}  // namespace

Tangents tangents(const float normal[3]) {
  const float sign = std::copysign(1.0f, normal[2]);
  const float a = -1.0f / (sign + normal[2]);
  const float b = normal[0] * normal[1] * a;
  return {{1.0f + sign * (normal[0] * normal[0] * a), sign * b, -(sign * normal[0])},
          {b, sign + normal[1] * normal[1] * a, -normal[1]}};
}

Drift drift_since_capture(const Contact& contact, const Pose& incident) {
  const Vector3 shift = incident.position + incident.orientation * contact.centre_incident - contact.centre_reference;
  const std::array<float, 4>& q = contact.orientation;
  const Quaternion turn = incident.orientation * Quaternion(q[3], -q[0], -q[1], -q[2]);
  const double sign = turn.w() < 0 ? -1 : 1;
  return {
      shift,
      {static_cast<float>(sign * turn.x()), static_cast<float>(sign * turn.y()), static_cast<float>(sign * turn.z())},
      static_cast<float>(sign * turn.w())};
}

void capture(Contact& contact, const Manifold& manifold, const Pose& incident, double margin) {
  contact.reference_is_second = manifold.reference_is_second;
  contact.axis = static_cast<std::uint16_t>(manifold.axis);
  contact.count = static_cast<std::uint8_t>(manifold.count);
  contact.margin = static_cast<float>(margin);

  Vector3 centre = manifold.count > 0 ? Vector3(Vector3::Zero()) : incident.position;
  for (int i = 0; i < manifold.count; ++i) {
    centre += manifold.points[static_cast<std::size_t>(i)].position / manifold.count;
  }
  contact.centre_reference = centre;
  contact.centre_incident = incident.orientation.conjugate() * (centre - incident.position);
  Eigen::Map<Eigen::Vector4f>(contact.orientation.data()) = incident.orientation.coeffs().cast<float>();
  Eigen::Map<Vector3f>(contact.normal.data()) = manifold.normal.cast<float>();
  for (std::size_t i = 0; i < static_cast<std::size_t>(manifold.count); ++i) {
    const Manifold::Point& point = manifold.points[i];
    contact.ids[i] = point.id;
    contact.separation[i] = static_cast<float>(point.separation);
    Eigen::Map<Vector3f>(contact.offset[i].data()) = (point.position - centre).cast<float>();
  }
}

void place(const Contact& contact, const Drift& drift, const Pose& first, const Pose& second, double margin,
           ContactManifold& manifold) {
  const Pose& reference = contact.reference_is_second ? second : first;
  const Pose& incident = contact.reference_is_second ? first : second;
  const Eigen::Matrix3f to_world = reference.orientation.toRotationMatrix().cast<float>();
  const Vector3f local_normal = vector(contact.normal);
  const Vector3f turn = vector(drift.half_turn);
  const float shift_along_normal = local_normal.dot(drift.shift.cast<float>());

  // Points move with the incident shape: by the shift of the centre, and turned about it.
  const auto count = static_cast<std::size_t>(contact.count);
  std::array<Vector3f, max_points> offset;
  std::array<float, max_points> separation;
  std::array<float, max_points> weight;
  float weight_sum = 0;
  Vector3f centre = Vector3f::Zero();
  float mean_separation = 0;
  const auto reach = static_cast<float>(margin);
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3f at_capture = vector(contact.offset[i]);
    const Vector3f moved = 2 * drift.cosine * turn.cross(at_capture) + 2 * turn.cross(turn.cross(at_capture));
    offset[i] = at_capture + moved;
    separation[i] = contact.separation[i] + shift_along_normal + local_normal.dot(moved);
    weight[i] = std::max(reach - separation[i], 0.0f) + 1e-3f * reach + 1e-30f;
    weight_sum += weight[i];
    centre += weight[i] * offset[i];
    mean_separation += weight[i] * separation[i];
  }
  centre /= weight_sum;
  mean_separation /= weight_sum;

  const float side = contact.reference_is_second ? -1.0f : 1.0f;
  const Vector3f normal = side * (to_world * local_normal);
  Eigen::Map<Vector3f>(manifold.normal) = normal;
  const Tangents frame = tangents(manifold.normal);
  const Vector3f t1 = vector(frame.first);
  const Vector3f t2 = vector(frame.second);

  // Friction acts half-way between the surfaces, at the centre.
  const Vector3 middle =
      contact.centre_reference + drift.shift + (centre - 0.5f * mean_separation * local_normal).cast<double>();
  const Vector3 anchor_reference = reference.orientation * middle;
  const Vector3 anchor_incident = anchor_reference + (reference.position - incident.position);
  Eigen::Map<Vector3f>(manifold.anchor_first) =
      (contact.reference_is_second ? anchor_incident : anchor_reference).cast<float>();
  Eigen::Map<Vector3f>(manifold.anchor_second) =
      (contact.reference_is_second ? anchor_reference : anchor_incident).cast<float>();

  float lever = 0;
  for (std::size_t i = 0; i < max_points; ++i) {
    if (i >= count) {
      manifold.x[i] = 0;
      manifold.y[i] = 0;
      manifold.separation[i] = no_point;
      continue;
    }
    const Vector3f from_centre = to_world * (offset[i] - centre);
    manifold.x[i] = from_centre.dot(t1);
    manifold.y[i] = from_centre.dot(t2);
    manifold.separation[i] = separation[i];
    lever += std::sqrt(manifold.x[i] * manifold.x[i] + manifold.y[i] * manifold.y[i]);
  }
  manifold.lever = lever / static_cast<float>(count);
}

}  // namespace atl::collision
