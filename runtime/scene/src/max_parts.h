#pragma once

#include <cstddef>

namespace atl::scene {

/// Limits of a scene, built-in or from a file: a mistyped count should not exhaust the memory.
inline constexpr std::size_t max_bodies = 10'000'000;
inline constexpr std::size_t max_joints = 10'000'000;

}  // namespace atl::scene
