#pragma once
/// A small world for snapshots and recordings, and every call that changes one.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "state/recorded_calls.h"
#include "state/recording_file.h"
#include "support/bodies.h"

namespace atl::test {

inline ConvexHull wedge(double size) {
  const std::array<Vector3, 7> corners = {Vector3(0, 0, 0),        Vector3(size, 0, 0),    Vector3(0, size, 0),
                                          Vector3(0, 0, size),     Vector3(size, 0, size), Vector3(0, size, size),
                                          Vector3(size, size, 0.3)};
  return ConvexHull(corners);
}

inline TriangleMesh slab() {
  const std::array<Vector3, 4> corners = {Vector3(-3, -3, 0.1), Vector3(3, -3, 0), Vector3(3, 3, 0.2),
                                          Vector3(-3, 3, 0)};
  const std::array<TriangleMesh::Indices, 2> triangles = {TriangleMesh::Indices{0, 1, 2}, {0, 2, 3}};
  return {corners, triangles};
}

inline HeightField hills() { return {3, 3, 2, 2, {0, 0.2, 0.1, 0.3, 0, 0.2, 0.1, 0, 0}}; }

/// Two crates on the ground, a ball hinged to the upper one, and a hull.
struct Yard {
  World world;
  std::vector<BodyId> ids;
  JointId hinge;

  explicit Yard(const WorldDef& def = {}, double ball = 0.4, double hull = 1) : world(def) {
    ids.push_back(world.add_body(ground()));
    for (const BodyId id : add_stack(world, 2)) ids.push_back(id);
    ids.push_back(world.add_body(sphere({1.2, 0, 1.5}, ball)));
    ids.push_back(world.add_body({.shape = wedge(hull), .position = {4, 4, 1}}));
    hinge = world.add_joint({.kind = HingeJoint{{.range = {-1, 1}}},
                             .first = ids[2],
                             .second = ids[3],
                             .frame_first = {{0.6, 0, 0}},
                             .frame_second = {{-0.6, 0, 0}}});
  }
};

/// A call, or a few, that change a yard, and how many of them a recording has.
struct Change {
  const char* name;
  RecordKind kind;
  std::function<void(Yard&)> make;
};

inline const std::vector<Change>& changes() {
  static const std::vector<Change> all = {
      {"a body is added", RecordKind::AddBody,
       [](Yard& yard) {
         yard.world.add_body({.shape = Compound{{{.shape = Sphere{0.2}}, {.shape = wedge(0.7), .position = {0, 1, 0}}}},
                              .position = {-4, 0, 2},
                              .orientation = Quaternion(0.5, 0.1, 0.2, 3),
                              .velocity = {1, 2, 3},
                              .angular_velocity = {3, 2, 1},
                              .material = {.friction = 0.3,
                                           .friction_direction = {1, 0, 0},
                                           .restitution = 0.4,
                                           .rolling_friction = 0.01},
                              .surface_velocity = {0, 0.1, 0},
                              .surface_angular_velocity = {0, 0, 0.2},
                              .gravity_scale = 0.9,
                              .linear_damping = 0.1,
                              .locks = {.linear = {false, true, false}, .angular = {true, false, true}},
                              .filter = {.category = 2, .mask = 7, .group = 3},
                              .continuous = true});
       }},
      {"geometry is added", RecordKind::Geometry,
       [](Yard& yard) {
         yard.world.add_body({.type = BodyType::Static, .shape = slab(), .position = {4, 4, 0.1}});
         yard.world.add_body({.type = BodyType::Static, .shape = hills(), .position = {-6, -6, 0}});
         yard.world.add_body(sphere({-5, -5, 1}, 0.3));
       }},
      {"ground that is dug away", kind_of<calls::SetHeights>(),
       [](Yard& yard) {
         const BodyId id = yard.world.add_body({.type = BodyType::Static, .shape = hills(), .position = {3, 3, 0.5}});
         yard.world.set_heights(id, 1, 0, 2, std::array{0.4, std::nan(""), -0.2, 0.3});
       }},
      {"a body is removed", kind_of<calls::RemoveBody>(), [](Yard& yard) { yard.world.remove_body(yard.ids[1]); }},
      {"a pose", kind_of<calls::SetPose>(),
       [](Yard& yard) {
         yard.world.set_pose(yard.ids[4], {{0.1, 0, 3}, Quaternion(1, 0.3, 0, 0)});
       }},
      {"a velocity", kind_of<calls::SetVelocity>(),
       [](Yard& yard) {
         yard.world.set_velocity(yard.ids[3], {1, 2, 3}, {4, 5, 6});
       }},
      {"a pair of materials", kind_of<calls::SetMaterialPair>(),
       [](Yard& yard) {
         yard.world.set_material_pair({.first = 2, .second = 1, .friction = 0.9, .restitution = 0.5});
       }},
      {"a belt", kind_of<calls::SetSurfaceVelocity>(),
       [](Yard& yard) {
         yard.world.set_surface_velocity(yard.ids[0], {1, 0.5, 0}, {0, 0, 0.5});
       }},
      {"a force", kind_of<calls::ApplyForce>(),
       [](Yard& yard) {
         yard.world.apply_force(yard.ids[2], {1e4, 20, 3}, {10, 0, -4});
       }},
      {"an impulse", kind_of<calls::ApplyImpulse>(),
       [](Yard& yard) {
         yard.world.apply_impulse(yard.ids[2], {100, 20, 3}, {0.1, 0.2, 2});
       }},
      {"a call to wake", kind_of<calls::Wake>(), [](Yard& yard) { yard.world.wake(yard.ids[2]); }},
      {"a filter", kind_of<calls::SetFilter>(),
       [](Yard& yard) { yard.world.set_filter(yard.ids[1], {.category = 2, .mask = 4, .group = -3}); }},
      {"two that don't touch", kind_of<calls::SetCollisionEnabled>(),
       [](Yard& yard) { yard.world.set_collision_enabled(yard.ids[1], yard.ids[2], false); }},
      {"quarantine and release", kind_of<calls::Release>(),
       [](Yard& yard) {
         yard.world.set_velocity(yard.ids[3], {1e9, 0, 0}, {0, 0, 0});
         yard.world.step(dt);
         ASSERT_TRUE(yard.world.is_quarantined(yard.ids[3]));
         yard.world.release(yard.ids[3]);
       }},
      {"a joint is added", kind_of<calls::AddJoint>(),
       [](Yard& yard) {
         yard.world.add_joint({.kind = SliderJoint{{.spring = JointSpring{.hertz = 3, .damping_ratio = 0.2}}},
                               .first = yard.ids[0],
                               .second = yard.ids[4],
                               .frame_first = {{4, 4, 1}, Quaternion(2, 0, 0, 1)},
                               .collide = true,
                               .break_force = 1e5});
       }},
      {"a joint is removed", kind_of<calls::RemoveJoint>(), [](Yard& yard) { yard.world.remove_joint(yard.hinge); }},
      {"a motor", kind_of<calls::SetJoint>(),
       [](Yard& yard) {
         yard.world.set_joint(yard.hinge, HingeJoint{{.motor = JointMotor{.speed = 3, .max_force = 10}}});
       }},
      {"a joint elsewhere", kind_of<calls::SetJointDefinition>(),
       [](Yard& yard) {
         JointDef def = yard.world.joint(yard.hinge);
         def.frame_first.position += Vector3(0.1, 0, 0.2);
         def.break_torque = 1e6;
         yard.world.set_joint(yard.hinge, def);
       }},
      {"a joint that is let go", kind_of<calls::SetJointEnabled>(),
       [](Yard& yard) { yard.world.set_joint_enabled(yard.hinge, false); }},
      {"an angle a turn on", kind_of<calls::CountTurnsFrom>(),
       [](Yard& yard) { yard.world.count_turns_from(yard.hinge, 2 * std::numbers::pi); }},
      {"gravity", kind_of<calls::SetGravity>(),
       [](Yard& yard) {
         yard.world.set_gravity({1, 0, -3});
       }},
      {"settings", kind_of<calls::SetSettings>(),
       [](Yard& yard) {
         yard.world.set_settings({.substeps = 3, .contact_hertz = 25, .sleeping = true, .simd = Simd::Portable});
       }},
      {"a body that is disabled", kind_of<calls::SetEnabled>(),
       [](Yard& yard) { yard.world.set_enabled(yard.ids[0], false); }},
      {"a body that is put to sleep", kind_of<calls::Sleep>(),
       [](Yard& yard) {
         yard.world.set_settings({.sleeping = true});
         yard.world.sleep(yard.ids[1]);
       }},
      {"a question again", kind_of<calls::Refilter>(), [](Yard& yard) { yard.world.refilter(yard.ids[0]); }},
      {"what functions say of contacts", RecordKind::ContactAnswers,
       [](Yard& yard) {
         yard.world.set_contact_filter([](const ContactCandidate& of) { return of.b.index % 2 == 0; });
         yard.world.set_contact_modifier([](ModifiableContact& contact) { contact.friction = 0.01; });
         yard.world.refilter(yard.ids[0]);
       }},
      {"a restored state", RecordKind::State,
       [](Yard& yard) {
         Snapshot snapshot;
         yard.world.save(snapshot);
         yard.world.remove_body(yard.ids[4]);
         yard.world.add_body(sphere({7, 7, 1}));
         yard.world.step(dt);
         yard.world.restore(snapshot);
       }},
  };
  return all;
}

}  // namespace atl::test
