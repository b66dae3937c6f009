#pragma once

#include <cstdint>

namespace atl {

/// 64-bit hashes of the state of one body, by part, to tell where two worlds part: see World::body_hashes(). Static and
/// kinematic bodies have no contacts and joints of their own: these count for the dynamic bodies that they hold.
struct BodyHash {
  std::uint64_t pose = 0;      ///< position and orientation
  std::uint64_t velocity = 0;  ///< linear and angular
  std::uint64_t input = 0;     ///< forces and torques for the next step, surface, what it may touch, its id
  std::uint64_t rest = 0;      ///< asleep or awake, for how long, and what sleeps with it
  std::uint64_t bounds = 0;    ///< fat boxes, and how far it may still move within them
  std::uint64_t contacts = 0;  ///< how they were found, and their impulses; how long they were overloaded
  std::uint64_t joints = 0;    ///< their definitions, limits and impulses

  friend bool operator==(const BodyHash&, const BodyHash&) = default;
};

}  // namespace atl
