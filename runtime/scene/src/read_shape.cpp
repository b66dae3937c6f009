#include <collision/shapes/shape.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <system_error>
#include <utility>

#include "schema.h"
#include "text_file.h"
#include "wavefront.h"
#include "words.h"

namespace atl::scene {
namespace {

using Indices = TriangleMesh::Indices;

constexpr int max_vertices = 1'000'000'000;

// In the order of the names below; those before HalfSpace may be parts of a compound.
enum class ShapeName {
  Box,
  Sphere,
  Capsule,
  Cylinder,
  Cone,
  Ellipsoid,
  TaperedCapsule,
  Hull,
  HalfSpace,
  Mesh,
  HeightField,
  Compound
};
constexpr const char* shape_names =
    "box, sphere, capsule, cylinder, cone, ellipsoid, tapered_capsule, hull, half_space, mesh, height_field or "
    "compound";
constexpr const char* solid_names = "box, sphere, capsule, cylinder, cone, ellipsoid, tapered_capsule or hull";

void only_keys_of_a_shape(const Reader& in) {
  in.only_keys({"type", "half_extents", "half_axes", "radius", "radii", "half_height", "points", "vertices",
                "triangles", "file", "scale", "smooth_angle", "heights", "spacing", "smooth", "materials", "children",
                "normal", "offset"});
}

// Makes a geometry, and reports an Error about it at its place in the file, whose values caused it.
template <typename Make>
auto made(const Reader& in, const Make& make) {
  try {
    return make();
  } catch (const Error& error) {
    const std::string words = error.what();
    const std::size_t name = words.find(": found ");  // "ConvexHull: found ..."
    in.complain(name == std::string::npos ? words : words.substr(name + 2));
  }
}

double read_length(const Reader& in, const char* key) { return in.at(key, "a number > 0, in m").number(above(0)); }

template <typename Round>
Round read_round(const Reader& in) {
  in.only_keys({"type", "radius", "half_height"});
  Round shape;
  shape.radius = read_length(in, "radius");
  shape.half_height = read_length(in, "half_height");
  return shape;
}

TaperedCapsule read_tapered_capsule(const Reader& in) {
  in.only_keys({"type", "radii", "half_height"});
  TaperedCapsule shape;
  const Reader radii = in.at("radii", "[bottom, top], in m");
  const auto [bottom, top] = radii.numbers<2>("an array of two numbers, [bottom, top]", above(0));
  shape.radii = {bottom, top};
  shape.half_height = read_length(in, "half_height");
  if (!collision::parts_balls(bottom, top, shape.half_height)) {
    in.fail_at("half_height", number_text(shape.half_height),
               "more than half the difference of the radii: neither ball may hold the other");
  }
  return shape;
}

std::vector<Vector3> read_points(const Reader& in) {
  const std::size_t count = in.size("an array of points, [x, y, z] each");
  std::vector<Vector3> points;
  points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) points.push_back(read_vector(in.element(i)));
  return points;
}

std::vector<Indices> read_triangles(const Reader& in) {
  constexpr const char* corners = "three numbers of vertices, counted from 0";
  const std::size_t count = in.size("an array of triangles, three numbers of vertices each");
  std::vector<Indices> triangles;
  triangles.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Reader triangle = in.element(i);
    if (triangle.size(corners) != 3) triangle.expected(corners);
    Indices& indices = triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      indices[k] = static_cast<std::uint32_t>(triangle.element(k).integer(0, max_vertices));
    }
  }
  return triangles;
}

// A path is relative to the scene file. Links are followed first: one must not lead outside either.
std::filesystem::path path_of(const Reader& in) {
  namespace fs = std::filesystem;
  const JsonDocument& document = in.document();
  const fs::path folder = fs::path(document.origin).parent_path();
  const fs::path path = folder / in.string();
  std::error_code error;
  const auto real = [&error](const fs::path& of) { return fs::weakly_canonical(fs::absolute(of, error), error); };
  const fs::path real_folder = real(folder.empty() ? fs::path(".") : folder);
  const fs::path below = real(path).lexically_relative(real_folder);
  if (document.mesh_files == MeshFiles::BelowScene && (error || below.empty() || *below.begin() == "..")) {
    in.fail(quote(in.string()), "a file below the scene file's folder, or that files outside are allowed");
  }
  return path;
}

Wavefront read_wavefront(const Reader& in) {
  const std::filesystem::path path = path_of(in);
  try {
    return parse_wavefront(read_text_file(path.string(), "a Wavefront OBJ file"), path.string());
  } catch (const SceneError& error) {
    in.complain(error.what());
  }
}

Vector3 read_scale(const Reader& in) {
  Vector3 scale = Vector3::Ones();
  get(in, "scale", scale);
  if (!(scale.cwiseAbs().minCoeff() > 0)) in.at("scale", "").fail("a factor of 0", "three that are not");
  return scale;
}

ConvexHull read_hull(const Reader& in) {
  in.only_keys({"type", "points", "file", "scale"});
  if (in.has("points") && in.has("file")) in.fail_at("file", "both a file and points", "one of them");
  const Vector3 scale = read_scale(in);
  const auto file = in.find("file");
  const Reader source = file ? *file : in.at("points", "an array of points, [x, y, z] each, or a file");
  std::vector<Vector3> points = file ? read_wavefront(source).vertices : read_points(source);
  for (Vector3& point : points) point = point.cwiseProduct(scale);
  return made(source, [&] { return ConvexHull(points); });
}

std::vector<std::uint8_t> read_material_numbers(const Reader& in) {
  std::vector<std::uint8_t> numbers;
  const auto all = in.find("materials");
  const std::size_t count = all ? all->size("an array of numbers of materials") : 0;
  for (std::size_t i = 0; i < count; ++i) {
    numbers.push_back(static_cast<std::uint8_t>(all->element(i).integer(0, std::numeric_limits<std::uint8_t>::max())));
  }
  return numbers;
}

TriangleMesh read_mesh(const Reader& in) {
  in.only_keys({"type", "vertices", "triangles", "file", "scale", "smooth_angle", "materials"});
  const auto file = in.find("file");
  if (file && (in.has("vertices") || in.has("triangles"))) {
    in.fail_at("file", "both a file and vertices or triangles", "one of them");
  }
  const Vector3 scale = read_scale(in);
  Wavefront surface;
  if (file) {
    surface = read_wavefront(*file);
  } else {
    surface.vertices = read_points(in.at("vertices", "an array of points, [x, y, z] each, or a file"));
    surface.triangles = read_triangles(in.at("triangles", "an array of triangles, three numbers of vertices each"));
  }
  double smooth_angle = 0;
  get(in, "smooth_angle", smooth_angle, between(0, std::nextafter(std::numbers::pi, 0)));
  const Reader source = file ? *file : in.at("triangles", "");
  return made(source, [&] {
    const TriangleMesh mesh(surface.vertices, surface.triangles, smooth_angle, read_material_numbers(in));
    return scale == Vector3::Ones() ? mesh : mesh.scaled(scale);
  });
}

HeightField read_height_field(const Reader& in) {
  in.only_keys({"type", "heights", "spacing", "smooth", "materials"});
  bool smooth = false;
  get(in, "smooth", smooth);
  constexpr const char* what = "an array of rows, each an array of at least two numbers, in m";
  const Reader rows = in.at("heights", what);
  const std::size_t row_count = rows.size(what);
  if (row_count < 2) rows.expected("at least two rows of heights");
  std::size_t columns = 0;
  std::vector<double> heights;
  for (std::size_t j = 0; j < row_count; ++j) {
    const Reader row = rows.element(j);
    const std::size_t size = row.size("an array of at least two numbers, in m");
    if (j == 0) columns = size;
    if (size < 2) row.expected("at least two heights");
    if (size != columns) row.fail("a row of " + std::to_string(size), std::to_string(columns) + " as in the first row");
    for (std::size_t i = 0; i < size; ++i) {
      const Reader height = row.element(i);
      heights.push_back(height.is<std::monostate>() ? std::numeric_limits<double>::quiet_NaN()
                                                    : height.number());  // a hole
    }
  }
  constexpr const char* distances = "an array of two numbers, [x, y]";
  const auto [x, y] = in.at("spacing", "[x, y], the distances between samples, in m").numbers<2>(distances, above(0));
  return made(rows, [&, dx = x, dy = y] {
    return HeightField(static_cast<std::uint32_t>(columns), static_cast<std::uint32_t>(row_count), dx, dy, heights,
                       smooth, read_material_numbers(in));
  });
}

HalfSpace read_half_space(const Reader& in) {
  in.only_keys({"type", "normal", "offset"});
  HalfSpace half_space;
  get(in, "normal", half_space.normal);
  get(in, "offset", half_space.offset);
  const double norm = half_space.normal.norm();
  if (!(norm > 0) || !std::isfinite(norm)) {
    in.fail_at("normal", "a vector of length " + number_text(norm), "a length above 0");
  }
  return half_space;
}

ConvexShape read_solid(const Reader& in, ShapeName kind) {
  switch (kind) {
    case ShapeName::Box:
      in.only_keys({"type", "half_extents"});
      return Box{read_vector(in.at("half_extents", "[x, y, z] in m"), above(0))};
    case ShapeName::Sphere:
      in.only_keys({"type", "radius"});
      return Sphere{read_length(in, "radius")};
    case ShapeName::Capsule:
      return read_round<Capsule>(in);
    case ShapeName::Cylinder:
      return read_round<Cylinder>(in);
    case ShapeName::Cone:
      return read_round<Cone>(in);
    case ShapeName::Ellipsoid:
      in.only_keys({"type", "half_axes"});
      return Ellipsoid{read_vector(in.at("half_axes", "[x, y, z] in m"), above(0))};
    case ShapeName::TaperedCapsule:
      return read_tapered_capsule(in);
    default:
      return read_hull(in);
  }
}

CompoundChild read_child(const Reader& in) {
  in.only_keys({"shape", "position", "orientation", "density_factor", "material", "filter"});
  const Reader shape = in.at("shape", "a solid");
  only_keys_of_a_shape(shape);
  const std::size_t kind =
      shape.at("type", solid_names)
          .choice({"box", "sphere", "capsule", "cylinder", "cone", "ellipsoid", "tapered_capsule", "hull"});
  CompoundChild child;
  child.shape = read_solid(shape, static_cast<ShapeName>(kind));
  get(in, "position", child.position);
  if (const auto orientation = in.find("orientation")) child.orientation = read_orientation(*orientation);
  get(in, "density_factor", child.density_factor, above(0));
  if (const auto material = in.find("material")) child.material = read_material(*material);
  if (const auto filter = in.find("filter")) child.filter = read_filter(*filter);
  return child;
}

Compound read_compound(const Reader& in) {
  in.only_keys({"type", "children"});
  constexpr const char* what = "an array of at least one child, a shape and its place each";
  const Reader children = in.at("children", what);
  const std::size_t count = children.size(what);
  if (count == 0) children.expected(what);
  Compound compound;
  for (std::size_t i = 0; i < count; ++i) compound.children.push_back(read_child(children.element(i)));
  return compound;
}

}  // namespace

Shape read_shape(const Reader& in) {
  only_keys_of_a_shape(in);
  const auto kind = static_cast<ShapeName>(
      in.at("type", shape_names)
          .choice({"box", "sphere", "capsule", "cylinder", "cone", "ellipsoid", "tapered_capsule", "hull", "half_space",
                   "mesh", "height_field", "compound"}));
  switch (kind) {
    case ShapeName::HalfSpace:
      return read_half_space(in);
    case ShapeName::Mesh:
      return read_mesh(in);
    case ShapeName::HeightField:
      return read_height_field(in);
    case ShapeName::Compound:
      return read_compound(in);
    default:
      return std::visit([](auto&& solid) { return Shape(std::forward<decltype(solid)>(solid)); }, read_solid(in, kind));
  }
}

}  // namespace atl::scene
