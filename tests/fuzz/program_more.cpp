// Kinds of call that take several calls to come to something, and calls that a world must refuse.

#include <atoll/contact_callbacks.h>
#include <atoll/forces.h>

#include <cmath>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "consistency.h"
#include "finding.h"
#include "program_run.h"

namespace atl::fuzz {

namespace {

// Keeps each world's own instruction set.
void set_settings(Run& run, Settings settings) {
  run.call("set_settings", [&](World& world, std::size_t) {
    settings.simd = world.settings().simd;
    world.set_settings(settings);
  });
}

ConvexHull cube() {
  std::vector<Vector3> corners;
  for (const double x : {-1, 1}) {
    for (const double y : {-1, 1}) {
      for (const double z : {-1, 1}) corners.push_back({x, y, z});
    }
  }
  return ConvexHull(corners);
}

}  // namespace

// At what is fast for a sleeper, and in a step or two.
void fall_asleep(Run& run) {
  Settings settings = run.worlds.first().settings();
  settings.sleeping = true;
  settings.sleep_speed = run.definitions.number(0.1, 10);
  settings.time_to_sleep = run.definitions.number(0, 0.03);
  set_settings(run, settings);
  for (int left = 3; left > 0; --left) run.step("step", [](World& world) { return world.step(1.0 / 60); });
}

// To more kinds of body than a world keeps without looking which are still in use.
void change_often(Run& run) {
  const BodyId id = run.body();
  const double mass = run.definitions.number(0.1, 1000);
  for (int i = 0; i < 70; ++i) {
    const std::string error =
        run.call("set_mass", [&](World& world, std::size_t) { world.set_mass(id, mass * (1 + 0.01 * i)); });
    if (!error.empty()) return;
  }
}

// Views taken before bodies came and went, or before a restore, stay readable.
void keep_views(Run& run) {
  World& world = run.worlds.first();
  world.keep_views();
  look_at_views(run);
  if (run.views.size() < 8) run.views.push_back(world.positions());
}

void look_at_views(const Run& run) {
  for (const View& view : run.views) {
    require(view.allFinite() || !run.definitions.has_normal_numbers(), "a view tells what never was");
  }
}

// For one step: any set that the machine has comes to the same.
void change_instructions(Run& run) {
  const auto simd = static_cast<Simd>(run.bytes.below(8));
  std::vector<Settings> before;
  for (const World& world : run.worlds.worlds()) before.push_back(world.settings());
  const std::string error = run.call("set_settings", [&](World& world, std::size_t number) {
    Settings settings = before[number];
    settings.simd = simd;
    world.set_settings(settings);
    require(simd == Simd::Auto || world.simd() == simd, "a world has other instructions than it was told");
  });
  if (!error.empty()) return;
  run.step("step", [](World& world) { return world.step(1.0 / 60); });
  run.call("set_settings", [&](World& world, std::size_t number) { world.set_settings(before[number]); });
}

// By a definition of its own, if it can be made at all.
void make_a_world(Run& run) {
  const WorldDef def{.gravity = run.definitions.vector(12),
                     .threads = run.definitions.integer(1, 2),
                     .settings = run.definitions.settings(run.worlds.first().settings())};
  const std::optional<World> made = chosen([&] { return World(def); });
  require(made || !run.definitions.has_normal_numbers(), "a usual world is refused");
  if (!made) return;
  require(made->threads() == def.threads && made->gravity() == def.gravity && made->body_count() == 0,
          "a world is not as it was asked for");
  check_world(*made);
}

// As another body, or as it is but for a few fields.
void redefine(Run& run) {
  const BodyId id = run.body();
  const World& world = run.worlds.first();
  const std::optional<BodyDef> other = chosen([&] { return run.definitions.body(); });
  if (!other || !world.contains(id)) return;
  BodyDef def = *other;
  if (run.bytes.flag()) {
    def = world.definition(id);
    const std::uint32_t fields = run.bytes.below(64);
    if ((fields & 1) != 0) def.type = other->type;
    if ((fields & 2) != 0) def.sensor = !def.sensor;
    if ((fields & 4) != 0) def.continuous = !def.continuous;
    if ((fields & 8) != 0) def.locks = other->locks;
    if ((fields & 16) != 0) def.material = other->material;
    if ((fields & 32) != 0) def.mass = def.mass ? 2 * *def.mass : 1;
  }
  run.call("set_definition", [&](World& of, std::size_t) { of.set_definition(id, def); });
}

// Out of the world, into it again, or to sleep.
void switch_bodies(Run& run) {
  const BodyId id = run.body();
  const std::uint32_t choice = run.bytes.below(3);
  if (choice == 2) {
    run.call("sleep", [&](World& world, std::size_t) { world.sleep(id); });
  } else {
    run.call("set_enabled", [&](World& world, std::size_t) { world.set_enabled(id, choice == 1); });
  }
}

// Off all at once, and on again.
void switch_joints(Run& run) {
  for (const bool enabled : {false, true}) {
    for (const JointId id : run.worlds.first().joints()) {
      run.call("set_joint_enabled", [&](World& world, std::size_t) { world.set_joint_enabled(id, enabled); });
    }
    run.step("step", [](World& world) { return world.step(1.0 / 60); });
  }
}

// Definitions of bodies and joints that no world takes, each by one field.
void define_what_cannot_be(Run& run) {
  const BodyId first = run.bodies.front(), second = run.bodies.back();
  const JointServo slack{.target = 0, .stiffness = 0, .damping = 0};
  const JointAxis limp{.motor = JointMotor{.max_force = 1, .servo = slack}};
  const std::vector<BodyDef> bodies = {
      {.type = BodyType::Static, .shape = HalfSpace{.normal = {0, 0, 0}}},
      {.shape = HalfSpace{}},
      {.type = BodyType::Static, .shape = HalfSpace{}, .sensor = true},
      {.shape = Compound{}},
      {.shape = Box{{1, -1, 1}}},
      {.orientation = Quaternion(0, 0, 0, 0)},
      {.mass = 1, .inertia = Matrix3(Vector3(1, 1, 3).asDiagonal())},
      {.inertia = Matrix3(Matrix3::Identity())},
      {.type = BodyType::Static, .velocity = {1, 0, 0}},
      {.material = {.friction = -1}},
      {.name = "\xff"}};
  for (const BodyDef& def : bodies) {
    const std::string error = run.call("add_body", [&](World& world, std::size_t) { world.add_body(def); });
    require(!error.empty(), "a body is taken that cannot be");
  }
  const std::vector<JointKind> kinds = {BallJoint{.friction = -1},
                                        HingeJoint{limp},
                                        SliderJoint{{.range = {.lower = 1, .upper = 0}}},
                                        GearJoint{.ratio = 0},
                                        ConeTwistJoint{.swing_limit = 4},
                                        DistanceJoint{{.range = {.lower = -1, .upper = 1}}},
                                        HingeJoint{{.range = {.upper = -unlimited}}},
                                        HingeJoint{{.motor = JointMotor{.max_force = -1}}},
                                        HingeJoint{{.armature = -1}}};
  for (const JointKind& kind : kinds) {
    const JointDef def{.kind = kind, .first = first, .second = second};
    const std::string error = run.call("add_joint", [&](World& world, std::size_t) { world.add_joint(def); });
    require(!error.empty(), "a joint is taken that cannot be");
  }
  require_refused("a hull of no height", [] { cube().scaled({1, 1, 0}); });
}

namespace {

// Sends a body into quarantine: too fast, by its own velocity or by a push, or too far away.
std::string overdo(Run& run, BodyId id) {
  const std::uint32_t way = run.bytes.below(6);
  return run.call("overdo", [&](World& world, std::size_t) {
    switch (way) {
      case 0:
        return world.set_velocity(id, {2e6, 0, 0}, {0, 0, 0});
      case 1:
        return world.set_velocity(id, {0, 0, 0}, {0, 2e6, 0});
      case 2:
        return world.apply_force(id, {1e35, 0, 0});
      case 3:
        return world.apply_force(id, {0, 0, 0}, {0, 0, 1e35});
      case 4:
        return world.set_surface_velocity(id, {2e6, 0, 0});
      default:
        return world.set_pose(id, {{1e13, 0, 0}, Quaternion::Identity()});
    }
  });
}

}  // namespace

// A body, and what is joined to it: in the next step, and back.
void break_and_release(Run& run) {
  const World& world = run.worlds.first();
  const JointId joint = run.joint();
  const BodyId id = world.contains(joint) ? world.joint(joint).first : run.body();
  if (!overdo(run, id).empty()) return;
  const int before = run.result.steps;
  run.step("step", [](World& of) { return of.step(1.0 / 60); });
  const BodyDef def = world.definition(id);
  const bool is_free = def.type == BodyType::Dynamic && def.locks == MotionLocks{} && world.is_enabled(id) &&
                       run.definitions.has_normal_numbers();
  require(!is_free || run.result.steps == before || world.is_quarantined(id),
          "a body stays that no world goes on with");
  if (!world.is_quarantined(id) || run.bytes.one_in(4)) return;
  // It has no velocity, unless it was in quarantine before.
  const Pose pose{{0, 0, 3}, Quaternion::Identity()};
  run.call("set_pose", [&](World& of, std::size_t) { of.set_pose(id, pose); });
  run.call("set_surface_velocity", [&](World& of, std::size_t) { of.set_surface_velocity(id, {2e6, 0, 0}); });
  const std::string too_early = run.call("release", [&](World& of, std::size_t) { of.release(id); });
  require(!too_early.empty() && world.is_quarantined(id), "a body is released with too fast a surface");
  run.call("set_surface_velocity", [&](World& of, std::size_t) { of.set_surface_velocity(id, {0, 0, 0}); });
  run.call("set_velocity", [&](World& of, std::size_t) { of.set_velocity(id, {0, 0, 0}, {0, 0, 0}); });
  const std::string refused = run.call("release", [&](World& of, std::size_t) { of.release(id); });
  require(refused.empty() || !run.definitions.has_normal_numbers(),
          "a body that was put back is not released: " + refused);
  require(world.is_quarantined(id) != refused.empty(), "a body that is released is still in quarantine");
}

namespace {

// Tries a change that is forbidden while a step is under way.
void try_to_change(World& world, std::uint32_t what) {
  require_refused("a change within a step", [&] {
    switch (what % 8) {
      case 0:
        return world.set_gravity({0, 0, 1});
      case 1:
        return world.set_settings({});
      case 2:
        return static_cast<void>(world.add_body({}));
      case 3:
        return static_cast<void>(world.step(0.01));
      case 4: {
        Snapshot snapshot;
        return world.save(snapshot);
      }
      case 5:
        return world.record("never");
      case 6:
        return world.set_contact_filter({});
      default:
        if (world.body_count() == 0) return world.set_gravity(Vector3::Zero());
        return world.remove_body(world.bodies().front());
    }
  });
}

// Nor does another thread get to see what is half done.
void try_to_look(const World& world) {
  std::async(std::launch::async, [&world] {
    require_refused("a hash within a step", [&] { world.state_hash(); });
    require_refused("contact forces within a step", [&] { world.contact_forces(); });
    require_refused("a query within a step", [&] { Queries(world).is_blocked({}); });
  }).get();
}

}  // namespace

// Functions that are asked within a step try what they may not, and the step is as if they hadn't.
void overstep(Run& run) {
  const std::uint32_t what = run.bytes.byte();
  require_refused("an empty law", [&] { run.worlds.first().step(0.01, ForceLaw()); });
  run.step("overstep", [what](World& world) {
    return world.step(1.0 / 60, [&world, what](Forces& forces) {
      try_to_change(world, what);
      if (forces.time() == 0) try_to_look(world);
    });
  });
  if (run.bytes.flag()) return;
  // A world that was given to a function to look at.
  run.call("set_contact_filter", [&](World& world, std::size_t) {
    world.set_contact_filter([what](const ContactCandidate& of) {
      try_to_change(const_cast<World&>(of.world), what);
      return true;
    });
  });
  run.call("set_contact_modifier", [&](World& world, std::size_t) {
    world.set_contact_modifier(
        [what](ModifiableContact& contact) { try_to_change(const_cast<World&>(contact.world), what + 1); });
  });
  run.step("overstep", [](World& world) { return world.step(1.0 / 60); });
  run.call("set_contact_filter", [](World& world, std::size_t) { world.set_contact_filter({}); });
  run.call("set_contact_modifier", [](World& world, std::size_t) { world.set_contact_modifier({}); });
}

// And a step, in which islands start from what their bodies had, if they had something.
void change_target(Run& run) {
  const Settings settings = run.definitions.with_target(run.worlds.first().settings());
  run.call("set_settings", [&](World& world, std::size_t) {
    Settings its = settings;
    its.simd = world.settings().simd;
    world.set_settings(its);
  });
  run.step("step", [](World& world) { return world.step(1.0 / 60); });
}

// Changes some of a joint's definition, or nothing.
void redefine_joint(Run& run) {
  const JointId id = run.joint();
  if (!run.worlds.first().contains(id)) return;
  JointDef def = run.worlds.first().joint(id);
  const std::uint32_t what = run.bytes.byte();
  if (what & 1) def.frame_first.position += run.definitions.vector(0.3);
  if (what & 2) def.frame_second = {run.definitions.vector(1), run.definitions.orientation()};
  if (what & 4) def.collide = !def.collide;
  if (what & 8) def.break_force = run.bytes.flag() ? unlimited : run.definitions.number(1, 1e5);
  if (what & 16) def.kind = run.definitions.joint_kind();
  if (what & 32) def.first = run.body();
  if (what & 64) def.name = run.definitions.name();
  run.call("set_joint", [&](World& world, std::size_t) { world.set_joint(id, def); });
}

}  // namespace atl::fuzz
