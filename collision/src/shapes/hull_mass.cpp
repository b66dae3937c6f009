#include "shapes/hull_build.h"

namespace atl::collision {

// Sum over tetrahedra from an inner point to the triangles of each face's fan. A tetrahedron with one corner at
// the origin has the second moments V / 20 * (sum of p p^T over its corners + s s^T), s the sum of its corners
// (Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia tensor", J. Math. Stat. 1 (2004); the same
// as Mirtich's face integrals, J. Graphics Tools 1 (1996), without the choice of a projection).
MassProperties polyhedron_mass(const Hull& hull) {
  Vector3 inner = Vector3::Zero();
  for (const Vector3& vertex : hull.vertices) inner += vertex;
  inner /= static_cast<double>(hull.vertices.size());

  double volume = 0;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const Vector3 a = hull.vertices[hull.face_vertices[hull.face_start[f]]] - inner;
    for (std::size_t i = hull.face_start[f] + 1u; i + 1 < hull.face_start[f + 1]; ++i) {
      const Vector3 b = hull.vertices[hull.face_vertices[i]] - inner;
      const Vector3 c = hull.vertices[hull.face_vertices[i + 1]] - inner;
      const double part = a.dot(b.cross(c)) / 6;
      const Vector3 sum = a + b + c;
      volume += part;
      first += part / 4 * sum;
      second += part / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
  }
  const Vector3 centre = first / volume;
  const Matrix3 covariance = second / volume - centre * centre.transpose();
  return {volume, inner + centre, covariance.trace() * Matrix3::Identity() - covariance};
}

}  // namespace atl::collision
