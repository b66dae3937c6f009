#pragma once

#include <string>

namespace atl::scene {

/// Size of a scene, as far as memory goes. Counts are doubles: they may be too large for any integer.
struct SceneSize {
  double bodies = 0;
  double joints = 0;
  double hull_vertices = 0;  ///< of hulls that aren't shared
  double triangles = 0;      ///< of meshes; two a cell of height fields

  double bytes() const;  ///< that a run needs, about
};

/// Memory that can still be allocated, bytes: the least of what the system has, the limit of this process's group and
/// its own limit. Infinite if none of these is known.
double available_memory();

/// "about 5.0 TB of memory, of which 23 GB are free" if so many bytes are more than there are, else "".
std::string memory_words(double bytes);
inline std::string memory_words(const SceneSize& size) { return memory_words(size.bytes()); }

}  // namespace atl::scene
