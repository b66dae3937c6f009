#pragma once

#include <atoll/material.h>
#include <atoll/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

namespace atl {

namespace collision {
struct Hull;
struct TriangleMesh;
struct HeightField;
}  // namespace collision

/// Centred at the body's origin. radius > 0, in m.
struct Sphere {
  double radius = 0.5;
};

/// Centred at the body's origin, edges along the body's axes. Every half extent > 0, in m.
struct Box {
  Vector3 half_extents = {0.5, 0.5, 0.5};
};

/// All points within `radius` of the segment from (0, 0, -half_height) to (0, 0, half_height). Both > 0, in m.
struct Capsule {
  double radius = 0.5;
  double half_height = 0.5;
};

/// About the z axis, centred at the body's origin. Both > 0, in m.
struct Cylinder {
  double radius = 0.5;
  double half_height = 0.5;
};

/// About the z axis: the base, of the radius given, at z = -half_height, the apex at z = half_height. Both > 0,
/// in m. The centre of mass lies at z = -half_height / 2.
struct Cone {
  double radius = 0.5;
  double half_height = 0.5;
};

/// Centred at the body's origin, its axes along the body's: all points with (x/a)^2 + (y/b)^2 + (z/c)^2 <= 1. Every
/// half axis > 0, in m.
struct Ellipsoid {
  Vector3 half_axes = {0.5, 0.5, 0.5};
};

/// The convex hull of two balls on the z axis: one of the first radius about (0, 0, -half_height), one of the second
/// about (0, 0, half_height). All > 0, in m; neither ball may hold the other: |radii[0] - radii[1]| < 2 half_height.
/// The centre of mass lies towards the larger one.
struct TaperedCapsule {
  std::array<double, 2> radii = {0.5, 0.25};
  double half_height = 0.5;
};

/// All points p of the body frame with normal . p <= offset (m) are solid. The normal is normalised on
/// use and must not be zero. Only static and kinematic bodies may be half-spaces: its mass is infinite.
struct HalfSpace {
  Vector3 normal = {0, 0, 1};
  double offset = 0;
};

/// The convex hull of a cloud of points, in the body's frame. Copies share the geometry.
class ConvexHull {
 public:
  /// At least 4 points (m), not all in a plane, else Error. Coplanar faces are merged; a hull of more than 255
  /// vertices is simplified to that many, see simplified().
  explicit ConvexHull(std::span<const Vector3> points);
  /// The hull stretched along the axes of its frame; every factor finite and not 0, else Error.
  ConvexHull scaled(const Vector3& factors) const;

  std::span<const Vector3> vertices() const;
  std::size_t face_count() const;
  /// Indices into vertices(), counter-clockwise seen from outside.
  std::span<const std::uint16_t> face(std::size_t index) const;
  bool simplified() const;
  double volume() const;  ///< m^3
  Vector3 centre_of_mass() const;

  /// All of it, to make the same hull elsewhere: made of its vertices it may have its faces in another order, and what
  /// touches them other bits.
  std::vector<std::byte> to_bytes() const;
  /// Throws Error, saying what was found and expected, on what is not of to_bytes(), damaged, or of another version or
  /// byte order.
  static ConvexHull from_bytes(std::span<const std::byte> bytes);

  // For Atoll's own use.
  explicit ConvexHull(std::shared_ptr<const collision::Hull> data) : hull_(std::move(data)) {}
  const std::shared_ptr<const collision::Hull>& data() const { return hull_; }

 private:
  std::shared_ptr<const collision::Hull> hull_;
};

/// A surface of triangles, solid behind their fronts (counter-clockwise). On static and kinematic bodies only.
/// Copies share the geometry.
class TriangleMesh {
 public:
  using Indices = std::array<std::uint32_t, 3>;
  /// Vertices in m. Throws Error, naming the triangle, on an index out of range, a triangle without area, or an
  /// edge that more than two triangles (or two of opposite winding) share. A surface may be open.
  ///
  /// With a `smooth_angle` (rad, in [0, pi)) the triangles stand for a smooth surface, but for edges that bend by as
  /// much: balls slide and roll on that, with normals that go over from corner to corner, so that the energy of what
  /// rolls through a bowl is kept. Other shapes touch the triangles as they are.
  ///
  /// `materials` has a number for each triangle, or is empty: 0 stands for BodyDef::material, others for
  /// BodyDef::materials.
  TriangleMesh(std::span<const Vector3> vertices, std::span<const Indices> triangles, double smooth_angle = 0,
               std::vector<std::uint8_t> materials = {});
  TriangleMesh scaled(const Vector3& factors) const;  ///< as ConvexHull's; fronts stay outside when mirrored

  std::span<const Vector3> vertices() const;
  std::span<const Indices> triangles() const;
  bool closed() const;          ///< every edge has two triangles
  double smooth_angle() const;  ///< rad
  std::span<const std::uint8_t> materials() const;

  // For Atoll's own use.
  explicit TriangleMesh(std::shared_ptr<const collision::TriangleMesh> data) : mesh_(std::move(data)) {}
  const std::shared_ptr<const collision::TriangleMesh>& data() const { return mesh_; }

 private:
  std::shared_ptr<const collision::TriangleMesh> mesh_;
};

/// Heights over a grid in the body's x-y plane, solid below. On static and kinematic bodies only. Copies share
/// the geometry.
class HeightField {
 public:
  /// heights[row * columns + column] (m) is that at x = column * spacing_x, y = row * spacing_y; columns and
  /// rows >= 2, all finite, and spacings > 0 and more than 1e-10 of each other and of what the heights differ by, else
  /// Error. A cell's diagonal runs from its lower left to its upper right sample. A height of NaN is a hole: the
  /// triangles at that sample are not there, and things fall through and may go below the others.
  /// World::set_heights() changes heights later. With `smooth`, the samples stand for a smooth surface, as of a
  /// TriangleMesh with a smooth angle, and without creases. `materials` has a number for each cell, row after row, or
  /// is empty, as of a TriangleMesh.
  HeightField(std::uint32_t columns, std::uint32_t rows, double spacing_x, double spacing_y,
              std::vector<double> heights, bool smooth = false, std::vector<std::uint8_t> materials = {});

  std::uint32_t columns() const;
  std::uint32_t rows() const;
  double spacing_x() const;
  double spacing_y() const;
  std::span<const double> heights() const;
  bool smooth() const;
  std::span<const std::uint8_t> materials() const;

  // For Atoll's own use.
  explicit HeightField(std::shared_ptr<const collision::HeightField> data) : field_(std::move(data)) {}
  const std::shared_ptr<const collision::HeightField>& data() const { return field_; }

 private:
  std::shared_ptr<const collision::HeightField> field_;
};

struct CompoundChild;

/// Several convex shapes that move as one, each at a place of its own in the body's frame. May overlap; what
/// overlaps counts twice in the mass. At least one child.
struct Compound {
  std::vector<CompoundChild> children;
};

using Shape = std::variant<Box, Sphere, HalfSpace, Capsule, Cylinder, Cone, ConvexHull, TriangleMesh, HeightField,
                           Compound, Ellipsoid, TaperedCapsule>;

/// A solid that may be part of a compound.
using ConvexShape = std::variant<Box, Sphere, Capsule, Cylinder, Cone, ConvexHull, Ellipsoid, TaperedCapsule>;

struct CompoundChild {
  ConvexShape shape = Box{};
  Vector3 position = Vector3::Zero();               ///< m, body frame
  Quaternion orientation = Quaternion::Identity();  ///< normalised on use, must not be zero
  double density_factor = 1;                        ///< times the body's density, > 0
  std::optional<Material> material = {};            ///< the body's, if left out
  std::optional<CollisionFilter> filter = {};       ///< the body's, if left out; World::set_filter leaves this be
};

/// Mass properties of a shape at a uniform density of 1 kg/m^3 (times the factors, in a compound). Throws
/// Error on a shape that has none: a half-space, a surface.
struct MassProperties {
  double volume = 0;                  ///< m^3
  double mass = 0;                    ///< kg
  Vector3 centre = Vector3::Zero();   ///< m, of mass, body frame
  Matrix3 inertia = Matrix3::Zero();  ///< kg m^2, about the centre, body frame
};
MassProperties mass_properties(const Shape& shape);

}  // namespace atl
