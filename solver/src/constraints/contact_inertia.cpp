#include <jobs/assert.h>
#include <solver/constraints/contact_inertia.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace atl::solver {
namespace {

Matrix3 principal_axes(const BodyTable& bodies, std::uint32_t body) {
  return (bodies.orientation(body) * bodies.principal_axes[body]).toRotationMatrix();
}

Vector3 moments_of(const BodyTable& bodies, std::uint32_t body, double swing) {
  ATL_ASSERT(!(swing < 0), body, swing);
  const Vector3 moments = moments_in_contact(bodies, body);
  return moments.cwiseMax(std::min(swing * swing, 1.0) * moments.maxCoeff());
}

}  // namespace

bool is_seen_heavier(const BodyTable& bodies, std::uint32_t body) {
  const std::span<const double> min = bodies.min_moment;
  return !min.empty() && min[body] > 0;
}

Vector3 moments_in_contact(const BodyTable& bodies, std::uint32_t body) {
  ATL_ASSERT(is_seen_heavier(bodies, body), body);
  // Bodies that are alike in all directions have no axes of their own.
  const Vector3 moments = bodies.gyroscopic[body] ? bodies.moments[body] : Vector3(bodies.inertia[body].diagonal());
  return moments.cwiseMax(bodies.min_moment[body]);
}

double swing_in_contact(const BodyTable& bodies, std::uint32_t body, double approach, double dt) {
  const Vector3 moments = moments_in_contact(bodies, body);
  int light = 0;
  const double max = moments.maxCoeff();
  if (!(max > slender_ratio * moments.minCoeff(&light))) return 0;
  const Vector3 axis = principal_axes(bodies, body).col(light);
  const double turns = axis.cross(Vector3(bodies.angular_velocity(body))).norm();
  return dt * (turns + approach / std::sqrt(max * bodies.inverse_mass[body]));
}

Matrix3 inertia_in_contact(const BodyTable& bodies, std::uint32_t body, double swing) {
  const Matrix3 axes = principal_axes(bodies, body);
  return axes * moments_of(bodies, body, swing).asDiagonal() * axes.transpose();
}

Matrix3 inverse_inertia_in_contact(const BodyTable& bodies, std::uint32_t body, double swing) {
  const Matrix3 axes = principal_axes(bodies, body);
  return axes * moments_of(bodies, body, swing).cwiseInverse().asDiagonal() * axes.transpose();
}

}  // namespace atl::solver
