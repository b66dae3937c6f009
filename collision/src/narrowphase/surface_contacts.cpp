#include <collision/narrowphase/feature_id.h>
#include <collision/narrowphase/surface_contacts.h>
#include <collision/shapes/aabb.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/triangle_mesh.h>
#include <jobs/assert.h>

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

std::uint8_t material_of(const Shape& surface, std::uint32_t number) {
  return surface.kind == ShapeKind::Mesh ? surface.mesh->material(number) : surface.field->material(number);
}

Triangle triangle_of(const Shape& surface, std::uint32_t number) {
  return surface.kind == ShapeKind::Mesh ? surface.mesh->triangle(number) : surface.field->triangle(number);
}

// True if a triangle with this vertex reaches ahead of it along a direction, and so is touched first.
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
// A smooth surface that bends by more within a step is one that the ball hits: a quarter of a radian, and its cosine.
constexpr double max_bend = 0.25;
constexpr double min_bend_cosine = 0.96891242171064473;
// Part of a ball's radius by which it has to come into a facet in a step to meet it: more than rounding.
constexpr double min_depth = 1e-9;

// The triangle on whose front a point is nearest.
struct Nearest {
  double distance = INFINITY;  // m
  std::uint32_t number = 0;
  Vector3 foot;

  void look_at(std::uint32_t other, const Triangle& face, const Vector3& from) {
    const double height = face.normal.dot(from - face.vertices[0]);
    if (height < 0 || height * (1 - 1e-9) > distance) return;
    const Vector3 point = closest_point_of_triangle(face.vertices, from);
    const double away = (from - point).norm();
    if (!(away < distance)) return;
    distance = away;
    number = other;
    foot = point;
  }
};

// The triangles near a ball and near where it may be at the end of the step, from one query, if they aren't too many.
class NearBall {
 public:
  NearBall(const Shape& surface, const Vector3& shift, double reach)
      : surface_(surface), grown_by_((1 + max_bend) * shift.norm()) {
    is_whole_ = grown_by_ <= reach;
    if (!is_whole_) grown_by_ = 0;
  }

  double grown_by() const { return grown_by_; }
  void note(std::uint32_t number) {
    is_whole_ &= count_ < numbers_.size();
    if (is_whole_) numbers_[count_++] = number;
  }
  /// To a point no farther from the ball's centre than it shifts, within a reach that has grown as `max_bend` says.
  Nearest nearest_to(const Vector3& point, double reach) const {
    Nearest nearest;
    const auto look_at = [&](std::uint32_t number) { nearest.look_at(number, face_of(surface_, number), point); };
    if (is_whole_) {
      std::for_each(numbers_.begin(), numbers_.begin() + count_, look_at);
    } else {
      const Vector3 around = Vector3::Constant(reach);
      visit_near_ball(surface_, Aabb::around(point - around, point + around), point, reach, look_at);
    }
    return nearest;
  }

  /// Calls visit(number) for the triangles that a ball may touch on a way within the step.
  template <typename Visit>
  void visit_along(const Vector3& from, const Vector3& way, double radius, const Visit& visit) const {
    if (is_whole_) return void(std::for_each(numbers_.begin(), numbers_.begin() + count_, visit));
    const Vector3 to = from + way, around = Vector3::Constant(radius);
    visit_near(surface_, Aabb::around(from.cwiseMin(to) - around, from.cwiseMax(to) + around), visit);
  }

 private:
  const Shape& surface_;
  double grown_by_;  // m, by which the query has to reach farther
  bool is_whole_;
  std::size_t count_ = 0;
  std::array<std::uint32_t, 32> numbers_;
};

// The place where a smooth surface is met along its own normal from a point above one of its triangles. Over the
// triangle, the surface is the mean of the flat point and its projections onto the tangent planes at the corners. This
// is Phong tessellation (Boubekeur and Alexa, ACM Trans. Graph. 27, 2008) with the factor 1/2, which makes arcs exact
// to second order.
struct SmoothPlace {
  double distance;  // m
  Vector3 normal;

  SmoothPlace(const Shape& surface, const Nearest& nearest, const Vector3& from) {
    const Triangle triangle = triangle_of(surface, nearest.number);
    Vector3 foot = nearest.foot;
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

// In place of all that a ball's contacts say of the sheet that looks along a normal, one to be filled in, of the
// material of the nearest triangle; null if there is no room.
Manifold* replace_sheet(const Vector3& normal, std::uint8_t material, SurfaceManifolds& result) {
  const auto other_end =
      std::remove_if(result.manifolds.begin(), result.manifolds.begin() + result.count,
                     [&](const Manifold& manifold) { return manifold.normal.dot(normal) > same_sheet; });
  result.count = static_cast<int>(other_end - result.manifolds.begin());
  if (result.count == max_surface_manifolds) return nullptr;
  Manifold& manifold = result.manifolds[static_cast<std::size_t>(result.count++)];
  manifold = {};
  manifold.reference_is_second = true;
  manifold.material = material;
  return &manifold;
}

// Gives a ball the manifold of the smooth surface that it is nearest to.
void follow_smooth_surface(const Shape& ball, const Shape& surface, const Vector3& centre, double margin,
                           const Vector3& shift, const Nearest& nearest, const NearBall& near,
                           SurfaceManifolds& result) {
  const double reach = ball.radius + margin;
  if (!(nearest.distance <= reach)) return;
  const SmoothPlace start(surface, nearest, centre);
  Manifold* const replaced = replace_sheet(start.normal, material_of(surface, nearest.number), result);
  if (replaced == nullptr) return;
  Manifold& manifold = *replaced;
  const Vector3 along = shift - shift.dot(start.normal) * start.normal;
  manifold.normal = start.normal;
  const double reach_ahead = reach + along.norm() * max_bend;
  const Nearest ahead = near.nearest_to(centre + along, reach_ahead);
  if (ahead.distance <= reach_ahead) {
    const SmoothPlace end(surface, ahead, centre + along);
    if (start.normal.dot(end.normal) > min_bend_cosine) {
      manifold.normal = (start.normal + end.normal).normalized();
      manifold.rise = -0.5 * (end.normal - start.normal).dot(along);
    }
  }
  ATL_ASSERT(!(std::abs(manifold.normal.squaredNorm() - 1) > 1e-6), nearest.number, manifold.normal.norm());
  manifold.add(centre - ball.radius * manifold.normal, start.distance - ball.radius, single_point_id());
}

// The facet that a ball comes to first on a way.
struct Met {
  double part = INFINITY;  // of the way
  std::uint32_t number = 0;
  Vector3 normal;
  double offset = 0;  // m, of the plane along its normal

  void look_at(std::uint32_t other, const Triangle& face, double radius, const Vector3& from, const Vector3& way) {
    const double toward = -face.normal.dot(way);
    const double height = face.normal.dot(from - face.vertices[0]);
    if (!(toward > 0) || height < 0 || !(height - toward < (1 - min_depth) * radius)) return;
    const double after = std::max(0.0, (height - radius) / toward);
    if (!(after < part) || !lies_over(face, from + after * way, min_depth * radius)) return;
    part = after;
    number = other;
    normal = face.normal;
    offset = face.normal.dot(face.vertices[0]);
  }
};

// The rest of a way once a facet takes away what leads into it, between it and the facet before.
Vector3 along_facets(const Vector3& way, const Vector3& normal, const Vector3& last) {
  const Vector3 along = way - way.dot(normal) * normal;
  if (along.dot(last) >= 0) return along;
  const Vector3 crease = normal.cross(last);
  const double square = crease.squaredNorm();
  return square > 0 ? Vector3(way.dot(crease) / square * crease) : Vector3(Vector3::Zero());
}

// Gives a ball on facets a manifold for each facet that it comes to within the step. It is over them only later, and
// would be in them by then: what lifts it out is energy from nowhere.
void meet_facets(const Shape& ball, const Shape& surface, const Vector3& centre, double margin, const Vector3& shift,
                 const Nearest& nearest, const NearBall& near, SurfaceManifolds& result) {
  if (!(nearest.distance <= ball.radius + margin) || !(nearest.distance > 0)) return;
  const double radius = std::min(ball.radius, nearest.distance);  // sunk in, it comes to the next one as deep
  Vector3 place = centre, way = shift, last = (centre - nearest.foot) / nearest.distance;
  for (int round = 0; round < max_surface_manifolds && result.count < max_surface_manifolds; ++round) {
    Met met;
    near.visit_along(place, way, radius,
                     [&](std::uint32_t number) { met.look_at(number, face_of(surface, number), radius, place, way); });
    if (!(met.part <= 1)) return;
    place += met.part * way;
    way = along_facets((1 - met.part) * way, met.normal, last);
    last = met.normal;
    const double height = met.normal.dot(centre) - met.offset;
    const auto end = result.manifolds.begin() + result.count;
    const bool is_known = std::any_of(result.manifolds.begin(), end, [&](const Manifold& manifold) {
      return manifold.normal.dot(met.normal) > same_facet_cosine;
    });
    if (is_known || height < radius) continue;
    Manifold& manifold = result.manifolds[static_cast<std::size_t>(result.count++)];
    manifold = {};
    manifold.reference_is_second = true;
    manifold.material = material_of(surface, met.number);
    manifold.normal = met.normal;
    manifold.add(centre - ball.radius * met.normal, height - ball.radius, single_point_id());
  }
}

// A lower bound of a solid's distance from triangles, by its box and ball, up to a limit.
class SurfaceGap {
 public:
  SurfaceGap(const SurfaceSolid& solid, const Bounds& bounds, double max)
      : position_(solid.position), radius_(solid.shape.bounding_radius), bounds_(bounds), gap_(max) {}

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

double gap_of_ball(const Vector3& centre, double radius, const Shape& surface, double max) {
  if (!is_surface(surface.kind) || !centre.allFinite()) return 0;
  double square = (radius + max) * (radius + max);
  const auto look_at = [&](const std::array<Vector3, 3>& triangle) {
    square = std::min(square, (closest_point_of_triangle(triangle, centre) - centre).squaredNorm());
  };
  const Aabb around = grown({centre, centre}, radius + max);
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
                     SurfaceManifolds& result, const Vector3& shift, double max_gap) {
  result.count = 0;
  result.gap = 0;
  if (!is_convex_solid(solid.kind) || !is_surface(surface.kind)) return;
  if (!solid_pose.position.allFinite() || !solid_pose.orientation.coeffs().allFinite()) return;
  const SurfaceSolid placed(solid, solid_pose);
  const Bounds bounds = bounds_of(solid, placed.position, placed.rotation);
  SurfaceClusters clusters(placed);
  TriangleContact contact;
  const double reach = solid.bounding_radius + margin;
  const bool is_ball = solid.kind == ShapeKind::Sphere;
  NearBall near(surface, is_ball ? shift : Vector3::Zero(), reach);
  Nearest nearest;
  const double farther = near.grown_by();
  visit_near_ball(
      surface, grown(bounds, margin + farther), placed.position, reach + farther, [&](std::uint32_t number) {
        Triangle triangle = face_of(surface, number);
        if (is_ball) {
          near.note(number);
          nearest.look_at(number, triangle, placed.position);
        }
        double height = 0;
        if (!comes_near(placed, triangle, margin, height)) return;
        complete(surface, number, triangle);
        touch_triangle(placed, triangle, height, number, margin, contact);
        contact.material = material_of(surface, number);
        if (contact.part == TriangleAxis::Part::Vertex && contact.count > 0 &&
            !can_push_at_vertex(surface, triangle.vertices[static_cast<std::size_t>(contact.vertex)], contact.normal)) {
          return;
        }
        clusters.add(contact);
      });
  clusters.finish(result);
  if (is_ball) {
    const auto follow = is_smooth(surface) ? follow_smooth_surface : meet_facets;
    follow(solid, surface, placed.position, margin, shift, nearest, near, result);
  }
  if (result.count > 0 || !(max_gap > 0)) return;
  SurfaceGap gap(placed, bounds, max_gap);
  visit_near(surface, grown(bounds, max_gap),
             [&](std::uint32_t number) { gap.look_at(face_of(surface, number).vertices); });
  result.gap = gap.gap();
}

}  // namespace atl::collision
