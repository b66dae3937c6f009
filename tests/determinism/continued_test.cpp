// Worlds of all kinds of things, by all ways to solve them: the same bits on any threads and instruction set, restored
// and replayed.

#include "support/continued.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "support/bodies.h"
#include "support/scenes.h"
#include "support/tangle.h"
#include "support/thrown.h"

namespace atl::test::continued_test {
namespace {

void step(World& world, int) { world.step(dt); }

// Hands that fall on a table and on each other: fingers of two links on a palm, all closed by one motor over a tendon,
// each second link by a polynomial of the first.
struct Hands {
  World& world;
  std::vector<JointId> tendons;

  explicit Hands(World& filled) : world(filled) {
    world.add_body(ground());
    // Tendons get indices ahead of their joints': where these were.
    const BodyId a = world.add_body(box({20, 0, 0.5})), b = world.add_body(box({22, 0, 0.5}));
    std::vector<JointId> before;
    for (int i = 0; i < 9; ++i) before.push_back(world.add_joint({.kind = BallJoint{}, .first = a, .second = b}));
    std::vector<std::array<JointId, 6>> joints;
    for (int hand = 0; hand < 3; ++hand) joints.push_back(add_hand({0.1 * hand, 0, 0.5 + 0.8 * hand}));
    for (const JointId id : before) world.remove_joint(id);
    for (const auto& of : joints) couple(of);
  }

 private:
  std::array<JointId, 6> add_hand(const Vector3& at) {
    std::array<JointId, 6> joints;
    const BodyId palm = world.add_body(box(at, {0.2, 0.2, 0.05}));
    for (std::size_t finger = 0; finger < 3; ++finger) {
      const Quaternion turn(Eigen::AngleAxisd(2.1 * static_cast<double>(finger), Vector3::UnitZ()));
      BodyId base = palm;
      for (std::size_t link = 0; link < 2; ++link) {
        const double out = 0.2 + 0.3 * static_cast<double>(link);
        BodyDef def = box(at + turn * Vector3(out + 0.16, 0, 0), {0.13, 0.04, 0.03});
        def.orientation = turn;
        const BodyId next = world.add_body(def);
        joints[2 * finger + link] = world.add_joint(joint_at(world, HingeJoint{{.range = {-1.5, 1.5}}}, base, next,
                                                             at + turn * Vector3(out, 0, 0), turn * Vector3::UnitY()));
        base = next;
      }
    }
    return joints;
  }

  void couple(const std::array<JointId, 6>& joints) {
    TendonJoint closing{.length = {.motor = JointMotor{.speed = 1, .max_force = 3}, .friction = 0.1}};
    for (std::size_t finger = 0; finger < 3; ++finger) {
      closing.terms.push_back({.joint = joints[2 * finger], .polynomial = {0, 1.0 / 3}});
      tendons.push_back(
          world.add_joint({.kind = TendonJoint{.terms = {{.joint = joints[2 * finger + 1]},
                                                         {.joint = joints[2 * finger], .polynomial = {0, -0.7, 0.1}}},
                                               .length = {.range = {0, 0}}}}));
    }
    tendons.push_back(world.add_joint({.kind = closing}));
  }
};

MakeStep fill_with_hands(World& world) {
  const std::vector<JointId> tendons = Hands(world).tendons;
  return [tendons](World& of, int i) {
    if (i == 20) of.set_motor_speed(tendons.back(), -1);
    if (i == 40) of.remove_joint(tendons.front());
    of.step(dt);
  };
}

MakeStep fill_with_tangle(World& world) {
  Tangle tangle(world);
  return step;
}

// Balls, boxes and a hung ball in a bowl, which stands or moves.
Scene bowl(const std::string& type) {
  std::ostringstream text;
  text << R"({"format": "atoll-scene", "version": 1, "dt": 0.01, "steps": 60, "bodies": [)"
       << R"({"name": "bowl", "type": ")" << type << R"(", "position": [-2, -2, 0],)"
       << (type == "kinematic" ? R"("velocity": [50, 0, 0],)" : "")
       << R"("shape": {"type": "height_field", "smooth": true,)"
       << R"("spacing": [0.5, 0.5], "heights": [)";
  for (int j = 0; j <= 8; ++j) {
    text << (j > 0 ? ", [" : "[");
    for (int i = 0; i <= 8; ++i) text << (i > 0 ? ", " : "") << 0.05 * ((i - 4) * (i - 4) + (j - 4) * (j - 4));
    text << "]";
  }
  text << "]}}";
  for (int i = 0; i < 8; ++i) {
    text << R"(, {"name": "ball)" << i << R"(", "position": [)" << 0.4 * (i % 3) - 0.3 << ", " << 0.4 * (i / 3) - 0.4
         << R"(, 0.9], "velocity": [)" << (type == "kinematic" ? 50 : 0) + i % 2
         << R"(, 1, 0], "shape": {"type": "sphere", "radius": 0.15}, "material": {"friction": )" << 0.2 * (i % 3)
         << R"(, "restitution": )" << 0.3 * (i % 2) << "}}";
  }
  text << R"(], "joints": [{"kind": "distance", "first": "ball0", "second": "ball1", "at": [-0.3, -0.4, 0.9],)"
       << R"("at_second": [0.1, -0.4, 0.9]}]})";
  return parse_scene(text.str(), "bowl.json");
}

// Both kinds fall on each other and on boxes, between a plane and a field of heights.
Scene heap() {
  std::ostringstream text;
  text << R"({"format": "atoll-scene", "version": 1, "dt": 0.01, "steps": 80, "bodies": [)"
       << R"({"type": "static", "shape": {"type": "half_space", "offset": -0.2}},)"
       << R"({"type": "static", "position": [-1, -1, 0], "shape": {"type": "height_field", "spacing": [1, 1],)"
       << R"("heights": [[0.4, 0.1, 0.4], [0.1, 0, 0.1], [0.4, 0.1, 0.4]]}})";
  for (int i = 0; i < 24; ++i) {
    text << R"(, {"position": [)" << 0.4 * (i % 3) - 0.4 << ", " << 0.4 * (i / 3 % 2) - 0.2 << ", "
         << 0.6 + 0.35 * (i / 6) << R"(], "orientation": [0.1, )" << 0.2 * (i % 4) << R"(, 0.3, 1], "shape": )";
    if (i % 3 == 0) text << R"({"type": "ellipsoid", "half_axes": [0.2, 0.15, 0.1]}})";
    if (i % 3 == 1) text << R"({"type": "tapered_capsule", "radii": [0.15, 0.1], "half_height": 0.1}})";
    if (i % 3 == 2) text << R"({"type": "box", "half_extents": [0.15, 0.1, 0.1]}})";
  }
  text << "]}";
  return parse_scene(text.str(), "heap.json");
}

// Assemblies that are put back to where they met a wall, each other or themselves, in most of the steps.
Scene flight() {
  Scene scene = before_a_wall(0.02);
  for (int i = 0; i < 6; ++i) {
    const double y = 1.5 * i;
    throw_pair(scene, i % 2 == 0 ? JointKind{BallJoint{}} : JointKind{FixedJoint{}}, {-9.0 + i, y, 0},
               Quaternion::Identity(), {90, 0, 3});
    throw_chain(scene, {-12, y, 1}, Vector3(1, 0.3 * i, 1).normalized(), 10, {60.0 + 3 * i, 0, 0});
    throw_ragdoll(scene, static_cast<std::uint64_t>(i + 1), {-5, 2.5 * i, -4}, {40, 0, 0});
    swing_flail(scene, {-0.5, y, 6}, -1.5, 40);
  }
  return scene;
}

// On a slope, rough along one direction and smooth across it.
MakeStep fill_with_sledges(World& world) {
  world.set_gravity({1.9, 0.6, -9.6});
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .material = {.friction_rule = CombineRule::Min}});
  for (int i = 0; i < 40; ++i) {
    BodyDef def = box({1.1 * (i % 8), 0.7 * (i / 8), 0.1}, {0.5, 0.3, 0.1});
    def.material = {.friction = 0.1, .friction_across = 0.5, .friction_direction = {std::cos(i), std::sin(i), 0}};
    def.velocity = {0, 0, 0.1 * (i % 3)};
    world.add_body(def);
  }
  return step;
}

// Three hinges one after another, with servos and dry friction.
MakeStep fill_with_arm(World& world) {
  BodyId below = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
  const JointServo servo{.target = 0.3, .stiffness = 40, .damping = 4};
  for (int i = 0; i < 3; ++i) {
    const BodyId link = world.add_body(box({0.2 + 0.4 * i, 0, 0}, {0.2, 0.05, 0.05}));
    const HingeJoint hinge{{.motor = JointMotor{.max_force = 20, .servo = servo}, .friction = 1}};
    world.add_joint(joint_at(world, hinge, below, link, {0.4 * i, 0, 0}, Vector3::UnitY()));
    below = link;
  }
  return step;
}

// Crates that slide onto cells of glass, and balls that bounce where these do.
MakeStep fill_with_ice(World& world) {
  std::vector<std::uint8_t> cells;
  for (int i = 0; i < 40 * 8; ++i) cells.push_back(i % 40 >= 20 ? 1 : 0);
  world.add_body({.type = BodyType::Static,
                  .shape = HeightField(41, 9, 0.5, 0.5, std::vector(41 * 9, 0.0), false, cells),
                  .position = {-10, -2, 0},
                  .material = {.friction = 0.5, .friction_rule = CombineRule::Min},
                  .materials = {{.friction = 0, .restitution = 0.5, .friction_rule = CombineRule::Min}}});
  for (int i = 0; i < 6; ++i) {
    BodyDef def = box({1.2 * i - 3, 0.3 * i - 1, 0.25 + 0.05 * i}, Vector3::Constant(0.25));
    def.velocity = {4.0 - 2 * i, 0, 0};
    def.material.friction = 5;
    world.add_body(def);
    world.add_body(sphere({0.5 * i - 1, 1.2, 1}, 0.2));
  }
  return step;
}

// Boxes that fall through a sensor onto stones below. Its events push them, so that the hash shows them.
MakeStep fill_with_gate(World& world) {
  world.add_body({.type = BodyType::Static, .shape = Box{{1, 1, 0.25}}, .position = {0, 0, 1}, .sensor = true});
  for (int i = 0; i < 40; ++i) {
    world.add_body(box({0.3 * (i % 3) - 0.3, 0, 1.5 + 0.25 * i}, {0.1, 0.1, 0.1}));
    world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}, .position = {0.3 * (i % 7) - 1, 0, -0.5}});
  }
  return [](World& of, int) {
    of.step(dt);
    for (const SensorEvent& event : of.sensor_events()) {
      of.apply_force(event.body, {event.entered ? 1.0 : -1.0, 0.1 * event.body.index, 0});
    }
  };
}

struct Filled {
  const char* name;
  std::function<MakeStep(World&)> fill;
};

const std::vector<Filled>& worlds() {
  static const std::vector<Filled> all = {
      {"hands", fill_with_hands},
      {"tangle", fill_with_tangle},
      {"bowl", [](World& world) { return fill_scene(world, bowl("static")); }},
      {"moving_bowl", [](World& world) { return fill_scene(world, bowl("kinematic")); }},
      {"heap", [](World& world) { return fill_scene(world, heap()); }},
      {"flight", [](World& world) { return fill_scene(world, flight()); }},
      {"sledges", fill_with_sledges},
      {"arm", fill_with_arm},
      {"ice", fill_with_ice},
      {"gate", fill_with_gate},
  };
  return all;
}

class ContinuedWorld : public testing::TestWithParam<std::tuple<std::size_t, int>> {};

TEST_P(ContinuedWorld, HasTheSameBits) {
  const auto [number, solver] = GetParam();
  expect_same_bits({.fill = worlds()[number].fill,
                    .settings = {.contact_solver = static_cast<ContactSolver>(solver),
                                 .joint_solver = static_cast<JointSolver>(solver),
                                 .sleeping = true,
                                 .contact_events = true}});
}

std::string name_of_case(const testing::TestParamInfo<std::tuple<std::size_t, int>>& of) {
  const char* solvers[] = {"Auto", "Iterative", "Direct"};
  return std::string(worlds()[std::get<0>(of.param)].name) + "_" + solvers[std::get<1>(of.param)];
}

INSTANTIATE_TEST_SUITE_P(All, ContinuedWorld,
                         testing::Combine(testing::Range(std::size_t{0}, worlds().size()), testing::Range(0, 3)),
                         name_of_case);

class ContinuedScene : public testing::TestWithParam<std::string> {};

TEST_P(ContinuedScene, HasTheSameBits) {
  const Scene scene = load_scene(GetParam());
  Settings settings = scene.settings;
  settings.sleeping = true;
  settings.time_to_sleep = 0.1;
  settings.contact_events = true;
  expect_same_bits({.fill = [&](World& world) { return fill_scene(world, scene); }, .settings = settings, .steps = 24});
}

INSTANTIATE_TEST_SUITE_P(Small, ContinuedScene, testing::ValuesIn(small_scenes()),
                         [](const auto& test) { return case_name(test.param); });

// Else the flight shows nothing.
TEST(ContinuedRuns, AssembliesAreStoppedInFlight) {
  World world;
  fill_scene(world, flight());
  std::int64_t stopped = 0;
  for (int i = 0; i < 40; ++i) stopped += world.step(dt).counts.stopped;
  EXPECT_GT(stopped, 200);
}

// An island that all workers sweep together: they share joints and contacts out, and one takes the tendon.
TEST(ContinuedRuns, ATendonOfALargeIslandDoesNotDependOnThreads) {
  const auto hash_with = [](int threads) {
    World world({.threads = threads, .settings = {.joint_solver = JointSolver::Iterative}});
    BodyId before = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
    std::vector<JointId> hinges;
    for (int i = 0; i < 2100; ++i) {
      const BodyId next = world.add_body(box({1.0 + i, 0, 0}, {0.4, 0.4, 0.4}));
      hinges.push_back(world.add_joint(joint_at(world, HingeJoint{}, before, next, {0.5 + i, 0, 0}, Vector3::UnitY())));
      before = next;
    }
    const JointId tendon = world.add_joint(
        {.kind = TendonJoint{.terms = {{.joint = hinges[3]}, {.joint = hinges[40], .polynomial = {0, -2}}},
                             .length = {.range = {0, 0}}}});
    run(world, 5);
    EXPECT_NE(world.joint_state(tendon).force.x(), 0);
    return world.state_hash();
  };
  EXPECT_EQ(hash_with(1), hash_with(2));
}

}  // namespace
}  // namespace atl::test::continued_test
