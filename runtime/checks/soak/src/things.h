#pragma once

#include <atoll/body.h>
#include <atoll/joint.h>

#include <vector>

#include "scene/src/random.h"

namespace atl::soak {

using scene::Random;

/// A joint between two bodies of a thing; frames in the thing's frame.
struct Link {
  JointKind kind;
  std::size_t first = 0;
  std::size_t second = 0;
  Pose at = {};         ///< the first body's frame
  Pose at_second = {};  ///< likewise; where it starts at another place
  double break_force = unlimited;
};

/// Bodies, and the joints between them, that come and go together. In a frame of its own, around its middle; nothing
/// overlaps, but what is joined, and no joint starts open.
struct Thing {
  const char* kind = "";
  Vector3 half = Vector3::Zero();  ///< m: a box that holds it
  std::vector<BodyDef> bodies = {};
  std::vector<Link> links = {};
};

/// How many kinds there are.
std::size_t thing_kinds();
/// One of a kind, of random size and material.
Thing make_thing(std::size_t kind, Random& random);

/// The body in the world, given the pose of its thing's frame there.
BodyDef placed(const BodyDef& body, const Pose& thing);
/// `first` and `second` are the bodies' ids.
JointDef joint_of(const Link& link, const Thing& thing, BodyId first, BodyId second);

/// A value in [0, count).
inline std::size_t pick(Random& random, std::size_t count) {
  return static_cast<std::size_t>(random.next() % static_cast<std::uint64_t>(count));
}
inline bool chance(Random& random, int one_in) { return pick(random, static_cast<std::size_t>(one_in)) == 0; }

}  // namespace atl::soak
