// Solids and compounds of them, of proportions up to needles and plates: what they weigh is what their geometry does,
// by formulas of their own, by their halves and by how they are turned and scaled; hulls hold the points that they are
// of, and all is within the bounds that a world tells.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "consistency.h"
#include "finding.h"
#include "target.h"

namespace {

using namespace atl;

void require_near(double value, double expected, double scale, const std::string& name) {
  fuzz::require(std::abs(value - expected) <= 1e-6 * scale,
                name + " is, and should be: " + fuzz::text_of(Eigen::Vector2d(value, expected)));
}

Shape shape_of(const ConvexShape& solid) {
  return std::visit([](const auto& of) { return Shape(of); }, solid);
}

// m, of 6 magnitudes.
double size_of(fuzz::Bytes& bytes) { return std::pow(10.0, bytes.within(-4, 2)); }

// A cloud of points of a grid, so that many are in one plane or line, or doubled, or in one place but for noise.
std::vector<Vector3> points_of(fuzz::Bytes& bytes) {
  const Vector3 stretch(size_of(bytes), size_of(bytes), size_of(bytes));
  const double noise = bytes.one_in(3) ? std::pow(10.0, -1 - bytes.within(0, 14)) : 0;
  std::vector<Vector3> points(4 + bytes.below(40));
  for (Vector3& point : points) {
    for (double& x : point) x = int(bytes.below(5)) - 2 + noise * bytes.within(-1, 1);
    point = point.cwiseProduct(stretch);
  }
  return points;
}

ConvexShape solid_of(fuzz::Bytes& bytes) {
  const double a = size_of(bytes), b = size_of(bytes), c = size_of(bytes);
  switch (bytes.below(7)) {
    case 0:
      return Box{{a, b, c}};
    case 1:
      return Capsule{a, b};
    case 2:
      return Cylinder{a, b};
    case 3:
      return Cone{a, b};
    case 4:
      return Ellipsoid{{a, b, c}};
    case 5:
      return TaperedCapsule{{a, b}, std::abs(a - b) / 2 + c};
    default:
      return ConvexHull(points_of(bytes));
  }
}

// No solid is heavier than the box around it, nor has mass outside of it; and its moments are those of some mass.
void check_physical(const Shape& shape) {
  const MassProperties mass = mass_properties(shape);
  World world;
  const BodyId id = world.add_body({.type = BodyType::Static, .shape = shape});
  const BoundingBox box = world.bounds(id);
  const Vector3 sides = box.upper - box.lower;
  fuzz::require_finite(mass.inertia, "an inertia");
  fuzz::require(mass.volume > 0 && mass.volume <= sides.prod() * (1 + 1e-6), "a solid has more volume than its box");
  fuzz::require(((mass.centre - box.lower).array() >= -1e-6 * sides.array()).all() &&
                    ((box.upper - mass.centre).array() >= -1e-6 * sides.array()).all(),
                "a centre of mass is outside of its solid");
  fuzz::require(mass.inertia.isApprox(mass.inertia.transpose(), 1e-12), "an inertia is not symmetric");
  // The second moments, of which an inertia is the sum of two each.
  const Matrix3 moments = 0.5 * mass.inertia.trace() * Matrix3::Identity() - mass.inertia;
  for (int i = 0; i < 3; ++i) {
    // No more than with all mass on two opposite sides.
    const double max = mass.mass * sides[i] * sides[i] / 4;
    fuzz::require(moments(i, i) >= -1e-9 * mass.inertia.trace() && moments(i, i) <= max + 1e-9 * mass.inertia.trace(),
                  "a second moment is " + std::to_string(moments(i, i)) + ", of at most " + std::to_string(max));
  }
}

// One child, turned and moved, and two of which each is as one: by the theorem of parallel axes.
void check_compound(const ConvexShape& solid, const Pose& place, double factor) {
  const MassProperties alone = mass_properties(shape_of(solid));
  Compound compound{{{.shape = solid, .position = place.position, .orientation = place.orientation}}};
  const MassProperties one = mass_properties(compound);
  const Matrix3 axes = place.orientation.normalized().toRotationMatrix();
  const double trace = alone.inertia.trace(), reach = place.position.norm() + alone.centre.norm();
  require_near(one.mass, alone.mass, alone.mass, "the mass of what is moved");
  const Matrix3 turned = axes * alone.inertia * axes.transpose();
  fuzz::require((one.inertia - turned).norm() <= 1e-6 * (trace + 1e-6 * alone.mass * reach * reach),
                "an inertia doesn't turn with its body");
  const Vector3 centre = place.position + axes * alone.centre;
  fuzz::require((one.centre - centre).norm() <= 1e-9 * reach, "a centre of mass isn't moved with its body");

  compound.children.push_back({.shape = solid, .density_factor = factor});
  const MassProperties both = mass_properties(compound);
  require_near(both.mass, (1 + factor) * alone.mass, (1 + factor) * alone.mass, "the mass of two");
  const Vector3 arm = alone.centre - centre;
  const double reduced = alone.mass * factor / (1 + factor);
  const Matrix3 apart = reduced * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
  const Matrix3 expected = turned + factor * alone.inertia + apart;
  fuzz::require((both.inertia - expected).norm() <= 1e-6 * expected.norm(), "the inertia of two is not their sum");
}

// All points are within every face, the volume is that of its tetrahedra, and stretched it is so much larger.
void check_hull(const std::vector<Vector3>& points, const Vector3& factors) {
  const ConvexHull hull(points);
  fuzz::check_shape(hull);
  Vector3 size = Vector3::Zero();
  for (const Vector3& point : points) size = size.cwiseMax(point.cwiseAbs());
  double volume = 0, surface = 0;
  for (std::size_t i = 0; i < hull.face_count(); ++i) {
    const auto corner = [&](std::size_t at) -> const Vector3& { return hull.vertices()[hull.face(i)[at]]; };
    Vector3 normal = Vector3::Zero();
    for (std::size_t at = 1; at + 1 < hull.face(i).size(); ++at) {
      const Vector3 area = (corner(at) - corner(0)).cross(corner(at + 1) - corner(0));
      normal += area;
      volume += corner(0).dot(area) / 6;
    }
    surface += normal.norm() / 2;
    if (normal.norm() < 1e-9 * size.squaredNorm()) continue;
    for (const Vector3& point : points) {
      const double out = normal.normalized().dot(point - corner(0));
      fuzz::require(out <= 1e-5 * size.norm(), "a point is " + std::to_string(out) + " m outside of its hull");
    }
  }
  require_near(hull.volume(), volume, std::abs(volume) + 1e-9 * size.prod(), "a hull's volume");
  const ConvexHull other = hull.scaled(factors);
  // Faces that are one but for a millionth of the size may be made one, or not.
  require_near(other.volume() / factors.cwiseAbs().prod(), volume, std::abs(volume) + 4 * size.norm() * surface,
               "a stretched hull's volume");
  const std::vector<std::byte> bytes = hull.to_bytes();
  fuzz::require(ConvexHull::from_bytes(bytes).to_bytes() == bytes, "a hull is written otherwise when it was read");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  atl::fuzz::Bytes bytes({data, size});
  atl::fuzz::Definitions definitions(bytes, atl::fuzz::Numbers::Usual);
  for (int turn = 0; turn < 4; ++turn) {
    try {
      const std::vector<atl::Vector3> points = points_of(bytes);
      check_hull(points, {bytes.within(0.5, 2), bytes.within(-2, -0.5), bytes.within(0.5, 2)});
      const atl::ConvexShape solid = solid_of(bytes);
      check_physical(shape_of(solid));
      check_compound(solid, {size_of(bytes) * definitions.vector(1), definitions.orientation()}, bytes.within(0.1, 10));
    } catch (const atl::Error&) {  // points in a plane, or a needle that is too thin
    }
  }
  return 0;
}
