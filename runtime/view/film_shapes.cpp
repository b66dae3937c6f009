#include "view/film_shapes.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <type_traits>
#include <utility>

#include "view/json_numbers.h"
#include "view/packed.h"
#include "view/triangles.h"

namespace atl::view {
namespace {

Json object_of(const Sphere& ball) { return {{"type", "sphere"}, {"radius", ball.radius}}; }
Json object_of(const Box& box) { return {{"type", "box"}, {"half", numbers(box.half_extents)}}; }
Json object_of(const HalfSpace& half_space) {
  return {{"type", "half-space"},
          {"normal", numbers(half_space.normal.stableNormalized())},
          {"offset", half_space.offset / half_space.normal.stableNorm()}};
}
Json round_object(const char* type, double radius, double half_height) {
  return {{"type", type}, {"radius", radius}, {"half_height", half_height}};
}
Json object_of(const Capsule& of) { return round_object("capsule", of.radius, of.half_height); }
Json object_of(const Cylinder& of) { return round_object("cylinder", of.radius, of.half_height); }
Json object_of(const Cone& of) { return round_object("cone", of.radius, of.half_height); }

Json object_of(const Ellipsoid& of) { return {{"type", "ellipsoid"}, {"half", numbers(of.half_axes)}}; }
Json object_of(const TaperedCapsule& of) {
  return {{"type", "tapered_capsule"}, {"radii", of.radii}, {"half_height", of.half_height}};
}

Json object_of(const Triangles& surface, const char* type) {
  Packer vertices, indices;
  for (const Vector3& vertex : surface.vertices) {
    for (int i = 0; i < 3; ++i) vertices.add(static_cast<float>(vertex[i]));
  }
  for (const auto& triangle : surface.triangles) indices.add(triangle.data(), sizeof triangle);
  return {{"type", type}, {"vertices", vertices.text()}, {"triangles", indices.text()}};
}

Shape as_shape(const ConvexShape& shape) {
  return std::visit([](const auto& kind) { return Shape(kind); }, shape);
}

template <typename Kind>
constexpr bool has_geometry =
    std::is_same_v<Kind, ConvexHull> || std::is_same_v<Kind, TriangleMesh> || std::is_same_v<Kind, HeightField>;

}  // namespace

std::uint32_t FilmShapes::number_of_text(std::string text) {
  const auto [place, fresh] = numbers_.try_emplace(std::move(text), static_cast<std::uint32_t>(texts_.size()));
  if (fresh) texts_.push_back(place->first);
  return place->second;
}

std::uint32_t FilmShapes::number_of(const Shape& shape) {
  return std::visit(
      [&]<typename Kind>(const Kind& kind) {
        if constexpr (has_geometry<Kind>) {
          const auto known = of_geometry_.find(kind.data().get());
          if (known != of_geometry_.end()) return known->second.number;
          const char* type = std::is_same_v<Kind, ConvexHull> ? "hull" : "mesh";
          const std::uint32_t number = number_of_text(object_of(triangles_of(kind), type).dump());
          of_geometry_.emplace(kind.data().get(), Geometry{kind.data(), number});
          return number;
        } else if constexpr (std::is_same_v<Kind, Compound>) {
          Json children = Json::array();
          for (const CompoundChild& child : kind.children) {
            children.push_back({{"shape", number_of(as_shape(child.shape))},
                                {"position", numbers(child.position)},
                                {"orientation", numbers(child.orientation.normalized())}});
          }
          return number_of_text(Json{{"type", "compound"}, {"children", children}}.dump());
        } else {
          return number_of_text(object_of(kind).dump());
        }
      },
      shape);
}

double reach_of(const Shape& shape) {
  if (std::holds_alternative<HalfSpace>(shape)) return 0;
  double square = 0;
  for (const Vector3& vertex : triangles_of(shape).vertices) square = std::max(square, vertex.squaredNorm());
  return std::sqrt(square);
}

}  // namespace atl::view
