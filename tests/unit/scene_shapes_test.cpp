// The shapes of scene files, and what is wrong with bad ones.

#include <atoll/scene.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "support/temporary_file.h"

namespace atl {
namespace {

std::string file_with(const std::string& shape) {
  return "{\"format\": \"atoll-scene\", \"version\": 1,\n\"bodies\": [{\"type\": \"static\",\n\"shape\": " + shape +
         "}]}";
}

template <typename Kind>
Kind read(const std::string& shape) {
  return std::get<Kind>(parse_scene(file_with(shape), "test.json").bodies[0].def.shape);
}

std::string message_of_shape(const std::string& text, const std::string& origin = "bad.json") {
  try {
    parse_scene(text, origin);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

void expect_refused(const std::string& shape, const std::string& starts, const std::string& contains) {
  SCOPED_TRACE(shape);
  const std::string message = message_of_shape(file_with(shape));
  EXPECT_TRUE(message.starts_with("bad.json:3: /bodies/0/shape" + starts)) << message;
  EXPECT_NE(message.find(contains), std::string::npos) << message;
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 0) << message;
}

// With a content of its own.
struct Written : test::TemporaryFile {
  Written(const std::string& ending, const std::string& text) : TemporaryFile(ending) { set_content(text); }
  std::string name() const { return path().filename().string(); }
};

constexpr const char* cube_obj =
    "# a cube\nmtllib none.mtl\no cube\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\r\nv 0 0 1\nv 1 0 1 1.0\nv 1 1 1\n"
    "\tv 0 1 1e0\nvn 0 0 1\nf 1//1 4//1 3//1 2//1\nf 5 6 7 8\nf 1 2 6 5\nf 3/1 4/1 8/1 7/1\nf -7 -6 -2 -3\nf 4 1 5 8";

TEST(SceneShapes, RoundOnes) {
  const auto capsule = read<Capsule>(R"({"type": "capsule", "radius": 0.2, "half_height": 3})");
  EXPECT_EQ(capsule.radius, 0.2);
  EXPECT_EQ(capsule.half_height, 3);
  EXPECT_EQ(read<Cylinder>(R"({"type": "cylinder", "radius": 2, "half_height": 0.5})").half_height, 0.5);
  EXPECT_EQ(read<Cone>(R"({"type": "cone", "radius": 2, "half_height": 0.5})").radius, 2);
  EXPECT_EQ(read<Ellipsoid>(R"({"type": "ellipsoid", "half_axes": [1, 2, 3]})").half_axes, Vector3(1, 2, 3));
  const auto tapered = read<TaperedCapsule>(R"({"type": "tapered_capsule", "radii": [2, 1], "half_height": 0.75})");
  EXPECT_EQ(tapered.radii[0], 2);
  EXPECT_EQ(tapered.radii[1], 1);
  EXPECT_EQ(tapered.half_height, 0.75);
  expect_refused(R"({"type": "ellipsoid", "half_axes": [1, 0, 3]})", "/half_axes", "a number > 0");
  expect_refused(R"({"type": "tapered_capsule", "radii": [2, 1], "half_height": 0.5})", "/half_height",
                 "neither ball may hold the other");
  expect_refused(R"({"type": "tapered_capsule", "radii": [2], "half_height": 0.5})", "/radii", "two numbers");
}

TEST(SceneShapes, Hull) {
  const auto hull = read<ConvexHull>(
      R"({"type": "hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "scale": [1, 2, -3]})");
  EXPECT_EQ(hull.vertices().size(), 4u);
  EXPECT_EQ(hull.vertices()[3], Vector3(0, 0, -3));
  EXPECT_DOUBLE_EQ(hull.volume(), 1);
}

TEST(SceneShapes, Mesh) {
  const auto mesh = read<TriangleMesh>(
      R"({"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [1, 1, 0]], "triangles": [[0, 1, 2]],
          "scale": [2, 1, 1]})");
  ASSERT_EQ(mesh.triangles().size(), 1u);
  EXPECT_EQ(mesh.triangles()[0], (TriangleMesh::Indices{0, 1, 2}));
  EXPECT_EQ(mesh.vertices()[2], Vector3(2, 1, 0));
}

TEST(SceneShapes, HeightField) {
  const auto field =
      read<HeightField>(R"({"type": "height_field", "heights": [[1, 2, 3], [4, 5, 6]], "spacing": [0.5, 2]})");
  EXPECT_EQ(field.columns(), 3u);
  EXPECT_EQ(field.rows(), 2u);
  EXPECT_EQ(field.spacing_x(), 0.5);
  EXPECT_EQ(field.spacing_y(), 2);
  EXPECT_EQ(field.heights()[3], 4);
}

TEST(SceneShapes, SmoothSurfaces) {
  const auto field =
      read<HeightField>(R"({"type": "height_field", "heights": [[1, 2], [4, 5]], "spacing": [1, 1], "smooth": true})");
  EXPECT_TRUE(field.smooth());
  const auto mesh = read<TriangleMesh>(
      R"({"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [1, 1, 0]], "triangles": [[0, 1, 2]],
          "scale": [2, 1, 1], "smooth_angle": 0.5})");
  EXPECT_EQ(mesh.smooth_angle(), 0.5);
  expect_refused(R"({"type": "mesh", "vertices": [], "triangles": [], "smooth_angle": 4})", "/smooth_angle: found 4",
                 "a number in [0, 3.14159");
}

TEST(SceneShapes, Compound) {
  const auto compound = read<Compound>(R"({"type": "compound", "children": [
      {"shape": {"type": "sphere", "radius": 2}},
      {"shape": {"type": "cone", "radius": 1, "half_height": 3}, "position": [1, 2, 3], "orientation": [1, 0, 0, 0],
       "density_factor": 4}]})");
  ASSERT_EQ(compound.children.size(), 2u);
  EXPECT_EQ(std::get<Sphere>(compound.children[0].shape).radius, 2);
  EXPECT_EQ(compound.children[0].density_factor, 1);
  EXPECT_EQ(std::get<Cone>(compound.children[1].shape).half_height, 3);
  EXPECT_EQ(compound.children[1].position, Vector3(1, 2, 3));
  EXPECT_EQ(compound.children[1].orientation.x(), 1);
  EXPECT_EQ(compound.children[1].density_factor, 4);
}

// Next to the scene file, with what programs write into such files: polygons, normals, groups, counting back.
TEST(SceneShapes, WavefrontFiles) {
  const Written obj("-cube.obj", cube_obj);
  const Written scene("-cube.json",
                      file_with(R"({"type": "mesh", "file": ")" + obj.name() + R"(", "scale": [2, 2, 2]})"));
  const auto mesh = std::get<TriangleMesh>(load_scene(scene.path().string()).bodies[0].def.shape);
  EXPECT_EQ(mesh.triangles().size(), 12u);
  EXPECT_TRUE(mesh.closed());
  EXPECT_EQ(mesh.vertices()[6], Vector3(2, 2, 2));
  const Written hull("-hull.json", file_with(R"({"type": "hull", "file": ")" + obj.name() + "\"}"));
  const auto cube = std::get<ConvexHull>(load_scene(hull.path().string()).bodies[0].def.shape);
  EXPECT_EQ(cube.face_count(), 6u);
  EXPECT_NEAR(cube.volume(), 1, 1e-15);
}

TEST(SceneShapes, BadWavefrontFiles) {
  const struct {
    const char* text;
    const char* message;
  } cases[] = {
      {"v 0 0 0\nv 1 0 zero\n", ":2: found \"zero\", expected three finite numbers after v"},
      {"v 0 0\n", ":1: found \"\", expected three finite numbers"},
      {"v 0 0 nan\n", ":1: found \"nan\", expected three finite numbers"},
      {"v 0 0 0\nv 1 0 0\nf 1 2\n", ":3: found a face of 2 corners, expected at least 3"},
      {"v 0 0 0\nv 1 0 0\nf 1 2 3\n", ":3: found vertex \"3\", expected a number in [1, 2]"},
      {"v 0 0 0\nf 1 0 1\n", ":2: found vertex \"0\""},
      {"v 0 0 0\nf 1 -2 1\n", ":2: found vertex \"-2\""},
      {"# nothing\n", ":1: found no vertex"},
      {"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "found no area in triangle 0"},
  };
  for (const auto& bad : cases) {
    const Written obj("-bad.obj", bad.text);
    const std::string scene = file_with(R"({"type": "mesh", "file": ")" + obj.name() + "\"}");
    const Written file("-bad.json", scene);
    const std::string message = message_of_shape(scene, file.path().string());
    EXPECT_NE(message.find("bad.json:3: /bodies/0/shape/file: "), std::string::npos) << message;
    EXPECT_NE(message.find(bad.message), std::string::npos) << message;
  }
  expect_refused(R"({"type": "mesh", "file": "nowhere/none.obj"})", "/file: nowhere/none.obj: found no readable file",
                 "expected a Wavefront OBJ file");
}

TEST(SceneShapes, RefusesBadOnes) {
  expect_refused(R"({"type": "capsul", "radius": 1})", "/type: found \"capsul\"", "did you mean \"capsule\"?");
  expect_refused(R"({"type": "capsule", "radius": 1})", "/half_height: found nothing", "a number > 0, in m");
  expect_refused(R"({"type": "cone", "radius": 0, "half_height": 1})", "/radius: found 0", "a number > 0");
  expect_refused(R"({"type": "cylinder", "radius": 1, "half_height": 1, "offset": 1})",
                 "/offset: found the unknown key", "type, radius or half_height");
  expect_refused(R"({"type": "hull"})", "/points: found nothing", "or a file");
  expect_refused(R"({"type": "hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]})", "/points: found 3 distinct points",
                 "at least 4");
  expect_refused(R"({"type": "hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1]]})",
                 "/points/3: found an array", "[x, y, z]");
  expect_refused(R"({"type": "hull", "points": [], "file": "a.obj"})", "/file: found both a file and points", "one");
  expect_refused(R"({"type": "hull", "points": [], "scale": [1, 0, 1]})", "/scale: found a factor of 0", "not");
  expect_refused(R"({"type": "mesh", "vertices": [[0, 0, 0]]})", "/triangles: found nothing", "three numbers");
  expect_refused(R"({"type": "mesh", "vertices": [[0, 0, 0]], "triangles": [[0, 0]]})", "/triangles/0: found an array",
                 "three numbers of vertices");
  expect_refused(R"({"type": "mesh", "vertices": [[0, 0, 0]], "triangles": [[0, 0, -1]]})", "/triangles/0/2: found -1",
                 "an integer");
  expect_refused(R"({"type": "mesh", "vertices": [[0, 0, 0]], "triangles": [[0, 0, 1]]})",
                 "/triangles: found vertex 1 in triangle 0", "below 1");
  expect_refused(R"({"type": "height_field", "heights": [[0, 0], [0, 0]]})", "/spacing: found nothing", "[x, y]");
  expect_refused(R"({"type": "height_field", "heights": [[0, 0]], "spacing": [1, 1]})", "/heights: found an array of 1",
                 "two rows");
  expect_refused(R"({"type": "height_field", "heights": [[0, 0], [0]], "spacing": [1, 1]})",
                 "/heights/1: found an array of 1", "two heights");
  expect_refused(R"({"type": "height_field", "heights": [[0, 0], [0, 0, 0]], "spacing": [1, 1]})",
                 "/heights/1: found a row of 3", "2 as in the first row");
  expect_refused(R"({"type": "height_field", "heights": [[0, 0], [0, 0]], "spacing": [1, 0]})", "/spacing/1: found 0",
                 "> 0");
  expect_refused(R"({"type": "compound", "children": []})", "/children: found an empty array", "at least one child");
  expect_refused(R"({"type": "compound", "children": [{"shape": {"type": "half_space"}}]})",
                 "/children/0/shape/type: found \"half_space\"",
                 "box, sphere, capsule, cylinder, cone, ellipsoid, tapered_capsule or hull");
  expect_refused(
      R"({"type": "compound", "children": [{"shape": {"type": "sphere", "radius": 1}, "density_factor": 0}]})",
      "/children/0/density_factor: found 0", "> 0");
}

TEST(SceneShapes, SurfacesAreRefusedOnDynamicBodies) {
  const std::string start = R"({"format": "atoll-scene", "version": 1, "bodies": [{"shape": )";
  const std::string mesh =
      R"({"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [1, 1, 0]], "triangles": [[0, 1, 2]]})";
  const std::string field = R"({"type": "height_field", "heights": [[0, 0], [0, 0]], "spacing": [1, 1]})";
  EXPECT_NE(message_of_shape(start + mesh + "}]}").find("found a mesh on a dynamic body"), std::string::npos);
  EXPECT_NE(message_of_shape(start + field + "}]}").find("found a height field on a dynamic body"), std::string::npos);
}

}  // namespace
}  // namespace atl
