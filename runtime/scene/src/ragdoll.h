#pragma once

#include <atoll/scene.h>

namespace atl::scene {

/// All of a ragdoll lies within this of its middle, m.
inline constexpr double ragdoll_reach = 1.04;

/// Adds a jointed figure of 13 parts, 1.9 m tall and 72 kg, with its arms stretched out to the sides. Its middle is
/// placed at the pose; upright, z points to the head and x ahead. Elbows, knees and ankles are hinges within their
/// ranges, shoulders and hips cones with a limited twist, waist and neck limited about all axes. All have a little
/// friction.
void add_ragdoll(Scene& scene, int number, const Pose& pose);

}  // namespace atl::scene
