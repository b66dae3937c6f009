#include <collision/narrowphase/support_feature.h>
#include <jobs/assert.h>

#include <array>
#include <cmath>

namespace atl::collision {
namespace {

constexpr double diagonal = 0.70710678118654752;
constexpr int rim_points = 8;
constexpr std::array<std::array<double, 2>, rim_points> rim = {{{1, 0},
                                                                {diagonal, diagonal},
                                                                {0, 1},
                                                                {-diagonal, diagonal},
                                                                {-1, 0},
                                                                {-diagonal, -diagonal},
                                                                {0, -1},
                                                                {diagonal, -diagonal}}};

constexpr int line_on_side = 2;

// A disc lies flat as long as its fixed points miss less than this part of the inner radius of its depth.
constexpr double flat_miss = 2e-5;

Vector3 cone_side_normal(const Shape& cone, const Vector3& outwards) {
  return (2 * cone.half_height * outwards + cone.radius * Vector3::UnitZ()) /
         length_2d(cone.radius, 2 * cone.half_height);
}

// Radial part and part along z of a tapered capsule's normals between its balls: of the cone around both.
struct SideNormal {
  double across, up;
};
SideNormal side_of_tapered(const Shape& shape) {
  const double up = (shape.radius - shape.top_radius) / (2 * shape.half_height);
  return {std::sqrt((1 - up) * (1 + up)), up};
}

// Counter-clockwise seen from outside. Once tilted, the point nearest to the rim's farthest moves there. Others would
// be in the way of a disc that rolls, as if it had corners.
void disc_outline(double radius, double height, double inner_radius, bool up, const Vector3& direction, double reach,
                  Outline& outline) {
  const double tilt = length_2d(direction.x(), direction.y());
  int moved = -1;
  constexpr double max_miss = 0.0761204674887133;  // 1 - cos(22.5 degrees)
  if (tilt * radius * max_miss > flat_miss * inner_radius) {
    double farthest = -1;
    for (int i = 0; i < rim_points; ++i) {
      const auto& p = rim[static_cast<std::size_t>(i)];
      const double far = p[0] * direction.x() + p[1] * direction.y();
      if (far <= farthest) continue;
      farthest = far;
      moved = i;
    }
  }
  const bool alone = moved >= 0 && 2 * radius * tilt > reach;
  for (int i = 0; i < rim_points; ++i) {
    const int k = up ? i : (rim_points - i) % rim_points;
    if (alone && k != moved) continue;
    const auto& p = rim[static_cast<std::size_t>(k)];
    const Vector3 position = k == moved ? Vector3(radius / tilt * direction.x(), radius / tilt * direction.y(), height)
                                        : Vector3(radius * p[0], radius * p[1], height);
    // One that is alone goes along the rim and stays what it is.
    const auto before = static_cast<std::uint16_t>(alone ? rim_points : (k + rim_points - 1) % rim_points);
    const auto after = static_cast<std::uint16_t>(alone ? rim_points : k);
    outline.add(up ? OutlineCorner{position, before, after} : OutlineCorner{position, after, before});
  }
}

void disc_polygon(double radius, double height, bool up, FacePolygon& face) {
  constexpr double widened = 1.0195911582083184;  // 1 / cos(11.25 degrees)
  constexpr double c = 0.98078528040323044;       // cos and sin of it
  constexpr double s = 0.19509032201612827;
  for (int i = 0; i < 2 * rim_points; ++i) {
    const int k = up ? i : 2 * rim_points - 1 - i;
    const auto& p = rim[static_cast<std::size_t>(k / 2)];
    const double side = k % 2 == 0 ? -s : s;
    const double r = widened * radius;
    face.add({r * (c * p[0] - side * p[1]), r * (side * p[0] + c * p[1]), height});
  }
}

// Takes a face that looks along a direction more directly than the best so far.
void consider(const Polytope& core, int face, const Vector3& direction, FlatFace& best) {
  const Vector3& normal = core.planes[face].normal;
  const double cosine = normal.dot(direction);
  if (cosine > best.cosine) best = {face, normal, cosine};
}

FlatFace best_plane(const Polytope& core, const Vector3& direction) {
  FlatFace best;
  for (int face = 0; face < core.face_count; ++face) consider(core, face, direction, best);
  return best;
}

}  // namespace

FlatFace flat_face_at(const Polytope& core, int vertex, const Vector3& unit_direction) {
  FlatFace best;
  core.for_each_face_at(vertex, [&](int face) { consider(core, face, unit_direction, best); });
  return best;
}

FlatFace flat_face(const Shape& shape, const Polytope& core, int number, const Vector3& unit_direction) {
  FlatFace face;
  switch (shape.kind) {
    case ShapeKind::Cylinder:
      if (number < 0 || number > 1) return face;
      face.normal = number == 0 ? Vector3(Vector3::UnitZ()) : Vector3(-Vector3::UnitZ());
      break;
    case ShapeKind::Cone:
      if (number != 0) return face;
      face.normal = -Vector3::UnitZ();
      break;
    case ShapeKind::Sphere:
    case ShapeKind::Capsule:
    case ShapeKind::Ellipsoid:
    case ShapeKind::TaperedCapsule:
      return face;
    default:
      if (number < 0 || number >= core.face_count) return face;
      face.normal = core.planes[number].normal;
      break;
  }
  face.number = number;
  face.cosine = face.normal.dot(unit_direction);
  return face;
}

FlatFace flat_face_along(const Shape& shape, const Polytope& core, const Vector3& unit_direction) {
  switch (shape.kind) {
    case ShapeKind::Cylinder:
      return flat_face(shape, core, unit_direction.z() < 0 ? 1 : 0, unit_direction);
    case ShapeKind::Cone:
      return flat_face(shape, core, 0, unit_direction);
    case ShapeKind::Sphere:
    case ShapeKind::Capsule:
    case ShapeKind::Ellipsoid:
    case ShapeKind::TaperedCapsule:
      return {};
    default:
      return best_plane(core, unit_direction);
  }
}

void face_polygon(const Shape& shape, const Polytope& core, int number, FacePolygon& face) {
  face.number = number;
  face.count = 0;
  if (shape.kind == ShapeKind::Cylinder || shape.kind == ShapeKind::Cone) {
    const bool up = shape.kind == ShapeKind::Cylinder && number == 0;
    face.normal = up ? Vector3(Vector3::UnitZ()) : Vector3(-Vector3::UnitZ());
    face.offset = shape.half_height;
    disc_polygon(shape.radius, up ? shape.half_height : -shape.half_height, up, face);
    return;
  }
  ATL_ASSERT(number >= 0 && number < core.face_count, number, core.face_count);
  ATL_ASSERT(core.face_size(number) >= 3 && core.face_size(number) <= max_face_corners, number, core.face_size(number));
  face.normal = core.planes[number].normal;
  face.offset = core.planes[number].offset;
  for (int i = core.face_start[number]; i < core.face_start[number + 1]; ++i) {
    face.add(core.vertices[core.face_vertices[i]]);
  }
}

int incident_outline(const Shape& shape, const Polytope& core, const Vector3& unit_direction, double reach,
                     Outline& outline, int vertex) {
  outline.count = 0;
  const double r = shape.radius;
  const double h = shape.half_height;
  const Vector3 outwards = outwards_from_axis(unit_direction);
  switch (shape.kind) {
    case ShapeKind::Sphere:
      outline.add_end(r * unit_direction);
      return line_on_side;
    case ShapeKind::Capsule:
      outline.add_end(Vector3(0, 0, -h) + r * unit_direction);
      outline.add_end(Vector3(0, 0, h) + r * unit_direction);
      return line_on_side;
    case ShapeKind::Ellipsoid:
      outline.add_end(support_point(shape, unit_direction));
      return line_on_side;
    case ShapeKind::TaperedCapsule:
      outline.add_end(Vector3(0, 0, -h) + r * unit_direction);
      outline.add_end(Vector3(0, 0, h) + shape.top_radius * unit_direction);
      return line_on_side;
    case ShapeKind::Cylinder: {
      const bool up = unit_direction.z() > 0;
      if (std::abs(unit_direction.z()) > outwards.dot(unit_direction)) {
        disc_outline(r, up ? h : -h, shape.inner_radius, up, unit_direction, reach, outline);
        return up ? 0 : 1;
      }
      outline.add_end(r * outwards - h * Vector3::UnitZ());
      outline.add_end(r * outwards + h * Vector3::UnitZ());
      return line_on_side;
    }
    case ShapeKind::Cone:
      if (-unit_direction.z() > cone_side_normal(shape, outwards).dot(unit_direction)) {
        disc_outline(r, -h, shape.inner_radius, false, unit_direction, reach, outline);
        return 0;
      }
      outline.add_end(r * outwards - h * Vector3::UnitZ());
      outline.add_end(h * Vector3::UnitZ());
      return line_on_side;
    default: {
      const FlatFace face = vertex < 0 ? best_plane(core, unit_direction) : flat_face_at(core, vertex, unit_direction);
      if (face.number < 0) return 0;
      const int size = core.face_size(face.number);
      const int start = core.face_start[face.number];
      for (int i = 0; i < size; ++i) outline.add_face_corner(core.vertices[core.face_vertices[start + i]], size);
      return face.number;
    }
  }
}

SideLine side_line(const Shape& shape, const Vector3& unit_direction) {
  constexpr double sine = 0.1410673597966589;  // of the angle with cosine same_direction
  const double r = shape.radius;
  const Vector3 end = shape.half_height * Vector3::UnitZ();
  const Vector3 outwards = outwards_from_axis(unit_direction);
  switch (shape.kind) {
    case ShapeKind::Capsule:
      return {std::abs(unit_direction.z()) < sine, r * unit_direction - end, r * unit_direction + end};
    case ShapeKind::Cylinder:
      return {std::abs(unit_direction.z()) < sine, r * outwards - end, r * outwards + end};
    case ShapeKind::Cone:
      return {cone_side_normal(shape, outwards).dot(unit_direction) > same_direction, r * outwards - end, end};
    case ShapeKind::TaperedCapsule: {
      const auto [radial, up] = side_of_tapered(shape);
      const bool faces = (radial * outwards + up * Vector3::UnitZ()).dot(unit_direction) > same_direction;
      return {faces, r * unit_direction - end, shape.top_radius * unit_direction + end};
    }
    default:
      return {false, Vector3::Zero(), Vector3::Zero()};
  }
}

}  // namespace atl::collision
