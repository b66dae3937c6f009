// Rays, shapes that are moved, overlaps and closest points, one at a time or in arrays.

#include <atoll/queries.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.h"
#include "fields.h"
#include "parts.h"

namespace atl::python {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A QueryFilter that owns what it looks at.
struct Filter {
  std::uint32_t category = ~0u;
  std::uint32_t mask = ~0u;
  bool static_bodies = true;
  bool kinematic_bodies = true;
  bool dynamic_bodies = true;
  bool sensors = false;
  std::vector<BodyId> ignore = {};
  std::optional<BodyId> as = {};
  std::optional<std::function<bool(BodyId, std::uint32_t)>> predicate = {};

  QueryFilter filter() const {
    return {.category = category,
            .mask = mask,
            .static_bodies = static_bodies,
            .kinematic_bodies = kinematic_bodies,
            .dynamic_bodies = dynamic_bodies,
            .sensors = sensors,
            .ignore = ignore,
            .as = as,
            .predicate = predicate.value_or(nullptr)};
  }
};

// A row of the array that a batch of rays comes to.
struct RayRecord {
  BodyId body;
  std::uint32_t child = 0;
  bool hit = false;
  bool started_inside = false;
  double distance = infinity;
  Vector3 point = Vector3::Zero();
  Vector3 normal = Vector3::Zero();
  std::int64_t triangle = -1;
};

RayRecord record_of(const std::optional<RayHit>& hit) {
  if (!hit) return {};
  return {.body = hit->body,
          .child = hit->child,
          .hit = true,
          .started_inside = hit->started_inside,
          .distance = hit->distance,
          .point = hit->point,
          .normal = hit->normal,
          .triangle = hit->triangle ? static_cast<std::int64_t>(*hit->triangle) : -1};
}

std::vector<Ray> rays_of(const Rows<3>& origins, const Rows<3>& directions, double max_distance, bool both_sides) {
  if (origins.shape(0) != directions.shape(0)) {
    throw Error("World.cast_rays: found " + std::to_string(origins.shape(0)) + " origins and " +
                std::to_string(directions.shape(0)) + " directions; expected as many of both");
  }
  std::vector<Ray> rays;
  rays.reserve(origins.shape(0));
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(origins.shape(0)); ++i) {
    rays.push_back({columns_of<3>(origins).col(i), columns_of<3>(directions).col(i), max_distance, both_sides});
  }
  return rays;
}

// Functions of Python are asked under its lock, which who waits for other threads must not hold.
template <typename Ask>
auto ask(const Filter& filter, const Ask& question) {
  const QueryFilter of = filter.filter();
  const nb::gil_scoped_release release;
  return question(of);
}

void bind_hits(nb::module_& module) {
  nb::class_<Filter> filter(module, "QueryFilter", "Which bodies count for a query.");
  bind_definition(filter, Field{"category", &Filter::category, "32 bits"}, Field{"mask", &Filter::mask, "32 bits"},
                  Field{"static_bodies", &Filter::static_bodies, ""},
                  Field{"kinematic_bodies", &Filter::kinematic_bodies, ""},
                  Field{"dynamic_bodies", &Filter::dynamic_bodies, ""}, Field{"sensors", &Filter::sensors, ""},
                  Field{"ignore", &Filter::ignore, "bodies"},
                  Field{"as_body", &Filter::as, "finds only what this body may touch, in place of category and mask"},
                  Field{"predicate", &Filter::predicate, "of a body and the number of a child; may not raise"});
  nb::class_<RayHit> ray(module, "RayHit", "What a ray met.");
  bind_result(ray, Field{"body", &RayHit::body, ""}, Field{"child", &RayHit::child, "in a compound"},
              Field{"distance", &RayHit::distance, "m"}, Field{"point", &RayHit::point, "m, shape (3,)"},
              Field{"normal", &RayHit::normal, "shape (3,), of the side that was hit"},
              Field{"triangle", &RayHit::triangle, "of a mesh or height field"},
              Field{"started_inside", &RayHit::started_inside, "then the normal is the shortest way out"},
              Field{"depth", &RayHit::depth, "m, how far that is, else 0"});
  nb::class_<ShapeHit> shape(module, "ShapeHit", "What a moved shape met.");
  bind_result(shape, Field{"body", &ShapeHit::body, ""}, Field{"child", &ShapeHit::child, "in a compound"},
              Field{"distance", &ShapeHit::distance, "m, that it can be moved"},
              Field{"point", &ShapeHit::point, "m, shape (3,), on the body"},
              Field{"normal", &ShapeHit::normal, "shape (3,), from the body to the shape"},
              Field{"triangle", &ShapeHit::triangle, "of a mesh or height field"},
              Field{"started_overlapping", &ShapeHit::started_overlapping, "then the normal is the shortest way out"},
              Field{"depth", &ShapeHit::depth, "m, how far that is, else 0"});
  nb::class_<ClosestPoint> closest(module, "ClosestPoint", "What is closest to a shape.");
  bind_result(closest, Field{"body", &ClosestPoint::body, ""}, Field{"child", &ClosestPoint::child, "in a compound"},
              Field{"distance", &ClosestPoint::distance, "m, below 0 where they overlap"},
              Field{"on_body", &ClosestPoint::on_body, "m, shape (3,)"},
              Field{"on_shape", &ClosestPoint::on_shape, "m, shape (3,)"},
              Field{"normal", &ClosestPoint::normal, "shape (3,), from the body to the shape"},
              Field{"triangle", &ClosestPoint::triangle, "of a mesh or height field"});
}

template <auto cast>
void bind_ray(nb::class_<World>& world, const char* name, const char* doc) {
  world.def(
      name,
      [](const World& self, const Vector3& origin, const Vector3& direction, double max_distance, bool both_sides,
         const Filter& filter) {
        return ask(filter, [&](const QueryFilter& of) {
          return (Queries(self).*cast)({origin, direction, max_distance, both_sides}, of);
        });
      },
      nb::arg("origin"), nb::arg("direction"), nb::arg("max_distance") = infinity, nb::arg("both_sides") = false,
      nb::arg("filter") = Filter{}, doc);
}

void bind_rays(nb::class_<World>& world) {
  bind_ray<&Queries::cast_ray>(world, "cast_ray",
                               "The first that a ray meets, or None. m, shape (3,); directions of any length.");
  bind_ray<&Queries::cast_ray_through>(world, "cast_ray_through", "All that it meets, by distance.");
  world.def(
      "cast_rays",
      [](const World& self, const Rows<3>& origins, const Rows<3>& directions, double max_distance, bool both_sides,
         const Filter& filter) {
        const std::vector<Ray> rays = rays_of(origins, directions, max_distance, both_sides);
        const std::vector<RayRecord> records = ask(filter, [&](const QueryFilter& of) {
          std::vector<RayRecord> found;
          for (const std::optional<RayHit>& hit : Queries(self).cast_rays(rays, of)) found.push_back(record_of(hit));
          return found;
        });
        static const std::vector<Member> members = {
            {"body", "id", offsetof(RayRecord, body)},
            {"child", "u4", offsetof(RayRecord, child)},
            {"hit", "?", offsetof(RayRecord, hit)},
            {"started_inside", "?", offsetof(RayRecord, started_inside)},
            {"distance", "f8", offsetof(RayRecord, distance)},
            {"point", "(3,)f8", offsetof(RayRecord, point)},
            {"normal", "(3,)f8", offsetof(RayRecord, normal)},
            {"triangle", "i8", offsetof(RayRecord, triangle)},
        };
        return records_of(std::span<const RayRecord>(records), members);
      },
      nb::arg("origins"), nb::arg("directions"), nb::arg("max_distance") = infinity, nb::arg("both_sides") = false,
      nb::arg("filter") = Filter{},
      "Many at once, by the world's threads. m, shape (n, 3). A structured array: one record a ray: hit, body, "
      "child, "
      "distance (infinite without a hit), point, normal, triangle (-1 for none), started_inside.",
      nb::sig("def cast_rays(self, origins: numpy.typing.NDArray[numpy.float64], directions: "
              "numpy.typing.NDArray[numpy.float64], max_distance: float = ..., both_sides: bool = False, filter: "
              "QueryFilter = ...) -> numpy.typing.NDArray[numpy.void]"));
}

void bind_casts(nb::class_<World>& world) {
  const Quaternion upright = Quaternion::Identity();
  world
      .def(
          "cast_shape",
          [](const World& self, const ConvexShape& shape, const Vector3& position, const Vector3& translation,
             const Quaternion& orientation, const Filter& filter) {
            return ask(filter, [&](const QueryFilter& of) {
              return Queries(self).cast_shape({shape, position, orientation, translation}, of);
            });
          },
          nb::arg("shape"), nb::arg("position"), nb::arg("translation"), nb::arg("orientation") = upright,
          nb::arg("filter") = Filter{}, "The first that a convex shape meets that is moved straight (m), or None.")
      .def(
          "overlapping",
          [](const World& self, const std::optional<ConvexShape>& shape, const Vector3& position,
             const Quaternion& orientation, const Filter& filter) {
            return ask(filter, [&](const QueryFilter& of) {
              return Queries(self).overlapping(QueryShape{shape, position, orientation}, of);
            });
          },
          nb::arg("shape").none(), nb::arg("position"), nb::arg("orientation") = upright, nb::arg("filter") = Filter{},
          "Bodies that touch or overlap a convex shape, or a point if it is None, in order.")
      .def(
          "closest_point",
          [](const World& self, const std::optional<ConvexShape>& shape, const Vector3& position, double max_distance,
             const Quaternion& orientation, const Filter& filter) {
            return ask(filter, [&](const QueryFilter& of) {
              return Queries(self).closest_point({shape, position, orientation}, max_distance, of);
            });
          },
          nb::arg("shape").none(), nb::arg("position"), nb::arg("max_distance"), nb::arg("orientation") = upright,
          nb::arg("filter") = Filter{}, "What is closest to it, or deepest in it, up to a distance (m), or None.")
      .def(
          "nearby",
          [](const World& self, const std::optional<ConvexShape>& shape, const Vector3& position, double max_distance,
             const Quaternion& orientation, const Filter& filter) {
            return ask(filter, [&](const QueryFilter& of) {
              return Queries(self).nearby({shape, position, orientation}, max_distance, of);
            });
          },
          nb::arg("shape").none(), nb::arg("position"), nb::arg("max_distance") = 0.0, nb::arg("orientation") = upright,
          nb::arg("filter") = Filter{},
          "The closest point of each body within a distance (m), by distance; below 0 where they overlap.");
}

}  // namespace

void bind_queries(nb::module_& module) {
  bind_hits(module);
  auto world = nb::borrow<nb::class_<World>>(module.attr("World"));
  bind_rays(world);
  bind_casts(world);
}

}  // namespace atl::python
