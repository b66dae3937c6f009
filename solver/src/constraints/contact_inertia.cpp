#include <solver/constraints/contact_inertia.h>

namespace atl::solver {
namespace {

Matrix3 principal_axes(const BodyTable& bodies, std::uint32_t body) {
  return (bodies.orientation(body) * bodies.principal_axes[body]).toRotationMatrix();
}

}  // namespace

bool is_seen_heavier(const BodyTable& bodies, std::uint32_t body) {
  const std::vector<double>& least = bodies.least_moment;
  return !least.empty() && least[body] > 0;
}

Vector3 moments_in_contact(const BodyTable& bodies, std::uint32_t body) {
  // Bodies that are alike in all directions have no axes of their own.
  const Vector3 moments = bodies.gyroscopic[body] ? bodies.moments[body] : Vector3(bodies.inertia[body].diagonal());
  return moments.cwiseMax(bodies.least_moment[body]);
}

Matrix3 inertia_in_contact(const BodyTable& bodies, std::uint32_t body) {
  const Matrix3 axes = principal_axes(bodies, body);
  return axes * moments_in_contact(bodies, body).asDiagonal() * axes.transpose();
}

Matrix3 inverse_inertia_in_contact(const BodyTable& bodies, std::uint32_t body) {
  const Matrix3 axes = principal_axes(bodies, body);
  return axes * moments_in_contact(bodies, body).cwiseInverse().asDiagonal() * axes.transpose();
}

}  // namespace atl::solver
