#pragma once

#include <atoll/scene.h>

#include <string>

namespace atl::scene {

/// A pose in the world as seen from a body where it starts.
Pose seen_from(const BodyDef& body, const Pose& world);

/// Orientation of the frame with this x axis and the y axis nearest to `towards_y`, which must not be parallel to it
/// and neither of which has to be of unit length. By square roots alone, so the same on every machine.
Quaternion frame_along(const Vector3& x, const Vector3& towards_y);

/// The same with the y axis nearest to the world's z, or to its x where the x axis is close to that.
Quaternion frame_along(const Vector3& x);

/// A joint between two bodies of the scene, by their places, with both frames at one pose in the world.
SceneJoint joined(const Scene& scene, std::string name, const JointKind& kind, std::size_t first, std::size_t second,
                  const Pose& frame);

}  // namespace atl::scene
