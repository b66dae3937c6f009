// Features beside plain bodies and joints, in all modes of the solvers: the same bits on any number of threads,
// continued after a save, restored into another world, and replayed.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/continued.h"
#include "support/long_tests.h"
#include "support/scene_run.h"
#include "support/temporary_file.h"

namespace atl::test::features_matrix_test {
namespace {

constexpr int steps = 36;

/// A feature: how bodies are made, what functions a world is given, and what is done to it ahead of a step.
struct Feature {
  const char* name;
  std::function<void(BodyDef&, int)> define = [](BodyDef&, int) {};
  std::function<void(World&)> equip = [](World&) {};
  std::function<void(World&, const std::vector<BodyId>&, int)> act = [](World&, const std::vector<BodyId>&, int) {};
  bool counts = true;  // whether what it does shows in the state's hash
};

Compound pieces(int i) {
  return {{{.shape = Box{{0.2, 0.3, 0.2}}, .position = {-0.2, 0, 0}, .material = Material{.friction = 0.1 * (i % 5)}},
           {.shape = Sphere{0.25},
            .position = {0.25, 0, 0},
            .material = Material{.restitution = 0.3, .rolling_friction = 0.01},
            .filter = CollisionFilter{.mask = i % 3 == 0 ? 3u : 1u}}}};
}

/// The one of these whose turn it is.
BodyId turn_of(const std::vector<BodyId>& bodies, int step) {
  return bodies[static_cast<std::size_t>(step) % bodies.size()];
}

// Filters, modifiers and sensors, which decide over contacts, and shapes and materials that change.
std::vector<Feature> contacts_and_shapes() {
  return {
      {.name = "filter",
       .equip =
           [](World& world) {
             world.set_contact_filter(
                 [](const ContactCandidate& of) { return (of.a.index + 2 * of.b.index) % 5 != 0; });
           },
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step % 7 == 3) world.refilter(turn_of(bodies, step));
           }},
      // One that says something else as time goes by, without a memory of its own.
      {.name = "moody_filter",
       .equip =
           [](World& world) {
             world.set_contact_filter([](const ContactCandidate& of) {
               return of.a.index == 0 || of.world.pose(of.b).position.z() > of.world.pose(of.a).position.z();
             });
           },
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step % 4 == 1) world.refilter(turn_of(bodies, step));
           }},
      {.name = "modifier",
       .equip =
           [](World& world) {
             world.set_contact_modifier([](ModifiableContact& contact) {
               const std::uint32_t kind = (contact.a.index + contact.b.index) % 6;
               if (kind == 0) contact.friction *= 0.25;
               if (kind == 1) contact.restitution = 0.5;
               if (kind == 2) contact.run_surface(contact.a, {0.5, 0.2, 0});
               if (kind == 3) contact.points.back().enabled = false;
               if (kind == 4) contact.enabled = contact.world.velocity(contact.b).z() < 0.1;
             });
           }},
      {.name = "both_functions",
       .equip =
           [](World& world) {
             world.set_contact_filter([](const ContactCandidate& of) { return (of.a.index + of.b.index) % 4 != 1; });
             world.set_contact_modifier([](ModifiableContact& contact) {
               contact.friction = 0.1 + 0.1 * (contact.b.index % 7);
               if (contact.normal.z() < 0.2 && contact.a.index != 0) contact.points.front().enabled = false;
             });
           },
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step == 10) world.remove_body(bodies[3]);
             if (step == 12) world.add_body({.shape = Sphere{0.3}, .position = {0, 0.1, 6}});
             if (step == 20) world.set_contact_filter({});
           }},
      {.name = "sensors",
       .define = [](BodyDef& def, int i) { def.sensor = i % 6 == 5; },
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             for (const SensorEvent& event : world.sensor_events()) {
               const Vector3 centre = world.centre_of_mass(event.body);
               if (step % 5 == 0 && event.entered) world.apply_impulse(event.body, {0, 0, 20}, centre);
             }
             if (step == 15) world.set_filter(bodies[5], {.mask = 2});
           }},
      {.name = "children", .define = [](BodyDef& def, int i) { def.shape = pieces(i); }},
      {.name = "set_shape",
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             const BodyId id = turn_of(bodies, step);
             if (step % 5 == 2) world.set_shape(id, Capsule{.radius = 0.2, .half_height = 0.2});
             if (step % 5 == 4) world.set_shape(id, pieces(step));
           }},
      {.name = "set_heights",
       .act =
           [](World& world, const std::vector<BodyId>&, int step) {
             if (step == 0) {
               world.add_body({.type = BodyType::Static,
                               .shape = HeightField(9, 9, 0.25, 0.25, std::vector(81, 0.1)),
                               .position = {-1, -1, 0},
                               .name = "hills"});
             }
             const double height = step % 6 == 1 ? std::nan("") : 0.05 * (step % 5);
             const auto column = static_cast<std::uint32_t>(step % 6);
             if (step % 3 == 1) world.set_heights(*world.find_body("hills"), column, 2, 2, std::vector(6, height));
           }},
      {.name = "set_material",
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             const BodyId id = turn_of(bodies, step);
             if (step % 4 == 1) world.set_material(id, {.friction = 0.05 * (step % 9), .restitution = 0.02 * step});
             if (step % 4 == 3) world.set_material(id, {.friction = 0.4, .torsional_friction = 0.02});
           }},
      {.name = "user_data_and_names",
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             const BodyId id = turn_of(bodies, step);
             world.set_user_data(id, world.user_data(id) + 1);
             world.set_name(id, "body " + std::to_string(step));
           },
       .counts = false},
  };
}

// Definitions of bodies that change after they were added, their sleep, and settings of the world.
std::vector<Feature> changed_bodies() {
  const auto redefine = [](World& world, BodyId id, const std::function<void(BodyDef&)>& change) {
    BodyDef def = world.definition(id);
    change(def);
    world.set_definition(id, def);
  };
  return {
      {.name = "types",
       .act =
           [redefine](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step % 4 != 1) return;
             redefine(world, turn_of(bodies, step), [step](BodyDef& def) {
               def.type = std::array{BodyType::Static, BodyType::Kinematic, BodyType::Dynamic}[step / 4 % 3u];
               if (def.type == BodyType::Static) def.velocity = def.angular_velocity = Vector3::Zero();
             });
             const BodyId other = turn_of(bodies, step - 4);
             if (step > 4) redefine(world, other, [](BodyDef& def) { def.type = BodyType::Dynamic; });
           }},
      {.name = "enabled",
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step % 3 == 1) world.set_enabled(turn_of(bodies, step), false);
             if (step % 6 == 5) world.set_enabled(turn_of(bodies, step - 4), true);
           }},
      {.name = "definitions",
       .act =
           [redefine](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step % 2 != 1) return;
             redefine(world, turn_of(bodies, step), [step](BodyDef& def) {
               const int kind = step / 2 % 6;
               if (kind == 0) def.sensor = true;
               if (kind == 1) def.continuous = true;
               if (kind == 2) def.locks = MotionLocks::plane(Axis::Y);
               if (kind == 3) def.shape = pieces(step);
               if (kind >= 4) def.mass = 50 + step;
               if (kind >= 4) def.inertia = Vector3(3, 4, 5).asDiagonal();
               if (kind == 5) def.centre_of_mass = Vector3(0.05, 0, -0.1);
               def.gravity_scale = 0.8;
             });
           }},
      {.name = "sleepers",
       .define =
           [](BodyDef& def, int i) {
             def.awake = i % 5 != 4;
             def.may_sleep = i % 7 != 6;
           },
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             const BodyId id = turn_of(bodies, step);
             if (step % 6 == 1 && world.definition(id).may_sleep) world.sleep(id);
             if (step % 6 == 4) world.wake(turn_of(bodies, step - 3));
             for (const SleepEvent& event : world.sleep_events()) {
               if (step % 5 == 0 && !event.asleep) world.apply_impulse(event.body, {0, 0, 9}, {0, 0, 1});
             }
           }},
      {.name = "caps_and_damping",
       .define =
           [](BodyDef& def, int i) {
             if (i % 2 == 0) def.max_speed = 0.5;
             if (i % 3 == 0) def.max_angular_speed = 1;
             if (i % 4 == 0) def.linear_damping = 2;
             if (i % 5 == 0) def.angular_damping = 3;
           }},
      {.name = "moved_and_pushed",
       .act =
           [redefine](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step == 0) redefine(world, bodies[0], [](BodyDef& def) { def.type = BodyType::Kinematic; });
             const Pose pose = world.pose(bodies[0]);
             if (step < 20) world.move_to(bodies[0], {pose.position + Vector3(0.02, 0, 0), pose.orientation}, dt);
             if (step == 20) world.set_velocity(bodies[0], Vector3::Zero(), {0, 0, 1});
             world.apply_force(turn_of(bodies, step), {100, 0, 0}, {0, 20, 0});
             if (step % 9 == 5) world.set_mass(turn_of(bodies, step), 20 + step);
           }},
      {.name = "around_the_bodies",
       .act =
           [](World& world, const std::vector<BodyId>&, int step) {
             if (step % 5 == 1) world.set_threads(1 + step % 3);
             if (step % 7 == 1) world.set_gravity({0.1 * step, 0, -9});
             Settings settings = world.settings();
             settings.substeps = 2 + step % 4;
             settings.friction = step % 2 == 0 ? FrictionModel::Cone : FrictionModel::Pyramid;
             if (step % 9 == 4) world.set_settings(settings);
           }},
      {.name = "solids",
       .define =
           [](BodyDef& def, int i) {
             const std::vector<Vector3> corners = {{0.3, 0, 0}, {-0.3, 0.1, 0}, {0, 0.3, 0.1}, {0, -0.1, 0.3}};
             const std::array<Shape, 6> shapes = {Ellipsoid{{0.3, 0.2, 0.25}}, TaperedCapsule{0.25, 0.15, 0.15},
                                                  Cylinder{0.25, 0.2},         Cone{0.3, 0.3},
                                                  Capsule{0.2, 0.2},           ConvexHull(corners)};
             def.shape = shapes[static_cast<std::size_t>(i) % shapes.size()];
           }},
  };
}

// Surfaces, and events and forces that a world tells of. These push bodies, so that they show in the state.
std::vector<Feature> surfaces_and_events() {
  return {
      {.name = "turning_surfaces",
       .define =
           [](BodyDef& def, int i) {
             def.surface_angular_velocity = {0, 0, 0.5 * (i % 4)};
             def.material.torsional_friction = 0.02;
           },
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step % 5 == 2) world.set_surface_velocity(turn_of(bodies, step), {1, 0, 0}, {0, 1, 0});
           }},
      {.name = "pairs_of_materials",
       .define =
           [](BodyDef& def, int i) {
             def.material = {.friction = 0.1 * (i % 8),
                             .friction_across = 0.05 * (i % 9),
                             .friction_direction = {i % 2 == 0 ? 1.0 : 0.0, 0, 0.2},
                             .friction_rule = static_cast<CombineRule>(i % 6),
                             .restitution_rule = static_cast<CombineRule>(5 - i % 6),
                             .id = static_cast<std::uint64_t>(i % 3)};
           },
       .act =
           [](World& world, const std::vector<BodyId>&, int step) {
             if (step % 9 == 1) world.set_material_pair({.first = 1, .second = 2, .friction = 0.01 * step});
             if (step % 9 == 6) world.set_material_pair({.first = 1, .second = 1, .restitution = 0.5});
           }},
      {.name = "hits",
       .define = [](BodyDef& def, int i) { def.contact_event_force = 50.0 * i; },
       .act =
           [](World& world, const std::vector<BodyId>&, int step) {
             if (step % 3 != 1) return;
             for (const ContactEvent& event : world.contact_events()) {
               const double push = event.impulse + event.approach_speed + event.child_b + (event.persists ? 1 : 0);
               if (event.b.index > 0) world.apply_impulse(event.b, 0.1 * push * event.normal, event.point);
             }
           }},
      {.name = "watchful_sensors",
       .define =
           [](BodyDef& def, int i) {
             def.sensor = i % 4 == 1;
             def.notices_static = def.sensor;
             def.notices_sensors = i % 8 == 1;
             def.continuous = i % 3 == 1;
             if (i % 2 == 1) def.shape = pieces(i);
           },
       .act =
           [](World& world, const std::vector<BodyId>&, int step) {
             if (step % 5 != 1) return;
             for (const SensorEvent& event : world.sensor_events()) {
               const double push = 1.0 + event.child_sensor + 2 * event.child_body + (event.entered ? 5 : 0);
               world.apply_impulse(event.sensor, {0, 0, push}, world.centre_of_mass(event.sensor));
             }
           }},
      {.name = "what_acts",
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step % 4 != 1) return;
             for (const BodyId id : bodies) {
               world.apply_force(id, -0.3 * world.contact_wrench(id).force + world.proper_acceleration(id),
                                 world.contact_wrench(id).torque);
             }
             for (const PairForce& pair : world.pair_forces()) world.apply_force(pair.b, 0.1 * pair.force);
             for (const JointId id : world.joints()) {
               world.apply_force(world.joint(id).second, 0.1 * world.joint_state(id).force);
             }
           }},
  };
}

// Joints that change, and kinds that drive bodies. The rope's joints come first.
std::vector<Feature> changed_joints() {
  const auto tie = [](World& world, const std::vector<BodyId>& bodies, const JointKind& kind, std::size_t first) {
    const Vector3 middle = 0.5 * (world.pose(bodies[first]).position + world.pose(bodies[first + 1]).position);
    return world.add_joint(joint_at(world, kind, bodies[first], bodies[first + 1], middle));
  };
  return {
      {.name = "set_joint",
       .act =
           [](World& world, const std::vector<BodyId>&, int step) {
             const std::vector<JointId> joints = world.joints();
             const JointId id = joints[static_cast<std::size_t>(step) % joints.size()];
             JointDef def = world.joint(id);
             const int kind = step % 6;
             if (kind == 0) def.collide = !def.collide;
             if (kind == 1) def.frame_second.position.x() += 0.05;
             if (kind == 2) def.break_force = 300;
             if (kind == 3) def.user_data = def.user_data + 1;
             if (kind == 4) def.kind = BallJoint{.friction = 5};
             if (kind < 5) world.set_joint(id, def);
             if (kind == 5) world.set_joint_enabled(id, step % 12 == 5);
           }},
      {.name = "drives",
       .act =
           [tie](World& world, const std::vector<BodyId>& bodies, int step) {
             const BallServo servo{.target = Quaternion(1, 0.3, 0, 0), .stiffness = 50, .damping = 5};
             if (step == 1) tie(world, bodies, BallJoint{.friction = 0.5, .servo = servo}, 10);
             SixDofJoint soft;
             for (JointAxis& axis : soft.offset) axis.spring = JointSpring{.hertz = 5};
             for (JointAxis& axis : soft.turn) axis.spring = JointSpring{.hertz = 5};
             if (step == 2) tie(world, bodies, soft, 12);
             if (step == 24) {
               for (const JointId id : world.joints()) world.set_user_data(id, 7);
             }
           }},
      {.name = "pulley",
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step != 1 && step != 22) return;
             if (step == 22) return world.remove_joint(world.joints().back());
             std::vector<TendonTerm> terms;
             for (const std::size_t i : {16u, 17u}) {
               const Pose pose = world.pose(bodies[i]);
               const BodyId wheel = world.add_body(static_box(pose.position + Vector3(0, 0, 2), {0.1, 0.1, 0.1}));
               const DistanceJoint rope{{.range = {0, unlimited}}};
               const JointId id = world.add_joint({.kind = rope, .first = wheel, .second = bodies[i]});
               terms.push_back({.joint = id});
             }
             world.add_joint({.kind = TendonJoint{.terms = terms, .length = {.range = {0, 4}}}});
           }},
  };
}

const std::vector<Feature>& features() {
  static const std::vector<Feature> all = [] {
    std::vector<Feature> joined;
    for (auto* part : {contacts_and_shapes, changed_bodies, surfaces_and_events, changed_joints}) {
      for (Feature& feature : part()) joined.push_back(std::move(feature));
    }
    return joined;
  }();
  return all;
}

MakeStep fill_with(World& world, const Feature& feature) {
  world.add_body(ground());
  std::vector<BodyId> bodies;
  for (int i = 0; i < 18; ++i) {
    const Vector3 position(0.45 * (i % 3) - 0.4, 0.4 * (i / 3 % 2), 0.5 + 0.55 * (i / 3));
    BodyDef def = i % 4 == 0 ? sphere(position, 0.3) : box(position, {0.3, 0.25, 0.25});
    feature.define(def, i);
    bodies.push_back(world.add_body(def));
  }
  // A rope that lies in the pile.
  for (std::size_t i = 6; i < 9; ++i) {
    world.add_joint(joint_at(world, BallJoint{}, bodies[i], bodies[i + 1],
                             0.5 * (world.pose(bodies[i]).position + world.pose(bodies[i + 1]).position)));
  }
  return [bodies, act = feature.act](World& of, int number) {
    act(of, bodies, number);
    of.step(dt);
  };
}

using Case = std::tuple<std::size_t, JointSolver, ContactSolver, bool>;

class FeatureIn : public testing::TestWithParam<Case> {
 protected:
  const Feature& feature = features()[std::get<0>(GetParam())];
  Settings settings = {.target = std::get<3>(GetParam()) ? all_targets() : ErrorTarget{},
                       .contact_solver = std::get<2>(GetParam()),
                       .joint_solver = std::get<1>(GetParam()),
                       .sleeping = true,
                       .contact_events = true,
                       .accelerations = true};
};

TEST_P(FeatureIn, HasTheSameBitsHoweverItIsContinued) {
  const auto fill = [&](World& world) { return fill_with(world, feature); };
  const auto trail = expect_same_bits({fill, settings, steps, feature.equip}, {{.threads = 2}});
  World plain({.settings = settings});
  fill_with(plain, {.name = "none"});
  bool differs = false;
  for (const std::uint64_t hash : trail) {
    plain.step(dt);
    differs |= plain.state_hash() != hash;
  }
  EXPECT_EQ(differs, feature.counts) << "whether it does anything";
}

// Bodies that are thrown into heaps, where continuous collision asks of what it meets, also on ways aside of what it
// touches.
TEST(ContactFilterInHeaps, IsAskedInOneOrderAndReplayed) {
  for (const char* name : {"pile:bodies=150", "ragdolls:count=4", "drum:boxes=60"}) {
    std::vector<std::pair<BodyId, BodyId>> asked[2];
    std::uint64_t hashes[2];
    for (const int threads : {1, 2}) {
      SceneRun run(load_scene(name), {.threads = threads});
      const auto number = static_cast<std::size_t>(threads - 1);
      run.world.set_contact_filter([&](const ContactCandidate& of) {
        asked[number].emplace_back(of.a, of.b);
        return of.a.index < 8 || (of.a.index + of.b.index) % 5 != 0;
      });
      const TemporaryFile file(".heap");
      run.world.record(file.path());
      std::int64_t swept = 0;
      for (int i = 0; i < 70; ++i) {
        for (const BodyId id : run.ids) {
          if (i % 20 != 10 || id.index % 3 != 0 || run.world.type(id) != BodyType::Dynamic) continue;
          run.world.set_velocity(id, {60.0 - id.index % 7 * 20, 40.0 - id.index % 5 * 20, -80}, Vector3::Zero());
        }
        swept += run.world.step(run.scene.dt).counts.swept;
      }
      EXPECT_GT(swept, 100) << name;
      run.world.stop_recording();
      hashes[number] = run.world.state_hash();
      const ReplayResult replayed = replay(file.path(), {.threads = 3 - threads});
      EXPECT_FALSE(replayed.divergence) << name;
      EXPECT_EQ(replayed.hash, hashes[number]) << name;
    }
    EXPECT_EQ(asked[0], asked[1]) << name;
    EXPECT_EQ(hashes[0], hashes[1]) << name;
  }
}

// All combinations in long tests, else three of each feature: each with each solver, and over all features each two
// solvers and targets together.
std::vector<Case> cases() {
  std::vector<Case> chosen;
  for (std::size_t feature = 0; feature < features().size(); ++feature) {
    for (std::size_t joints = 0; joints < 3; ++joints) {
      for (std::size_t contacts = 0; contacts < 3; ++contacts) {
        for (const std::size_t target : {0, 1}) {
          const bool is_its_turn = (joints + feature) % 3 == contacts && (joints + feature / 3) % 2 == target;
          if (!long_tests() && !is_its_turn) continue;
          chosen.emplace_back(feature, static_cast<JointSolver>(joints), static_cast<ContactSolver>(contacts),
                              target == 1);
        }
      }
    }
  }
  return chosen;
}

INSTANTIATE_TEST_SUITE_P(Modes, FeatureIn, testing::ValuesIn(cases()), [](const auto& test) {
  return std::string(features()[std::get<0>(test.param)].name) + "_" + std::to_string(test.index);
});

}  // namespace
}  // namespace atl::test::features_matrix_test
