#include "mechanism/tree.h"

#include <atoll/error.h>
#include <jobs/assert.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <sstream>
#include <variant>

#include "world/make_joint.h"
#include "world/refuse.h"

namespace atl::mechanism {
namespace {

std::string text_of(const World& world, JointId id) {
  std::ostringstream text;
  text << "joint ";
  if (world.contains(id) && !world.joint(id).name.empty()) text << "'" << world.joint(id).name << "' ";
  text << "(index " << id.index << ", generation " << id.generation << ")";
  return text.str();
}

bool is_enabled(const Stores& stores, std::uint32_t joint) {
  return stores.joints.enabled[joint] != 0 && stores.joints.broken[joint] == 0;
}

// Enabled joints of a body, in order of their indices.
std::vector<JointId> joints_of(const Stores& stores, BodyId body) {
  std::vector<JointId> found;
  stores.joints.for_each_of(body.index, [&](std::uint32_t joint) {
    if (is_enabled(stores, joint)) found.push_back({joint, stores.joints.generation[joint]});
  });
  std::sort(found.begin(), found.end());
  return found;
}

// Gears and rods hold one coordinate of two bodies that others carry.
bool carries(const JointDef& joint) {
  return !std::holds_alternative<GearJoint>(joint.kind) && !std::holds_alternative<DistanceJoint>(joint.kind);
}

BodyId other_body(const JointDef& joint, BodyId body) { return joint.first == body ? joint.second : joint.first; }

bool is_locked(const JointAxis& axis) { return axis.range.lower == axis.range.upper; }

// The motions that a kind leaves free, in the order in which they lead from the first frame to the second.
struct Stages {
  using Found = std::vector<Stage>;

  std::string joint;  // for messages

  [[noreturn]] void refuse_kind(const char* kind) const {
    throw Error("Mechanism: " + joint + " is a " + kind +
                "; expected hinges, sliders, balls, fixed and universal joints, wheels, or six-dof joints of which all "
                "turns are angles, or locked at 0, or free and without armature");
  }

  static Stage along(Motion motion, int axis, std::size_t coordinate, const JointAxis& law) {
    return {.motion = motion, .axis = axis, .coordinate = coordinate, .locked = is_locked(law)};
  }

  Found operator()(const BallJoint&) const { return {{.motion = Motion::Ball}}; }
  Found operator()(const HingeJoint& hinge) const { return {along(Motion::Turn, 0, 0, hinge.angle)}; }
  Found operator()(const SliderJoint& slider) const { return {along(Motion::Slide, 0, 0, slider.offset)}; }
  Found operator()(const FixedJoint&) const { return {}; }
  Found operator()(const UniversalJoint& cross) const {
    return {along(Motion::Turn, 0, 0, cross.first), along(Motion::Turn, 1, 1, cross.second)};
  }
  Found operator()(const WheelJoint& wheel) const {
    return {along(Motion::Slide, 2, 0, wheel.suspension), along(Motion::Turn, 2, 1, wheel.steering),
            along(Motion::Turn, 1, 2, wheel.spin)};
  }
  Found operator()(const SixDofJoint& six) const {
    Found found;
    for (int axis = 0; axis < 3; ++axis) {
      const auto place = static_cast<std::size_t>(axis);
      found.push_back(along(Motion::Slide, axis, place, six.offset[place]));
    }
    if (six.turns != SixDofTurns::Vector) {
      for (const int axis : six.turns == SixDofTurns::AnglesXYZ ? std::array{0, 1, 2} : std::array{0, 2, 1}) {
        const auto place = static_cast<std::size_t>(axis);
        found.push_back(along(Motion::Turn, axis, 3 + place, six.turn[place]));
      }
      return found;
    }
    const auto is_at_zero = [](const JointAxis& turn) { return turn.range.lower == 0 && turn.range.upper == 0; };
    const auto is_free = [](const JointAxis& turn) { return !is_locked(turn) && turn.armature == 0; };
    if (std::all_of(six.turn.begin(), six.turn.end(), is_at_zero)) return found;
    if (!std::all_of(six.turn.begin(), six.turn.end(), is_free)) refuse_kind("SixDofJoint with such turns");
    found.push_back({.motion = Motion::Ball});
    return found;
  }
  Found operator()(const ConeTwistJoint&) const { refuse_kind("ConeTwistJoint"); }
  Found operator()(const DistanceJoint&) const { return {}; }
  Found operator()(const GearJoint&) const { return {}; }
  Found operator()(const TendonJoint&) const { return {}; }
};

std::vector<Stage> stages_of(const World& world, JointId id) {
  return std::visit(Stages{text_of(world, id)}, world.joint(id).kind);
}

// Dynamic bodies that hang together, and joints from them to others, in order.
struct Component {
  std::set<BodyId> bodies;
  std::map<JointId, BodyId> anchors;

  Component(const World& world, BodyId start) : bodies{start} {
    std::vector<BodyId> reached = {start};
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (const JointId id : joints_of(MechanismAccess::stores(world), reached[i])) {
        const JointDef& joint = world.joint(id);
        if (!carries(joint)) continue;
        const BodyId other = other_body(joint, reached[i]);
        if (world.type(other) != BodyType::Dynamic) {
          anchors.emplace(id, other);
        } else if (bodies.insert(other).second) {
          reached.push_back(other);
        }
      }
    }
  }
};

// Adds what hangs on the base, breadth first; of all bodies if there are no `members`.
void grow(const World& world, const std::set<BodyId>& members, Tree& tree) {
  const Stores& stores = MechanismAccess::stores(world);
  std::map<BodyId, std::size_t> link_of;
  if (tree.floating) {
    tree.links.push_back({.body = tree.base, .stages = {{.motion = Motion::Free}}});
    link_of[tree.base] = 0;
  }
  std::set<JointId> used, loops;
  const auto visit = [&](BodyId body, std::size_t link) {
    for (const JointId id : joints_of(stores, body)) {
      const JointDef& joint = world.joint(id);
      ATL_ASSERT(joint.first == body || joint.second == body, id.index, body.index);
      const BodyId other = other_body(joint, body);
      const bool dynamic = world.type(other) == BodyType::Dynamic;
      if (used.contains(id) || (link == Link::none && !members.empty() && !members.contains(other))) continue;
      if (!carries(joint) || !dynamic || link_of.contains(other)) {
        loops.insert(id);
        continue;
      }
      used.insert(id);
      link_of[other] = tree.links.size();
      tree.links.push_back({.body = other,
                            .parent = link,
                            .joint = id,
                            .reversed = joint.first == other,
                            .frame_first = joint.frame_first,
                            .frame_second = joint.frame_second,
                            .stages = stages_of(world, id)});
    }
  };
  if (!tree.floating) visit(tree.base, Link::none);
  for (std::size_t link = 0; link < tree.links.size(); ++link) visit(tree.links[link].body, link);
  tree.loops.assign(loops.begin(), loops.end());
}

// Gives coordinates their places: a free base first, then joints in order.
void number_coordinates(const World& world, Tree& tree) {
  std::vector<Link*> ordered;
  for (Link& link : tree.links) ordered.push_back(&link);
  const auto place = [&](const Link* link) {
    return std::pair(link->stages.empty() || link->stages[0].motion != Motion::Free, link->joint);
  };
  std::sort(ordered.begin(), ordered.end(), [&](const Link* a, const Link* b) { return place(a) < place(b); });
  for (Link* link : ordered) {
    const bool has_joint = world.contains(link->joint);
    MechanismJoint joint{.joint = link->joint,
                         .name = has_joint ? world.joint(link->joint).name : std::string(world.name(link->body)),
                         .body = link->body,
                         .q = tree.nq,
                         .v = tree.nv};
    for (Stage& stage : link->stages) {
      stage.q = tree.nq;
      stage.v = tree.nv;
      tree.nq += stage.q_count();
      tree.nv += stage.v_count();
    }
    joint.q_count = tree.nq - joint.q;
    joint.v_count = tree.nv - joint.v;
    tree.joints.push_back(joint);
  }
}

std::size_t count_joints(const Tree& tree, const Stores& stores) {
  std::size_t count = 0;
  for (const Link& link : tree.links) {
    stores.joints.for_each_of(link.body.index, [&](std::uint32_t joint) { count += is_enabled(stores, joint); });
  }
  return count;
}

void check_body(const World& world, BodyId body) {
  if (!world.contains(body)) refuse_stale("Mechanism", body);
  const auto refuse = [&](const char* what) {
    throw Error("Mechanism: the body with index " + std::to_string(body.index) + what);
  };
  if (world.is_quarantined(body)) refuse(" is in quarantine; expected one that takes part");
  if (MechanismAccess::stores(world).bodies.locks[body.index] != 0) {
    refuse(" has motion locks; expected none: a SixDofJoint to a static body holds the same axes");
  }
}

}  // namespace

Tree make_tree(const World& world, BodyId base) {
  check_body(world, base);
  Tree tree{.base = base};
  std::set<BodyId> members;
  if (world.type(base) == BodyType::Dynamic) {
    const Component component(world, base);
    members = component.bodies;
    tree.floating = component.anchors.empty();
    if (!tree.floating) tree.base = component.anchors.begin()->second;
  }
  grow(world, members, tree);
  if (tree.links.empty()) {
    throw Error("Mechanism: no joint hangs a dynamic body on the base (index " + std::to_string(base.index) +
                "), which is not dynamic itself; expected a base on which something hangs");
  }
  for (const Link& link : tree.links) {
    check_body(world, link.body);
    tree.bodies.push_back(link.body);
    ATL_ASSERT(link.parent == Link::none || link.parent + 1 < tree.bodies.size(), link.body.index, link.parent,
               tree.bodies.size());
  }
  number_coordinates(world, tree);
  ATL_ASSERT(tree.joints.size() == tree.links.size(), tree.joints.size(), tree.links.size());
  tree.enabled_joints = count_joints(tree, MechanismAccess::stores(world));
  return tree;
}

const JointAxis& axis_of(const World& world, const Link& link, const Stage& stage) {
  return *named_axis(world.joint(link.joint).kind, stage.coordinate);
}

void check_unchanged(const Tree& tree, const World& world) {
  const Stores& stores = MechanismAccess::stores(world);
  const std::string expected = "; expected the structure that it was made of: make another one";
  check_body(world, tree.base);
  for (const Link& link : tree.links) {
    check_body(world, link.body);
    if (link.joint == JointId{}) continue;
    const bool there = world.contains(link.joint);
    if (!there || !is_enabled(stores, link.joint.index)) {
      throw Error("Mechanism: " + text_of(world, link.joint) + (there ? " is no longer enabled" : " was removed") +
                  expected);
    }
    for (const Stage& stage : link.stages) {
      if (!stage.has_axis() || is_locked(axis_of(world, link, stage)) == stage.locked) continue;
      throw Error("Mechanism: coordinate " + std::to_string(stage.coordinate) + " of " + text_of(world, link.joint) +
                  " was " + (stage.locked ? "unlocked" : "locked") + expected);
    }
  }
  if (count_joints(tree, stores) != tree.enabled_joints) {
    throw Error("Mechanism: joints came to bodies of the tree, or went" + expected);
  }
}

}  // namespace atl::mechanism
