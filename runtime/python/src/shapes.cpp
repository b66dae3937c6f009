// Shapes, and what a body starts with.

#include "shapes.h"

#include <atoll/atoll.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "arrays.h"
#include "fields.h"
#include "parts.h"

namespace atl::python {
namespace {

using Indices = ArrayLike<std::uint32_t, nb::shape<-1, 3>>;

std::span<const Vector3> points_of(const Rows<3>& rows) {
  static_assert(sizeof(Vector3) == 3 * sizeof(double));
  return {reinterpret_cast<const Vector3*>(rows.data()), rows.shape(0)};
}

nb::object rows_of(std::span<const Vector3> points) {
  const double none = 0;
  return nb::steal(array_of(points.empty() ? &none : points.front().data(), {points.size(), 3}));
}

// Geometry never changes, so its copies are itself.
template <typename Geometry>
void bind_copies(nb::class_<Geometry>& type) {
  const std::string name = nb::cast<std::string>(type.attr("__name__"));
  const std::string copy = "def __copy__(self) -> " + name;
  const std::string deep = "def __deepcopy__(self, memo: dict[int, object]) -> " + name;
  type.def(
          "__copy__", [](nb::object self) { return self; }, nb::sig(copy.c_str()))
      .def(
          "__deepcopy__", [](nb::object self, const nb::dict&) { return self; }, nb::sig(deep.c_str()));
}

#define ATOLL_SURFACE \
  "numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.uint32], float, collections.abc.Sequence[int]"
#define ATOLL_HEIGHTS "numpy.typing.NDArray[numpy.float64], float, float, bool, collections.abc.Sequence[int]"

using Numbers = std::vector<std::uint8_t>;
template <typename Surface>
Numbers materials_of(const Surface& self) {
  return {self.materials().begin(), self.materials().end()};
}

void bind_solids(nb::module_& module) {
  nb::class_<Box> box(module, "Box", "Centred at the body's origin, edges along its axes.");
  bind_struct(box, Field{"half_extents", &Box::half_extents, "m, shape (3,), each > 0"});
  nb::class_<Sphere> sphere(module, "Sphere", "Centred at the body's origin.");
  bind_struct(sphere, Field{"radius", &Sphere::radius, "m, > 0"});
  nb::class_<HalfSpace> half_space(module, "HalfSpace",
                                   "All points p with normal . p <= offset are solid. Of static and kinematic bodies.");
  bind_struct(half_space, Field{"normal", &HalfSpace::normal, "shape (3,), not zero"},
              Field{"offset", &HalfSpace::offset, "m"});
  nb::class_<Capsule> capsule(
      module, "Capsule",
      "All points within the radius of the segment from (0, 0, -half_height) to (0, 0, half_height).");
  bind_struct(capsule, Field{"radius", &Capsule::radius, "m, > 0"},
              Field{"half_height", &Capsule::half_height, "m, > 0"});
  nb::class_<Cylinder> cylinder(module, "Cylinder", "About the z axis, centred at the body's origin.");
  bind_struct(cylinder, Field{"radius", &Cylinder::radius, "m, > 0"},
              Field{"half_height", &Cylinder::half_height, "m, > 0"});
  nb::class_<Cone> cone(module, "Cone", "About the z axis: its base at z = -half_height, its apex at z = half_height.");
  bind_struct(cone, Field{"radius", &Cone::radius, "m, > 0"}, Field{"half_height", &Cone::half_height, "m, > 0"});
  nb::class_<Ellipsoid> ellipsoid(module, "Ellipsoid", "Centred at the body's origin, its axes along the body's.");
  bind_struct(ellipsoid, Field{"half_axes", &Ellipsoid::half_axes, "m, shape (3,), each > 0"});
  nb::class_<TaperedCapsule> tapered(
      module, "TaperedCapsule",
      "The convex hull of two balls: of the first radius about (0, 0, -half_height), of the second about (0, 0, "
      "half_height). Neither may hold the other: |radii[0] - radii[1]| < 2 half_height.");
  bind_struct(tapered, Field{"radii", &TaperedCapsule::radii, "m, two, each > 0"},
              Field{"half_height", &TaperedCapsule::half_height, "m, > 0"});
}

void bind_geometry(nb::module_& module) {
  // By where their geometry is: see shared_geometry.h.
  module.attr("_shared_geometry") = nb::module_::import_("weakref").attr("WeakValueDictionary")();

  nb::class_<ConvexHull> hull(module, "ConvexHull",
                              "The convex hull of a cloud of points, in the body's frame. Copies share the geometry.",
                              nb::is_weak_referenceable());
  bind_copies(hull);
  hull.def(
          "__init__", [](ConvexHull* self, const Rows<3>& points) { new (self) ConvexHull(points_of(points)); },
          nb::arg("points"),
          "points: m, shape (n, 3), at least 4, not all in a plane, else Error. A hull of more than 255 vertices is "
          "simplified to that many.")
      .def("scaled", &ConvexHull::scaled, nb::arg("factors"), "Stretched along its axes; no factor may be 0.")
      .def_prop_ro(
          "vertices", [](const ConvexHull& self) { return rows_of(self.vertices()); }, "m, shape (n, 3)",
          nb::sig("def vertices(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def(
          "face",
          [](const ConvexHull& self, std::size_t index) {
            if (index >= self.face_count()) throw nb::index_error();
            const auto face = self.face(index);
            return std::vector<int>(face.begin(), face.end());
          },
          nb::arg("index"), "Indices into vertices, counter-clockwise seen from outside.")
      .def_prop_ro("face_count", &ConvexHull::face_count)
      .def_prop_ro("simplified", &ConvexHull::simplified)
      .def_prop_ro("volume", &ConvexHull::volume, "m^3")
      .def_prop_ro("centre_of_mass", &ConvexHull::centre_of_mass, "m, shape (3,)")
      .def("__getstate__",
           [](const ConvexHull& self) {
             const std::vector<std::byte> bytes = self.to_bytes();
             return nb::bytes(bytes.data(), bytes.size());
           })
      .def("__setstate__",
           [](ConvexHull& self, const nb::bytes& state) {
             const auto* first = static_cast<const std::byte*>(state.data());
             new (&self) ConvexHull(ConvexHull::from_bytes({first, state.size()}));
           })
      .def("__repr__", [](const ConvexHull& self) {
        return "<ConvexHull of " + std::to_string(self.vertices().size()) + " vertices, " +
               std::to_string(self.face_count()) + " faces>";
      });

  nb::class_<TriangleMesh> mesh(
      module, "TriangleMesh",
      "A surface of triangles, solid behind their fronts (counter-clockwise). Of static and kinematic bodies. Copies "
      "share the geometry.",
      nb::is_weak_referenceable());
  bind_copies(mesh);
  const auto make_mesh = [](TriangleMesh* self, const Rows<3>& vertices, const Indices& triangles, double smooth_angle,
                            const Numbers& materials) {
    const auto* first = reinterpret_cast<const TriangleMesh::Indices*>(triangles.data());
    new (self) TriangleMesh(points_of(vertices), {first, triangles.shape(0)}, smooth_angle, materials);
  };
  mesh.def(
          "__init__", make_mesh, nb::arg("vertices"), nb::arg("triangles"), nb::arg("smooth_angle") = 0.0,
          nb::arg("materials") = Numbers(),
          "vertices: m, shape (n, 3). triangles: indices into them, shape (m, 3). smooth_angle: rad, in [0, pi): edges "
          "that bend by less are none to what rolls. materials: a number for each triangle, 0 for BodyDef.material, k "
          "for "
          "BodyDef.materials[k - 1]; or none. Raises Error, naming the triangle, on an index out of range, a "
          "triangle without area, or an edge of more than two triangles.")
      .def("scaled", &TriangleMesh::scaled, nb::arg("factors"))
      .def_prop_ro(
          "vertices", [](const TriangleMesh& self) { return rows_of(self.vertices()); }, "m, shape (n, 3)",
          nb::sig("def vertices(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "triangles",
          [](const TriangleMesh& self) {
            return nb::steal(array_of(self.triangles().data()->data(), {self.triangles().size(), 3}));
          },
          "shape (m, 3)", nb::sig("def triangles(self) -> numpy.typing.NDArray[numpy.uint32]"))
      .def_prop_ro("closed", &TriangleMesh::closed, "Whether every edge has two triangles.")
      .def_prop_ro("smooth_angle", &TriangleMesh::smooth_angle, "rad")
      .def_prop_ro("materials", &materials_of<TriangleMesh>, "a number for each triangle, or none")
      .def(
          "__getstate__",
          [](nb::object self) {
            return nb::make_tuple(self.attr("vertices"), self.attr("triangles"), self.attr("smooth_angle"),
                                  self.attr("materials"));
          },
          nb::sig("def __getstate__(self) -> tuple[" ATOLL_SURFACE "]"))
      .def(
          "__setstate__",
          [make_mesh](TriangleMesh& self, const std::tuple<Rows<3>, Indices, double, Numbers>& state) {
            std::apply([&](const auto&... parts) { make_mesh(&self, parts...); }, state);
          },
          nb::sig("def __setstate__(self, state: tuple[" ATOLL_SURFACE "], /) -> None"))
      .def("__repr__", [](const TriangleMesh& self) {
        return "<TriangleMesh of " + std::to_string(self.triangles().size()) + " triangles>";
      });

  nb::class_<HeightField> field(module, "HeightField",
                                "Heights over a grid in the body's x-y plane, solid below. Of static and kinematic "
                                "bodies. Copies share the geometry.",
                                nb::is_weak_referenceable());
  bind_copies(field);
  const auto make_field = [](HeightField* self, const Heights& heights, double spacing_x, double spacing_y, bool smooth,
                             const Numbers& materials) {
    const std::size_t count = heights.shape(0) * heights.shape(1);
    new (self) HeightField(static_cast<std::uint32_t>(heights.shape(1)), static_cast<std::uint32_t>(heights.shape(0)),
                           spacing_x, spacing_y, {heights.data(), heights.data() + count}, smooth, materials);
  };
  field
      .def("__init__", make_field, nb::arg("heights"), nb::arg("spacing_x") = 1.0, nb::arg("spacing_y") = 1.0,
           nb::arg("smooth") = false, nb::arg("materials") = Numbers(),
           "heights: m, shape (rows, columns), at least 2 x 2: heights[j, i] is that at x = i * spacing_x, y = j * "
           "spacing_y; NaN is a hole. spacings: m, > 0. smooth: the samples stand for a smooth surface. "
           "materials: a number for each cell, row after row, as of a TriangleMesh; or none.")
      .def_prop_ro(
          "heights",
          [](const HeightField& self) {
            return nb::steal(array_of(self.heights().data(), {self.rows(), self.columns()}));
          },
          "m, shape (rows, columns)", nb::sig("def heights(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro("spacing_x", &HeightField::spacing_x, "m")
      .def_prop_ro("spacing_y", &HeightField::spacing_y, "m")
      .def_prop_ro("smooth", &HeightField::smooth)
      .def_prop_ro("materials", &materials_of<HeightField>, "a number for each cell, row after row, or none")
      .def(
          "__getstate__",
          [](nb::object self) {
            return nb::make_tuple(self.attr("heights"), self.attr("spacing_x"), self.attr("spacing_y"),
                                  self.attr("smooth"), self.attr("materials"));
          },
          nb::sig("def __getstate__(self) -> tuple[" ATOLL_HEIGHTS "]"))
      .def(
          "__setstate__",
          [make_field](HeightField& self, const std::tuple<Heights, double, double, bool, Numbers>& state) {
            std::apply([&](const auto&... parts) { make_field(&self, parts...); }, state);
          },
          nb::sig("def __setstate__(self, state: tuple[" ATOLL_HEIGHTS "], /) -> None"))
      .def("__repr__", [](const HeightField& self) {
        return "<HeightField of " + std::to_string(self.rows()) + " x " + std::to_string(self.columns()) + " samples>";
      });
}

void bind_mass(nb::module_& module) {
  nb::class_<MassProperties> mass(module, "MassProperties", "What a body weighs, and where.");
  bind_result(mass, Field{"volume", &MassProperties::volume, "m^3"}, Field{"mass", &MassProperties::mass, "kg"},
              Field{"centre", &MassProperties::centre, "m, shape (3,), of mass, body frame"},
              Field{"inertia", &MassProperties::inertia, "kg m^2, shape (3, 3), about the centre, body frame"});
  module.def("mass_properties", &mass_properties, nb::arg("shape"),
             "Of a shape at 1 kg/m^3. Raises Error on one that has none: a half-space, a surface.");
  module.def("body_mass", &body_mass, nb::arg("definition"), "What a dynamic body weighs, as a world takes it.");
}

}  // namespace

void bind_shapes(nb::module_& module) {
  bind_solids(module);
  bind_geometry(module);

  nb::class_<CompoundChild> child(module, "CompoundChild", "A convex solid at a place of its own in a compound.");
  bind_definition(child,
                  Field{"shape", &CompoundChild::shape,
                        "Box, Sphere, Capsule, Cylinder, Cone, Ellipsoid, TaperedCapsule or ConvexHull"},
                  Field{"position", &CompoundChild::position, "m, shape (3,), body frame"},
                  Field{"orientation", &CompoundChild::orientation, "shape (4,): x, y, z, w"},
                  Field{"density_factor", &CompoundChild::density_factor, "times the body's density, > 0"},
                  Field{"material", &CompoundChild::material, "the body's, if None"},
                  Field{"filter", &CompoundChild::filter, "the body's, if None"});
  nb::class_<Compound> compound(module, "Compound", "Several convex shapes that move as one.");
  bind_struct(compound, Field{"children", &Compound::children, "at least one"});

  nb::class_<MotionLocks> locks(module, "MotionLocks",
                                "Along and about which of the world's axes x, y, z a dynamic body doesn't move.");
  bind_definition(locks, Field{"linear", &MotionLocks::linear, "three bools"},
                  Field{"angular", &MotionLocks::angular, "three bools"});
  locks.def_static("plane", &MotionLocks::plane, nb::arg("across"), "Keeps a body in its plane across an axis.");

  nb::class_<BodyDef> def(module, "BodyDef", "Everything a body starts with.");
  with_body_fields([&](const auto&... fields) { bind_definition(def, fields...); });
  bind_mass(module);
}

}  // namespace atl::python
