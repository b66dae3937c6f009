#pragma once
/// A block on a slope, as a tilted plane under plain gravity and as a level plane under tilted gravity: the same
/// physics through different code paths.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "support/bodies.h"

namespace atl::test {

enum class Tilt { Gravity, Ground };

/// Names the instances of a parameterised test.
inline std::string tilt_name(const testing::TestParamInfo<Tilt>& info) {
  return info.param == Tilt::Gravity ? "TiltedGravity" : "TiltedGround";
}

struct Incline {
  World world;
  BodyId plane;
  BodyId block;
  Vector3 downhill;  ///< unit, along the slope
  Vector3 start;     ///< of the block's centre
  double step = dt;

  /// Runs for `seconds` and returns how far the block has moved down the slope since the start.
  double slide(double seconds) {
    run(world, static_cast<int>(std::lround(seconds / step)), step);
    return travel();
  }
  double travel() const { return (world.pose(block).position - start).dot(downhill); }
  double speed() const { return world.velocity(block).dot(downhill); }
};

/// The block rests on the slope with its edges along and across it, touching without overlap.
inline Incline make_incline(double angle, double friction, Tilt tilt,
                            const Vector3& half_extents = Vector3::Constant(0.5)) {
  const double tilt_ground = tilt == Tilt::Ground ? angle : 0;
  const double tilt_gravity = tilt == Tilt::Gravity ? angle : 0;
  const Quaternion turn(Eigen::AngleAxisd(tilt_ground, Vector3::UnitY()));
  const Vector3 normal = turn * Vector3::UnitZ();

  Incline incline{.world = World({.gravity = g * Vector3(std::sin(tilt_gravity), 0, -std::cos(tilt_gravity))}),
                  .plane = {},
                  .block = {},
                  .downhill = turn * Vector3::UnitX(),
                  .start = half_extents.z() * normal};
  const Material material = {.friction = friction};
  incline.plane =
      incline.world.add_body({.type = BodyType::Static, .shape = HalfSpace{.normal = normal}, .material = material});
  incline.block = incline.world.add_body(
      {.shape = Box{half_extents}, .position = incline.start, .orientation = turn, .material = material});
  return incline;
}

}  // namespace atl::test
