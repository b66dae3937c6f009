#include "ball.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace peer {
namespace {

std::string kind_name(const atl::JointKind& kind) {
  constexpr std::array names = {
      "a ball joint",       "a hinge",         "a slider", "a fixed joint", "a distance joint", "a universal joint",
      "a cone-twist joint", "a six-dof joint", "a gear",   "a wheel"};
  static_assert(names.size() == std::variant_size_v<atl::JointKind>);
  return names.at(kind.index());
}

// Names the feature that makes a joint more than a plain ball joint; empty if there is none.
std::string found_beyond_ball(const atl::JointDef& def) {
  const auto* ball = std::get_if<atl::BallJoint>(&def.kind);
  if (ball == nullptr) return kind_name(def.kind);
  if (ball->friction > 0) return "a ball joint with friction";
  const bool breaks = std::isfinite(def.break_force) || std::isfinite(def.break_torque);
  return breaks ? "a ball joint that may break" : "";
}

}  // namespace

std::vector<Ball> balls_of(const atl::Scene& scene, const std::vector<Solid>& solids, const std::string& engine) {
  std::vector<Ball> balls;
  for (std::size_t i = 0; i < scene.joints.size(); ++i) {
    const atl::SceneJoint& joint = scene.joints[i];
    const std::string found = found_beyond_ball(joint.def);
    if (!found.empty()) {
      throw atl::Error("the " + engine + " driver knows ball joints without friction only: found " + found +
                       ", joint " + (joint.name.empty() ? std::to_string(i) : "\"" + joint.name + "\""));
    }
    const auto on_solid = [&](std::size_t body, const atl::Vector3& point) -> atl::Vector3 {
      const atl::Pose& frame = solids[body].frame;
      return frame.orientation.conjugate() * (point - frame.position);
    };
    balls.push_back({.first = joint.first,
                     .second = joint.second,
                     .at_first = on_solid(joint.first, joint.def.frame_first.position),
                     .at_second = on_solid(joint.second, joint.def.frame_second.position)});
  }
  return balls;
}

atl::MayTouch exceptions_to_touch(const atl::Scene& scene) {
  const auto admits_all = [](const atl::SceneBody& body) {
    const atl::CollisionFilter &filter = body.def.filter, any = {};
    return filter.category == any.category && filter.mask == any.mask && filter.group == any.group;
  };
  const auto collides = [](const atl::SceneJoint& joint) { return joint.def.collide; };
  const bool all = std::all_of(scene.bodies.begin(), scene.bodies.end(), admits_all) &&
                   std::all_of(scene.joints.begin(), scene.joints.end(), collides);
  return all ? atl::MayTouch() : atl::may_touch(scene);
}

}  // namespace peer
