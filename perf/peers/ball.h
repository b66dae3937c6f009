#pragma once
/// The joints of a scene as other engines want them: ball joints between solids, and which bodies may touch.

#include <atoll/scene.h>

#include <string>
#include <vector>

#include "solid.h"

namespace peer {

/// Two points that stay together, one on each of two bodies of the scene.
struct Ball {
  std::size_t first = 0;
  std::size_t second = 0;
  atl::Vector3 at_first = atl::Vector3::Zero();  ///< in the solid's frame
  atl::Vector3 at_second = atl::Vector3::Zero();
};

/// All joints of the scene, in order. Throws atl::Error, in the engine's name, on one that is not a ball joint without
/// friction that never breaks: no driver hands others on.
std::vector<Ball> balls_of(const atl::Scene& scene, const std::vector<Solid>& solids, const std::string& engine);

/// Which bodies may touch; empty where all may.
atl::MayTouch exceptions_to_touch(const atl::Scene& scene);

}  // namespace peer
