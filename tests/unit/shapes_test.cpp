// The public shapes: what they share, how they scale, their mass properties, and what they refuse.

#include <atoll/shapes.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "support/expect_error.h"
#include "support/random.h"

namespace atl {
namespace {

using test::expect_error;
using test::Random;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

const std::vector<Vector3> tetrahedron = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0, 0, 5}};
const std::vector<TriangleMesh::Indices> tetrahedron_faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

TEST(ConvexHull, ShowsWhatItIs) {
  const ConvexHull hull(tetrahedron);
  ASSERT_EQ(hull.vertices().size(), 4u);
  EXPECT_EQ(hull.vertices()[1], Vector3(2, 0, 0));
  ASSERT_EQ(hull.face_count(), 4u);
  EXPECT_EQ(hull.face(0).size(), 3u);
  EXPECT_DOUBLE_EQ(hull.volume(), 5);
  EXPECT_LT((hull.centre_of_mass() - Vector3(0.5, 0.75, 1.25)).norm(), 1e-15);
  EXPECT_FALSE(hull.simplified());
  const ConvexHull copy = hull;
  EXPECT_EQ(copy.vertices().data(), hull.vertices().data());
}

// Also mirrored, faces run counter-clockwise seen from outside.
TEST(ConvexHull, ScaledIsTheHullOfScaledPoints) {
  const ConvexHull hull(tetrahedron);
  for (const Vector3& factors : {Vector3(2, 0.5, 3), Vector3(-1, 1, 1), Vector3(-2, -1, -0.1)}) {
    const ConvexHull scaled = hull.scaled(factors);
    EXPECT_NEAR(scaled.volume(), 5 * std::abs(factors.prod()), 1e-14);
    EXPECT_LT((scaled.centre_of_mass() - hull.centre_of_mass().cwiseProduct(factors)).norm(), 1e-14);
    for (std::size_t f = 0; f < scaled.face_count(); ++f) {
      const auto corners = scaled.face(f);
      const Vector3 a = scaled.vertices()[corners[0]];
      const Vector3 normal = (scaled.vertices()[corners[1]] - a).cross(scaled.vertices()[corners[2]] - a);
      EXPECT_LT(normal.dot(scaled.centre_of_mass() - a), 0);
    }
  }
}

TEST(ConvexHull, IsTheSameFromItsBytes) {
  Random random(11);
  for (const int count : {4, 30, 400}) {
    std::vector<Vector3> points;
    for (int i = 0; i < count; ++i) points.push_back(random.direction().cwiseProduct(Vector3(0.5, 0.3, 0.4)));
    const ConvexHull hull = ConvexHull(points).scaled({1, 2, -1});
    const std::vector<std::byte> bytes = hull.to_bytes();
    const ConvexHull copy = ConvexHull::from_bytes(bytes);
    ASSERT_TRUE(std::ranges::equal(copy.vertices(), hull.vertices()));
    ASSERT_EQ(copy.face_count(), hull.face_count());
    for (std::size_t i = 0; i < hull.face_count(); ++i) EXPECT_TRUE(std::ranges::equal(copy.face(i), hull.face(i)));
    EXPECT_EQ(copy.volume(), hull.volume());
    EXPECT_EQ(copy.centre_of_mass(), hull.centre_of_mass());
    EXPECT_EQ(copy.simplified(), count > 255);
    EXPECT_EQ(copy.to_bytes(), bytes);
  }
}

TEST(ConvexHull, RefusesBytesThatAreNone) {
  const std::vector<Vector3> corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<std::byte> bytes = ConvexHull(corners).to_bytes();
  expect_error([] { ConvexHull::from_bytes({}); }, {"ConvexHull::from_bytes: found the end of the data at byte 0"});
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    expect_error([&] { ConvexHull::from_bytes(std::span(bytes).first(size)); }, {"ConvexHull::from_bytes: found"});
  }
  std::vector<std::byte> changed = bytes;
  changed.push_back({});
  expect_error([&] { ConvexHull::from_bytes(changed); }, {"more than there should be"});
  changed = bytes;
  changed[0] = std::byte{'B'};
  expect_error([&] { ConvexHull::from_bytes(changed); }, {"no hull's header", "what ConvexHull::to_bytes wrote"});
  changed = bytes;
  changed[12] = std::byte{99};
  expect_error([&] { ConvexHull::from_bytes(changed); }, {"found version 99; expected 1"});
  // Whatever bit is flipped, nobody ends up with another hull: but for the sign of a zero, and the flag of a simplified
  // one, which says nothing of its shape.
  const ConvexHull hull(corners);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < 8 * bytes.size(); ++i) {
    changed = bytes;
    changed[i / 8] ^= std::byte{1} << i % 8;
    try {
      const ConvexHull other = ConvexHull::from_bytes(changed);
      EXPECT_TRUE(std::ranges::equal(other.vertices(), hull.vertices())) << "bit " << i;
      EXPECT_EQ(other.volume(), hull.volume()) << "bit " << i;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 8 * bytes.size() - 40);
}

TEST(TriangleMesh, ScaledKeepsFrontsOutside) {
  const TriangleMesh mesh(tetrahedron, tetrahedron_faces);
  EXPECT_TRUE(mesh.closed());
  EXPECT_EQ(mesh.triangles().size(), 4u);
  for (const Vector3& factors : {Vector3(2, 3, 4), Vector3(1, -1, 1), Vector3(-1, -2, 1), Vector3(-1, -1, -1)}) {
    const TriangleMesh scaled = mesh.scaled(factors);
    EXPECT_EQ(scaled.vertices()[3], Vector3(0, 0, 5 * factors.z()));
    double volume = 0;
    for (const auto& [a, b, c] : scaled.triangles()) {
      volume += scaled.vertices()[a].dot(scaled.vertices()[b].cross(scaled.vertices()[c])) / 6;
    }
    EXPECT_NEAR(volume, 5 * std::abs(factors.prod()), 1e-13);
  }
}

TEST(HeightField, ShowsWhatItIs) {
  const HeightField field(3, 2, 0.5, 0.25, {1, 2, 3, 4, 5, 6});
  EXPECT_EQ(field.columns(), 3u);
  EXPECT_EQ(field.rows(), 2u);
  EXPECT_EQ(field.spacing_x(), 0.5);
  EXPECT_EQ(field.spacing_y(), 0.25);
  EXPECT_EQ(field.heights()[4], 5);
}

void expect_near(const MassProperties& found, double mass, const Vector3& centre, const Matrix3& inertia) {
  EXPECT_NEAR(found.mass, mass, 1e-12 * mass);
  EXPECT_LT((found.centre - centre).norm(), 1e-12);
  EXPECT_LT((found.inertia - inertia).norm(), 1e-12 * inertia.norm());
}

TEST(MassPropertiesOfShapes, AreTheClosedForms) {
  const double pi = std::numbers::pi;
  expect_near(mass_properties(Box{{0.5, 1, 1.5}}), 6, {0, 0, 0}, Vector3(6.5, 5, 2.5).asDiagonal());
  const double ball = 4.0 / 3 * pi * 8;
  expect_near(mass_properties(Sphere{2}), ball, {0, 0, 0}, Matrix3::Identity() * (ball * 1.6));
  const double disc = 2 * pi * 4 * 3;
  expect_near(mass_properties(Cylinder{2, 3}), disc, {0, 0, 0}, disc * Vector3(4, 4, 2).asDiagonal());
  const double cone = 2.0 / 3 * pi * 4 * 3;
  expect_near(mass_properties(Cone{2, 3}), cone, {0, 0, -1.5}, cone * Vector3(1.95, 1.95, 1.2).asDiagonal());
  // A capsule is its cylinder and the two halves of a ball: exact about z, where no arm counts.
  const MassProperties capsule = mass_properties(Capsule{2, 3});
  EXPECT_NEAR(capsule.mass, disc + ball, 1e-12 * disc);
  EXPECT_NEAR(capsule.inertia(2, 2), disc * 2 + ball * 1.6, 1e-12 * disc);
  const double egg = 4.0 / 3 * pi * 6;
  expect_near(mass_properties(Ellipsoid{{1, 2, 3}}), egg, {0, 0, 0}, egg / 5 * Vector3(13, 10, 5).asDiagonal());
}

void expect_same(const MassProperties& found, const MassProperties& expected) {
  EXPECT_NEAR(found.volume, expected.volume, 1e-12 * expected.volume);
  expect_near(found, expected.mass, expected.centre, expected.inertia);
}

TEST(MassPropertiesOfShapes, OfRoundOnesMeetWhereTheyAreEqual) {
  for (const double r : {0.1, 1.0, 7.0}) {
    expect_same(mass_properties(Ellipsoid{Vector3::Constant(r)}), mass_properties(Sphere{r}));
    for (const double h : {0.01, 1.0, 20.0}) {
      expect_same(mass_properties(TaperedCapsule{{r, r}, h}), mass_properties(Capsule{r, h}));
    }
  }
}

// By discs: Simpson's rule over each of the parts, of which the squared radius is a polynomial.
MassProperties summed(const TaperedCapsule& shape) {
  const double lean = std::asin((shape.radii[0] - shape.radii[1]) / (2 * shape.half_height));
  const double h = shape.half_height;
  const double ends[] = {-h - shape.radii[0], -h + shape.radii[0] * std::sin(lean), h + shape.radii[1] * std::sin(lean),
                         h + shape.radii[1]};
  const auto square = [&](int part, double z) {
    if (part == 0) return shape.radii[0] * shape.radii[0] - (z + h) * (z + h);
    if (part == 2) return shape.radii[1] * shape.radii[1] - (z - h) * (z - h);
    const double radius = (shape.radii[0] - std::sin(lean) * (z + h)) / std::cos(lean);
    return radius * radius;
  };
  double volume = 0, first = 0, second = 0, fourth = 0;
  constexpr int steps = 2000;
  for (int part = 0; part < 3; ++part) {
    const double step = (ends[part + 1] - ends[part]) / steps;
    for (int i = 0; i <= steps; ++i) {
      const double z = ends[part] + i * step;
      const double weight = std::numbers::pi * step / 3 * (i == 0 || i == steps ? 1 : i % 2 == 1 ? 4 : 2);
      const double disc = square(part, z);
      volume += weight * disc;
      first += weight * disc * z;
      second += weight * disc * z * z;
      fourth += weight * disc * disc;
    }
  }
  const double across = fourth / 4 + second - first * first / volume;
  return {volume, volume, {0, 0, first / volume}, Vector3(across, across, fourth / 2).asDiagonal().toDenseMatrix()};
}

TEST(MassPropertiesOfShapes, OfATaperedCapsuleAreThoseOfItsDiscs) {
  for (const TaperedCapsule& shape :
       {TaperedCapsule{{0.5, 0.25}, 0.5}, TaperedCapsule{{0.1, 1}, 0.6}, TaperedCapsule{{2, 0.01}, 1}}) {
    const MassProperties found = mass_properties(shape), expected = summed(shape);
    EXPECT_NEAR(found.mass, expected.mass, 1e-11 * expected.mass);
    EXPECT_LT((found.centre - expected.centre).norm(), 1e-11);
    EXPECT_LT((found.inertia - expected.inertia).norm(), 1e-11 * expected.inertia.norm());
  }
}

TEST(MassPropertiesOfShapes, OfACompoundOfHalvesAreTheWhole) {
  Compound halves;
  halves.children.push_back({.shape = Box{{0.25, 1, 1.5}}, .position = {-0.25, 0, 0}});
  // The other half lies on its side and is turned into place.
  halves.children.push_back({.shape = Box{{1, 0.25, 1.5}},
                             .position = {0.25, 0, 0},
                             .orientation = Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitZ()))});
  expect_near(mass_properties(halves), 6, {0, 0, 0}, Vector3(6.5, 5, 2.5).asDiagonal());
  for (CompoundChild& child : halves.children) child.position += Vector3(3, -4, 5);
  expect_near(mass_properties(halves), 6, {3, -4, 5}, Vector3(6.5, 5, 2.5).asDiagonal());
}

// A dumbbell: parallel axes by hand.
TEST(MassPropertiesOfShapes, OfACompoundWeighDensities) {
  Compound dumbbell;
  dumbbell.children.push_back({.shape = Sphere{1}, .position = {-2, 0, 0}, .density_factor = 3});
  dumbbell.children.push_back({.shape = Sphere{1}, .position = {2, 0, 0}});
  const double m = 4.0 / 3 * std::numbers::pi;
  const MassProperties found = mass_properties(dumbbell);
  expect_near(found, 4 * m, {-1, 0, 0}, m * Vector3(1.6, 1.6 + 3 * 1 + 9, 1.6 + 3 * 1 + 9).asDiagonal());
  EXPECT_NEAR(found.volume, 2 * m, 1e-14);
}

// The centre of a child need not be its origin.
TEST(MassPropertiesOfShapes, OfACompoundOfConesMeetAtTheirBases) {
  Compound spindle;
  spindle.children.push_back({.shape = Cone{1, 1}, .position = {0, 0, 1}});
  spindle.children.push_back(
      {.shape = Cone{1, 1}, .position = {0, 0, -1}, .orientation = Quaternion(0, 1, 0, 0)});  // half a turn about x
  const double m = 2.0 / 3 * std::numbers::pi;  // of one, height 2; its centre 0.5 from the base
  const double across = 3.0 / 20 * 2 + 0.25;
  expect_near(mass_properties(spindle), 2 * m, {0, 0, 0}, 2 * m * Vector3(across, across, 0.3).asDiagonal());
}

TEST(MassPropertiesOfShapes, RefuseWhatHasNone) {
  expect_error([] { mass_properties(HalfSpace{}); }, {"shape is a HalfSpace", "expected a solid"});
  expect_error([] { mass_properties(TriangleMesh(tetrahedron, tetrahedron_faces)); }, {"shape is a TriangleMesh"});
  expect_error([] { mass_properties(HeightField(2, 2, 1, 1, {0, 0, 0, 0})); }, {"shape is a HeightField"});
  expect_error([] { mass_properties(Compound{}); }, {"Compound.children", "empty"});
  expect_error([] { mass_properties(Capsule{-1, 1}); }, {"Capsule.radius", "-1"});
  expect_error([] { mass_properties(Ellipsoid{{1, 0, 1}}); }, {"Ellipsoid.half_axes", "(1, 0, 1)", "above 0"});
  expect_error([] { mass_properties(TaperedCapsule{{1, -2}, 1}); }, {"TaperedCapsule.radii", "-2"});
  expect_error(
      [] {
        mass_properties(TaperedCapsule{{1, 3}, 1});
      },
      {"TaperedCapsule.half_height", "is 1", "neither ball may hold the other"});
}

TEST(Shapes, RefuseBadGeometry) {
  expect_error(
      [] {
        ConvexHull(std::vector<Vector3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
      },
      {"ConvexHull", "found 3 distinct points", "expected at least 4"});
  expect_error([] { ConvexHull(std::vector<Vector3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}); }, {"plane"});
  expect_error([] { ConvexHull(tetrahedron).scaled({1, 0, 1}); }, {"ConvexHull::scaled", "(1, 0, 1)", "other than 0"});
  expect_error([] { ConvexHull(tetrahedron).scaled({1, 1, 1e-9}); }, {"ConvexHull::scaled", "plane"});
  expect_error([] { ConvexHull(tetrahedron).face(4); }, {"index is 4", "face_count() = 4"});
  expect_error(
      [] {
        TriangleMesh(tetrahedron, std::vector<TriangleMesh::Indices>{{0, 1, 4}});
      },
      {"TriangleMesh", "found vertex 4 in triangle 0", "below 4"});
  expect_error(
      [] {
        TriangleMesh(tetrahedron, tetrahedron_faces).scaled({nan, 1, 1});
      },
      {"TriangleMesh::scaled", "nan"});
  expect_error(
      [] {
        HeightField(3, 2, 1, 1, {0, 0, 0, 0, -1 / 0.0, 0});
      },
      {"HeightField", "found a height of -inf at column 1, row 1"});
  expect_error([] { HeightField(3, 2, 1, 1, {0}); }, {"found 1 heights", "3 * 2 = 6"});
}

}  // namespace
}  // namespace atl
