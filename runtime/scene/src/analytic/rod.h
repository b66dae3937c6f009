#pragma once
/// Rods that hang from one another, and measures of them.

#include "../joined_scene.h"
#include "setting.h"

namespace atl::scene {

inline constexpr double rod_half_width = 0.03;  // m

/// A rod of a length (m) whose upper end is at a place in the x-z plane, turned from hanging straight down by an angle
/// (rad) towards x. It touches nothing. The frame's z axis points up along it.
inline SceneBody hanging_rod(std::string name, double length, const Vector3& top, double angle) {
  SceneBody body = solid(std::move(name), Box{{rod_half_width, rod_half_width, length / 2}}, Vector3::Zero(), {});
  body.def.orientation = turned(-angle, Vector3::UnitY());
  body.def.position = top - body.def.orientation * Vector3(0, 0, length / 2);
  return untouched(body);
}

/// Angle of a rod from hanging straight down towards x, rad in (-pi, pi].
inline double angle_of_rod(const BodyState& state) {
  const Vector3 up = state.pose.orientation * Vector3::UnitZ();
  return std::atan2(-up.x(), up.z());
}

/// A frame with its x axis, about which a hinge turns, along the world's -y axis: angles grow from z up towards -x,
/// and so of what hangs towards x.
inline Quaternion swinging() { return frame_along(-Vector3::UnitY()); }

}  // namespace atl::scene
