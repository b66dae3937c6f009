// Which ids are joints': asked also in builds without them.

#include <atoll/error.h>

#include <sstream>

#include "world/joints.h"

namespace atl {

bool contains(const Stores& world, JointId id) {
  const JointTable& joints = world.joints;
  return id.index < joints.size() && joints.alive[id.index] && joints.generation[id.index] == id.generation;
}

std::uint32_t index_of(const Stores& world, JointId id, const char* call) {
  if (contains(world, id)) return id.index;
  std::ostringstream message;
  message << "World::" << call << ": no joint has the id (index " << id.index << ", generation " << id.generation
          << "); expected the id of a joint that has not been removed, by itself or with a body";
  throw Error(message.str());
}

}  // namespace atl
