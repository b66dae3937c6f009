#pragma once
/// The structure of a mechanism: which joint carries which body, and where its coordinates are.

#include <atoll/mechanism.h>
#include <atoll/world.h>

#include <cstddef>
#include <string>
#include <vector>

#include "world/world_impl.h"

namespace atl {

/// The stores of a world, for mechanisms to read.
struct MechanismAccess {
  static const Stores& stores(const World& world) { return world.impl_->stores; }
};

namespace mechanism {

enum class Motion { Turn, Slide, Ball, Free };

/// A motion from one frame to the next: about or along one of its axes, or any turn or motion at all. A joint is a
/// sequence of these, from its first frame to its second one.
struct Stage {
  Motion motion;
  int axis = 0;                ///< of a turn or slide
  std::size_t coordinate = 0;  ///< likewise, as JointState numbers it
  bool locked = false;         ///< likewise: by its range, and without places in q and v
  std::size_t q = 0;           ///< first place in q
  std::size_t v = 0;           ///< first place in v

  bool has_axis() const { return motion == Motion::Turn || motion == Motion::Slide; }
  std::size_t q_count() const { return has_axis() ? !locked : motion == Motion::Ball ? 4 : 7; }
  std::size_t v_count() const { return has_axis() ? !locked : motion == Motion::Ball ? 3 : 6; }
};

/// A body, and the joint by which another one carries it; or a free base, which has none.
struct Link {
  static constexpr std::size_t none = static_cast<std::size_t>(-1);

  BodyId body;
  std::size_t parent = none;  ///< the link that carries it; none: the fixed base, or nothing
  JointId joint = {};
  bool reversed = false;  ///< true if the joint's first body is this one
  Pose frame_first = {};  ///< in the body's frame
  Pose frame_second = {};
  std::vector<Stage> stages = {};
};

/// Calls visit(place in v) for the coordinates of a link's own joint.
template <typename Visit>
void for_each_place(const Link& link, const Visit& visit) {
  for (const Stage& stage : link.stages) {
    for (std::size_t i = stage.v; i < stage.v + stage.v_count(); ++i) visit(static_cast<Eigen::Index>(i));
  }
}

struct Tree {
  BodyId base;
  bool floating = false;
  std::vector<Link> links = {};     ///< each after its parent
  std::vector<BodyId> bodies = {};  ///< of the links
  std::vector<MechanismJoint> joints = {};
  std::vector<JointId> loops = {};
  std::size_t nq = 0;
  std::size_t nv = 0;
  std::size_t enabled_joints = 0;  ///< on the links, counted once for each
};

/// Throws Error as the constructor of Mechanism does.
Tree make_tree(const World& world, BodyId base);

/// Throws Error if the tree is no longer that of the world.
void check_unchanged(const Tree& tree, const World& world);

/// The range, armature and so on along one of a link's turns or slides.
const JointAxis& axis_of(const World& world, const Link& link, const Stage& stage);

}  // namespace mechanism
}  // namespace atl
