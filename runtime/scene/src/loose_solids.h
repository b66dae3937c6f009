#pragma once

#include <atoll/scene.h>

#include <algorithm>
#include <string>

#include "building_blocks.h"
#include "random.h"

namespace atl::scene {

/// A hull like a rock: points at random on an ellipsoid whose half axes are 0.6 to 1 of `radius` (m).
inline ConvexHull random_rock(Random& random, double radius, int min_points, int max_points) {
  const int count = min_points + static_cast<int>(random.uniform(0, max_points - min_points + 1));
  Vector3 axes;
  for (double& axis : axes) axis = radius * random.uniform(0.6, 1);
  std::vector<Vector3> points;
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) points.push_back(axes.cwiseProduct(random.rotation() * Vector3::UnitX()));
  return ConvexHull(points);
}

/// Places for bodies that fit in a cube of `pitch` (m): rows along x, rows to layers along y, layers upwards from
/// `bottom`, in a square of `half` around the z axis.
class LoosePlaces {
 public:
  LoosePlaces(double pitch, double half, double bottom)
      : pitch_(pitch), a_row_(std::max(1, static_cast<int>(2 * half / pitch))), bottom_(bottom) {}

  Vector3 operator[](int i) const {
    const double middle = 0.5 * (a_row_ - 1);
    return {pitch_ * (i % a_row_ - middle), pitch_ * (i / a_row_ % a_row_ - middle),
            bottom_ + pitch_ * (i / (a_row_ * a_row_) + 0.5)};
  }

 private:
  double pitch_;
  int a_row_;
  double bottom_;
};

inline SceneBody loose_solid(std::string name, const Shape& shape, const Vector3& place, const Quaternion& turn) {
  return {.name = std::move(name),
          .def = {.shape = shape,
                  .position = place,
                  .orientation = turn,
                  .density = builtin_density,
                  .material = builtin_material}};
}

}  // namespace atl::scene
