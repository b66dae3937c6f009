#include <collision/narrowphase/clip.h>
#include <collision/narrowphase/feature_id.h>
#include <jobs/assert.h>

#include <algorithm>
#include <utility>

namespace atl::collision {
namespace {

// The distances of points from one side of a face, positive outside.
struct Side {
  Vector3 outward;
  double offset;
  std::uint16_t edge;

  double outside(const Vector3& p) const { return outward.dot(p) - offset; }
};

OutlineCorner crossing(const OutlineCorner& from, const OutlineCorner& to, double from_outside, double to_outside) {
  ATL_ASSERT(from_outside != to_outside, from_outside);
  const double t = std::clamp(from_outside / (from_outside - to_outside), 0.0, 1.0);
  return {from.position + t * (to.position - from.position), 0, 0};
}

void clip_polygon(const Outline& outline, const Side& side, double slack, Outline& result) {
  ATL_ASSERT(outline.count >= 3 && outline.count < Outline::capacity, outline.count);  // corners beyond would be lost
  result.count = 0;
  const auto last = static_cast<std::size_t>(outline.count - 1);
  double to_outside = side.outside(outline.corners[0].position);
  for (std::size_t i = 0; i <= last; ++i) {
    const OutlineCorner& from = outline.corners[i];
    const OutlineCorner& to = outline.corners[i == last ? 0 : i + 1];
    const double from_outside = to_outside;
    to_outside = side.outside(to.position);
    const bool from_in = from_outside <= slack;
    const bool to_in = to_outside <= slack;
    if (from_in) result.add(from);
    if (from_in == to_in) continue;
    OutlineCorner cut = crossing(from, to, from_outside, to_outside);
    cut.edge_in = from_in ? from.edge_out : side.edge;
    cut.edge_out = from_in ? side.edge : from.edge_out;
    result.add(cut);
  }
}

void clip_segment(Outline& outline, const Side& side, double slack) {
  ATL_ASSERT(outline.count == 2, outline.count);
  const double first = side.outside(outline.corners[0].position);
  const double second = side.outside(outline.corners[1].position);
  if (first > slack && second > slack) outline.count = 0;
  if ((first > slack) == (second > slack)) return;
  const std::size_t out = first > slack ? 0 : 1;
  OutlineCorner cut = crossing(outline.corners[0], outline.corners[1], first, second);
  cut.edge_in = static_cast<std::uint16_t>(out);
  cut.edge_out = side.edge;
  outline.corners[out] = cut;
}

}  // namespace

void Outline::add_face_corner(const Vector3& position, int face_size) {
  add({position, static_cast<std::uint16_t>((count + face_size - 1) % face_size), static_cast<std::uint16_t>(count)});
}

void Outline::add_end(const Vector3& position) {
  add({position, static_cast<std::uint16_t>(count), static_cast<std::uint16_t>(count)});
}

void clip(Outline& outline, const FacePolygon& face, double slack) {
  ATL_ASSERT(face.count >= 3 && face.count <= max_face_corners, face.number, face.count);
  ATL_ASSERT(!(slack < 0), slack);
  Outline spare;
  Outline* current = &outline;
  Outline* other = &spare;
  for (int i = 0; i < face.count && current->count > 0; ++i) {
    const Vector3& tail = face.corners[static_cast<std::size_t>(i)];
    const Vector3& head = face.corners[static_cast<std::size_t>(i + 1 == face.count ? 0 : i + 1)];
    const Vector3 across = (head - tail).cross(face.normal);
    const double length = across.norm();
    if (!(length > 0)) continue;
    const Vector3 outward = across / length;
    const Side side{outward, outward.dot(tail), static_cast<std::uint16_t>(reference_edge | i)};
    const bool cuts = std::any_of(current->corners.begin(), current->corners.begin() + current->count,
                                  [&](const OutlineCorner& corner) { return side.outside(corner.position) > slack; });
    if (!cuts) continue;
    if (current->count <= 2) {
      if (current->count == 2) {
        clip_segment(*current, side, slack);
      } else {
        current->count = 0;
      }
      continue;
    }
    clip_polygon(*current, side, slack, *other);
    std::swap(current, other);
  }
  if (current == &outline) return;
  outline.count = current->count;
  std::copy_n(current->corners.begin(), current->count, outline.corners.begin());
}

void face_points(const Outline& outline, const FacePolygon& face, int incident_face, double margin,
                 Manifold& manifold) {
  ATL_ASSERT(!(std::abs(face.normal.squaredNorm() - 1) > 1e-6), face.number, face.normal.norm());
  std::array<Manifold::Point, Outline::capacity> points;
  int count = 0;
  for (int i = 0; i < outline.count; ++i) {
    const OutlineCorner& corner = outline.corners[static_cast<std::size_t>(i)];
    const double separation = face.normal.dot(corner.position) - face.offset;
    if (!(separation <= margin)) continue;
    const FeatureId id =
        face_point_id(manifold.reference_is_second, face.number, incident_face, corner.edge_in, corner.edge_out);
    points[static_cast<std::size_t>(count++)] = {corner.position, separation, id};
  }
  manifold.normal = face.normal;
  reduce_points(points.data(), count, manifold);
}

}  // namespace atl::collision
