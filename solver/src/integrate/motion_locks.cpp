#include <jobs/assert.h>
#include <solver/integrate/motion_locks.h>

namespace atl::solver {

int shared_plane(const BodyTable& bodies, std::uint32_t first, std::uint32_t second) {
  const bool first_moves = bodies.mobility[first] == Mobility::Dynamic;
  const bool second_moves = bodies.mobility[second] == Mobility::Dynamic;
  const int of_first = plane_of(bodies.locks[first]), of_second = plane_of(bodies.locks[second]);
  if (first_moves && second_moves) return of_first == of_second ? of_first : -1;
  return first_moves ? of_first : second_moves ? of_second : -1;
}

Matrix3 inverse_on_free_axes(unsigned locked_axes, const Matrix3& inertia) {
  ATL_ASSERT(locked_axes != 0, locked_axes);
  Matrix3 inverse = Matrix3::Zero();
  Eigen::Index free[3];
  int count = 0;
  for (unsigned k = 0; k < 3; ++k) {
    if (!(locked_axes >> k & 1u)) free[count++] = k;
  }
  if (count == 1) inverse(free[0], free[0]) = 1 / inertia(free[0], free[0]);
  if (count == 2) {
    const Eigen::Index a = free[0], b = free[1];
    const double over = 1 / (inertia(a, a) * inertia(b, b) - inertia(a, b) * inertia(a, b));
    inverse(a, a) = over * inertia(b, b);
    inverse(b, b) = over * inertia(a, a);
    inverse(a, b) = inverse(b, a) = -over * inertia(a, b);
  }
  return inverse;
}

Matrix3 world_inverse_inertia(const BodyTable& bodies, std::uint32_t body) {
  const Matrix3 rotation = bodies.orientation(body).toRotationMatrix();
  const unsigned locked = angular_locks(bodies.locks[body]);
  if (locked != 0) return inverse_on_free_axes(locked, rotation * bodies.inertia[body] * rotation.transpose());
  return rotation * bodies.inverse_inertia[body] * rotation.transpose();
}

Vector3 linear_acceleration(const BodyTable& bodies, std::uint32_t body, const Vector3& gravity) {
  const Vector3 acceleration =
      gravity * bodies.gravity_scale[body] + bodies.inverse_mass[body] * Vector3(bodies.force(body));
  const unsigned locked = linear_locks(bodies.locks[body]);
  return locked == 0 ? acceleration : without(locked, acceleration);
}

Vector3 angular_response(const BodyTable& bodies, std::uint32_t body, const Vector3& torque) {
  const unsigned locked = angular_locks(bodies.locks[body]);
  if (locked != 0) return without(locked, world_inverse_inertia(bodies, body) * torque);
  const Quaternion orientation = bodies.orientation(body);
  return orientation * (bodies.inverse_inertia[body] * (orientation.conjugate() * torque));
}

}  // namespace atl::solver
