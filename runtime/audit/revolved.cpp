#include "revolved.h"

#include <Eigen/Core>
#include <array>

namespace atl::audit {
namespace {

using Vector2 = Eigen::Vector2d;

/// A side of the solid's profile in the half plane (distance from the axis, height along it).
struct Side {
  Vector2 begin, end;
  Vector2 normal;  ///< unit, outwards
};

struct Profile {
  std::array<Side, 3> sides;
  std::size_t count;
};

Profile profile_of(const Revolved& solid) {
  const double r = solid.radius;
  const double h = solid.half_height;
  if (solid.is_cone) {
    return {{{{{0, -h}, {r, -h}, {0, -1}}, {{r, -h}, {0, h}, {solid.side_cosine(), solid.side_sine()}}, {}}}, 2};
  }
  return {{{{{0, -h}, {r, -h}, {0, -1}}, {{r, -h}, {r, h}, {1, 0}}, {{r, h}, {0, h}, {0, 1}}}}, 3};
}

Vector2 nearest_on(const Side& side, const Vector2& point) {
  const Vector2 along = side.end - side.begin;
  const double t = std::clamp((point - side.begin).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return side.begin + t * along;
}

}  // namespace

SignedDistance signed_distance(const Revolved& solid, const Vector3& point) {
  const double z = solid.axis.dot(point);
  const Vector3 aside = point - z * solid.axis;
  const Vector2 p(aside.norm(), z);
  Vector3 radial;
  if (p.x() > 0) {
    radial = aside / p.x();
  } else {
    int smallest = 0;
    solid.axis.cwiseAbs().minCoeff(&smallest);
    radial = solid.axis.cross(Vector3::Unit(smallest)).normalized();
  }

  // Inside, or in front of one side alone, the distance is to a side's line; else to the nearest point of a side.
  const Profile profile = profile_of(solid);
  double farthest = -INFINITY;
  Vector2 normal = Vector2::UnitY();
  for (std::size_t i = 0; i < profile.count; ++i) {
    const double height = profile.sides[i].normal.dot(p - profile.sides[i].begin);
    if (height > farthest) {
      farthest = height;
      normal = profile.sides[i].normal;
    }
  }
  if (farthest > 0) {
    double nearest = INFINITY;
    Vector2 away = normal;
    for (std::size_t i = 0; i < profile.count; ++i) {
      const Vector2 difference = p - nearest_on(profile.sides[i], p);
      if (difference.norm() < nearest) {
        nearest = difference.norm();
        away = difference;
      }
    }
    farthest = nearest;
    if (nearest > 0) normal = away / nearest;
  }
  return {farthest, normal.x() * radial + normal.y() * solid.axis};
}

}  // namespace atl::audit
