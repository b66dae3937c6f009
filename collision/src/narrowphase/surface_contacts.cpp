#include <collision/narrowphase/feature_id.h>
#include <collision/narrowphase/surface_contacts.h>
#include <collision/shapes/aabb.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/triangle_mesh.h>

#include <algorithm>
#include <cmath>

#include "narrowphase/point_distance.h"
#include "narrowphase/surface_clusters.h"

namespace atl::collision {
namespace {

// Calls visit(number) for the triangles near a box.
template <typename Visit>
void visit_near(const Shape& surface, const Aabb& box, const Visit& visit) {
  if (surface.kind == ShapeKind::Mesh) {
    surface.mesh->tree.query(box, visit);
  } else if (surface.kind == ShapeKind::HeightField) {
    surface.field->query(box, visit);
  }
}

// Calls visit(number) for those near a box that a ball may touch as well, by their own boxes.
template <typename Visit>
void visit_near_ball(const Shape& surface, const Aabb& box, const Vector3& centre, double radius, const Visit& visit) {
  if (surface.kind != ShapeKind::Mesh) return visit_near(surface, box, visit);
  const double square = (1 + 1e-9) * radius * radius;
  surface.mesh->tree.query_boxes(box, [&](std::uint32_t number, const Aabb& around) {
    if (square_apart(around, {centre, centre}) <= square) visit(number);
  });
}

// Calls visit(triangle, number) for those near a box.
template <typename Visit>
void visit_triangles(const Shape& surface, const Aabb& box, const Visit& visit) {
  visit_near(surface, box, [&](std::uint32_t i) {
    visit(surface.kind == ShapeKind::Mesh ? surface.mesh->triangle(i) : surface.field->triangle(i), i);
  });
}

// Vertices and normal of a triangle; the rest of it.
Triangle face_of(const Shape& surface, std::uint32_t number) {
  return surface.kind == ShapeKind::Mesh ? surface.mesh->face(number) : surface.field->face(number);
}
void complete(const Shape& surface, std::uint32_t number, Triangle& face) {
  if (surface.kind == ShapeKind::Mesh) {
    surface.mesh->complete(number, face);
  } else {
    surface.field->complete(number, face);
  }
}

// Whether a triangle that has a vertex reaches ahead of it along a direction, and so is touched first.
bool reaches_ahead(const Triangle& triangle, const Vector3& vertex, const Vector3& direction) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (triangle.vertices[i] != vertex) continue;
    for (const std::size_t k : {(i + 1) % 3, (i + 2) % 3}) {
      const Vector3 along = triangle.vertices[k] - vertex;
      if (along.dot(direction) > convex_edge_angle * along.norm()) return true;
    }
  }
  return false;
}

bool can_push_at_vertex(const Shape& surface, const Vector3& vertex, const Vector3& direction) {
  bool can = true;
  visit_near(surface, Aabb::around(vertex, vertex),
             [&](std::uint32_t number) { can = can && !reaches_ahead(face_of(surface, number), vertex, direction); });
  return can;
}

// Triangles that look other ways than the smooth surface where a ball touches it are none of it.
constexpr double same_sheet = 0.96592582628906831;  // cosine of 15 degrees
// A surface that bends by more within a step is one that the ball hits: a quarter of a radian, and its cosine.
constexpr double most_bend = 0.25;
constexpr double least_bend_cosine = 0.96891242171064473;
// rad: of less than that no facet rises against a ball.
constexpr double least_bend = 1e-4;

// Where a smooth surface is met from its front along its own normal, from a point above a triangle of it. The surface
// is over the triangle the mean of that and its projections onto the tangent planes at the corners: Phong tessellation
// (Boubekeur and Alexa, ACM Trans. Graph. 27, 2008), with the factor 1/2, with which arcs are exact to second order.
struct SmoothPlace {
  double distance;  // m
  Vector3 normal;

  SmoothPlace(const Triangle& triangle, const Vector3& from, Vector3 foot) {
    constexpr int rounds = 4;  // each brings the foot nearer by the point's distance over the surface's radius
    double height = 0, lift = 0;
    for (int round = 0; round < rounds; ++round) {
      normal.setZero();
      std::array<double, 3> share;  // by areas
      for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 next = triangle.vertices[(i + 1) % 3] - foot;
        const Vector3 last = triangle.vertices[(i + 2) % 3] - foot;
        share[i] = next.cross(last).dot(triangle.normal);
        normal += share[i] * triangle.corner_normals[i];
      }
      normal.normalize();
      lift = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const Vector3& corner = triangle.corner_normals[i];
        lift += share[i] * corner.dot(triangle.vertices[i] - foot) * corner.dot(normal);
      }
      lift *= 0.5 / (share[0] + share[1] + share[2]);
      height = triangle.normal.dot(from - triangle.vertices[0]) / triangle.normal.dot(normal);
      foot = from - height * normal;
    }
    distance = height - lift;
  }
};

// The triangle on whose front a point is nearest.
struct Nearest {
  double distance = INFINITY;  // m
  Triangle triangle;
  Vector3 foot;

  void look_at(const Triangle& other, const Vector3& from) {
    if (other.normal.dot(from - other.vertices[0]) < 0) return;
    const Vector3 point = closest_point_of_triangle(other.vertices, from);
    const double away = (from - point).norm();
    if (!(away < distance)) return;
    distance = away;
    triangle = other;
    foot = point;
  }
};

Nearest nearest_to(const Shape& surface, const Vector3& centre, double reach) {
  Nearest nearest;
  const Vector3 around = Vector3::Constant(reach);
  visit_triangles(surface, Aabb::around(centre - around, centre + around),
                  [&](const Triangle& triangle, std::uint32_t) { nearest.look_at(triangle, centre); });
  return nearest;
}

// In place of all that a ball's contacts say of the sheet that looks along a normal, one to be filled in; null if there
// is no room.
Manifold* replace_sheet(const Vector3& normal, SurfaceManifolds& result) {
  const auto other_end =
      std::remove_if(result.manifolds.begin(), result.manifolds.begin() + result.count,
                     [&](const Manifold& manifold) { return manifold.normal.dot(normal) > same_sheet; });
  result.count = static_cast<int>(other_end - result.manifolds.begin());
  if (result.count == max_surface_manifolds) return nullptr;
  Manifold& manifold = result.manifolds[static_cast<std::size_t>(result.count++)];
  manifold = {};
  manifold.reference_is_second = true;
  return &manifold;
}

// Gives a ball the manifold of the smooth surface that it is nearest to.
void follow_smooth_surface(const Shape& ball, const Shape& surface, const Vector3& centre, double margin,
                           const Vector3& shift, SurfaceManifolds& result) {
  const double reach = ball.radius + margin;
  const Nearest nearest = nearest_to(surface, centre, reach);
  if (!(nearest.distance <= reach)) return;
  const SmoothPlace start(nearest.triangle, centre, nearest.foot);
  Manifold* const replaced = replace_sheet(start.normal, result);
  if (replaced == nullptr) return;
  Manifold& manifold = *replaced;
  const Vector3 along = shift - shift.dot(start.normal) * start.normal;
  manifold.normal = start.normal;
  const Nearest ahead = nearest_to(surface, centre + along, reach + along.norm() * most_bend);
  if (ahead.distance < INFINITY) {
    const SmoothPlace end(ahead.triangle, centre + along, ahead.foot);
    if (start.normal.dot(end.normal) > least_bend_cosine) {
      manifold.normal = (start.normal + end.normal).normalized();
      manifold.rise = -0.5 * (end.normal - start.normal).dot(along);
    }
  }
  manifold.add(centre - ball.radius * manifold.normal, start.distance - ball.radius, single_point_id());
}

// Gives a ball one manifold for the facets that rise against it within the step. It takes the ball from the facet that
// it is on to where it touches the next one, as a surface does that bends evenly. A facet that is met only once the
// ball is in it would lift the ball by pushing it out, and that is energy from nowhere.
void follow_facets(const Shape& ball, const Shape& surface, const Vector3& centre, double margin, const Vector3& shift,
                   SurfaceManifolds& result) {
  const double reach = ball.radius + margin;
  const Nearest start = nearest_to(surface, centre, reach);
  if (!(start.distance <= reach) || !(start.distance > 0)) return;
  const Vector3 normal = (centre - start.foot) / start.distance;
  const Vector3 along = shift - shift.dot(normal) * normal;
  const double length = along.norm();
  const Nearest end = nearest_to(surface, centre + along, reach + most_bend * length);
  const double rise = start.distance - end.distance;  // minus infinity where none is in reach
  if (!(rise > least_bend * length) || rise > most_bend * length) return;
  Manifold* const manifold = replace_sheet(normal, result);
  if (manifold == nullptr) return;
  manifold->normal = (normal - rise / (length * length) * along).normalized();
  manifold->rise = rise;
  manifold->add(centre - ball.radius * manifold->normal, start.distance - ball.radius, single_point_id());
}

// How far a solid is from triangles at least, by its box and ball, up to a limit.
class SurfaceGap {
 public:
  SurfaceGap(const SurfaceSolid& solid, const Bounds& bounds, double most)
      : position_(solid.position), radius_(solid.shape.bounding_radius), bounds_(bounds), gap_(most) {}

  void look_at(const std::array<Vector3, 3>& triangle) {
    const auto& [a, b, c] = triangle;
    const Vector3 below = bounds_.lower - a.cwiseMax(b).cwiseMax(c);
    const Vector3 above = a.cwiseMin(b).cwiseMin(c) - bounds_.upper;
    const double boxes = below.cwiseMax(above).cwiseMax(0).norm();
    if (boxes >= gap_) return;
    const double ball = (closest_point_of_triangle(triangle, position_) - position_).norm() - radius_;
    gap_ = std::min(gap_, std::max(boxes, ball));
  }
  double gap() const { return gap_; }

 private:
  const Vector3& position_;
  double radius_;
  const Bounds& bounds_;
  double gap_;
};

Aabb grown(const Bounds& bounds, double margin) {
  const Vector3 around = Vector3::Constant(margin);
  return Aabb::around(bounds.lower - around, bounds.upper + around);
}

}  // namespace

bool is_smooth(const Shape& surface) {
  if (surface.kind == ShapeKind::Mesh) return surface.mesh != nullptr && surface.mesh->smooth_angle > 0;
  return surface.kind == ShapeKind::HeightField && surface.field != nullptr && surface.field->smooth;
}

double gap_of_ball(const Vector3& centre, double radius, const Shape& surface, double most) {
  if (!is_surface(surface.kind) || !centre.allFinite()) return 0;
  double square = (radius + most) * (radius + most);
  const auto look_at = [&](const std::array<Vector3, 3>& triangle) {
    square = std::min(square, (closest_point_of_triangle(triangle, centre) - centre).squaredNorm());
  };
  const Aabb around = grown({centre, centre}, radius + most);
  if (surface.kind == ShapeKind::Mesh) {
    const TriangleMesh& mesh = *surface.mesh;
    mesh.tree.query_boxes(around, [&](std::uint32_t number, const Aabb& box) {
      if (square_apart(box, {centre, centre}) >= square) return;
      const auto& [a, b, c] = mesh.triangles[number];
      look_at({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
    });
  } else {
    visit_near(surface, around, [&](std::uint32_t number) { look_at(face_of(surface, number).vertices); });
  }
  return std::max(0.0, std::sqrt(square) - radius);
}

void collide_surface(const Shape& solid, const Shape& surface, const Pose& solid_pose, double margin,
                     SurfaceManifolds& result, const Vector3& shift, double most_gap) {
  result.count = 0;
  result.gap = 0;
  if (!is_convex_solid(solid.kind) || !is_surface(surface.kind)) return;
  if (!solid_pose.position.allFinite() || !solid_pose.orientation.coeffs().allFinite()) return;
  const SurfaceSolid placed(solid, solid_pose);
  const Bounds bounds = bounds_of(solid, placed.position, placed.rotation);
  SurfaceClusters clusters(placed);
  TriangleContact contact;
  const double reach = solid.bounding_radius + margin;
  visit_near_ball(surface, grown(bounds, margin), placed.position, reach, [&](std::uint32_t number) {
    Triangle triangle = face_of(surface, number);
    double height = 0;
    if (!comes_near(placed, triangle, margin, height)) return;
    complete(surface, number, triangle);
    touch_triangle(placed, triangle, height, number, margin, contact);
    if (contact.part == TriangleAxis::Part::Vertex && contact.count > 0 &&
        !can_push_at_vertex(surface, triangle.vertices[static_cast<std::size_t>(contact.vertex)], contact.normal)) {
      return;
    }
    clusters.add(contact);
  });
  clusters.finish(result);
  if (solid.kind == ShapeKind::Sphere) {
    const auto follow = is_smooth(surface) ? follow_smooth_surface : follow_facets;
    follow(solid, surface, placed.position, margin, shift, result);
  }
  if (result.count > 0 || !(most_gap > 0)) return;
  SurfaceGap gap(placed, bounds, most_gap);
  visit_near(surface, grown(bounds, most_gap),
             [&](std::uint32_t number) { gap.look_at(face_of(surface, number).vertices); });
  result.gap = gap.gap();
}

}  // namespace atl::collision
