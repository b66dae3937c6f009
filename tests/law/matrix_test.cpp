// Each feature of contacts and joints by each way of solving them: what moves, moves alike.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/min_turn.h"

namespace atl::test {
namespace {

// How a feature's run is solved.
enum class Way { Swept, Finer, Direct, Joined };

const char* name_of(Way way) {
  switch (way) {
    case Way::Swept:
      return "swept";
    case Way::Finer:
      return "finer";
    case Way::Direct:
      return "direct";
    case Way::Joined:
      break;
  }
  return "joined";
}

Settings settings_of(Way way, int substeps) {
  Settings settings{.substeps = way == Way::Finer ? 4 * substeps : substeps};
  settings.contact_solver = way == Way::Swept || way == Way::Finer ? ContactSolver::Iterative : ContactSolver::Direct;
  settings.joint_solver = way == Way::Swept || way == Way::Finer ? JointSolver::Iterative : JointSolver::Direct;
  return settings;
}

// Adds a body; where islands are to have joints, with a small rider that nothing touches, fixed at its centre.
BodyId add(World& world, const BodyDef& def, Way way) {
  const BodyId id = world.add_body(def);
  if (way != Way::Joined) return id;
  BodyDef rider = sphere(def.position, 0.2);
  rider.mass = 1e-4 * world.mass(id);
  rider.velocity = def.velocity;
  rider.angular_velocity = def.angular_velocity;
  rider.gravity_scale = def.gravity_scale;
  rider.linear_damping = def.linear_damping;
  rider.filter = {.category = 0, .mask = 0};
  world.add_joint({.kind = FixedJoint{}, .first = id, .second = world.add_body(rider)});
  return id;
}

double heading(const World& world, BodyId id) {
  const Vector3 ahead = world.pose(id).orientation * Vector3::UnitX();
  return std::atan2(ahead.y(), ahead.x());
}

// A box that slides, or what it slides on, in one way or another.
struct Sliding {
  BodyDef floor = static_box({0, 0, -0.5}, {20, 20, 0.5});
  BodyDef box{.shape = Box{{0.5, 0.5, 0.25}}, .position = {0, 0, 0.25}};
  Settings settings = {};
  double time = 1;            ///< s
  Vector3 force = {0, 0, 0};  ///< N, in each step
  bool direct = true;         ///< it can be solved at once
  bool height = false;        ///< compares that alone: sweeps let a box that is pushed up or down drift aside
};

struct Feature {
  std::string name;
  double scale;  ///< m or rad: what errors are relative to
  std::function<std::vector<double>(Way, int)> run;
};
void PrintTo(const Feature& feature, std::ostream* out) { *out << feature.name; }

std::vector<double> run_sliding(const Sliding& sliding, Way way, int substeps) {
  Settings settings = sliding.settings;
  const Settings solvers = settings_of(way, substeps);
  settings.substeps = solvers.substeps;
  settings.contact_solver = solvers.contact_solver;
  settings.joint_solver = solvers.joint_solver;
  World world({.settings = settings});
  world.add_body(sliding.floor);
  const BodyId id = add(world, sliding.box, way);
  std::int64_t direct = 0;
  const auto steps = std::lround(sliding.time / dt);
  for (int i = 0; i < steps; ++i) {
    world.apply_force(id, sliding.force);
    direct += world.step(dt).counts.direct_islands;
  }
  if (way == Way::Direct && sliding.direct) {
    EXPECT_GT(direct, 0.9 * static_cast<double>(steps)) << "it was swept";
  }
  const Vector3 at = world.pose(id).position;
  if (sliding.height) return {at.z()};
  return {at.x(), at.y(), at.z(), heading(world, id)};
}

Feature sliding(const std::string& name, double scale, const std::function<void(Sliding&)>& set) {
  return {name, scale, [set](Way way, int substeps) {
            Sliding sliding;
            set(sliding);
            return run_sliding(sliding, way, substeps);
          }};
}

std::vector<Feature> features() {
  std::vector<Feature> all;
  all.push_back(sliding("cone_friction", 0.5, [](Sliding& s) {
    s.box.velocity = {2, 1, 0};
    s.box.material.friction = s.floor.material.friction = 0.5;
  }));
  all.push_back(sliding("pyramid_friction", 0.5, [](Sliding& s) {
    s.settings.friction = FrictionModel::Pyramid;
    s.box.velocity = {2, 1, 0};
    s.box.material.friction = s.floor.material.friction = 0.5;
  }));
  for (const FrictionModel model : {FrictionModel::Cone, FrictionModel::Pyramid}) {
    const std::string name = model == FrictionModel::Cone ? "cone_by_direction" : "pyramid_by_direction";
    all.push_back(sliding(name, 0.5, [=](Sliding& s) {
      s.settings.friction = model;
      s.box.velocity = {2, 1, 0};
      s.box.material = {.friction = 0.1, .friction_across = 0.6, .friction_direction = {2, 1, 0}};
      s.floor.material.friction = 0.5;
    }));
  }
  all.push_back(sliding("no_friction", 2, [](Sliding& s) {
    s.box.velocity = {2, 1, 0};
    s.box.material.friction = 0;
  }));
  all.push_back(sliding("surface_velocity", 1, [](Sliding& s) { s.floor.surface_velocity = {1, 0.5, 0}; }));
  all.push_back(sliding("turning_surface", 1, [](Sliding& s) { s.floor.surface_angular_velocity = {0, 0, 1}; }));
  all.push_back(sliding("kinematic_floor", 1, [](Sliding& s) {
    s.floor.type = BodyType::Kinematic;
    s.floor.velocity = {1, 0.5, 0};
  }));
  all.push_back(sliding("turntable", 1, [](Sliding& s) {
    s.floor.type = BodyType::Kinematic;
    s.floor.angular_velocity = {0, 0, 1};
  }));
  all.push_back(sliding("torsional_friction", 1, [](Sliding& s) {
    s.box.angular_velocity = {0, 0, 3};
    s.box.material.friction = 0.1;
    s.box.material.torsional_friction = 0.1;
  }));
  all.push_back(sliding("force_that_is_held", 1, [](Sliding& s) { s.force = {2000, 0, 0}; }));
  all.push_back(sliding("force_that_moves", 1, [](Sliding& s) { s.force = {4000, 1000, 0}; }));
  all.push_back(sliding("damping", 1, [](Sliding& s) {
    s.box.velocity = {2, 0, 0};
    s.box.linear_damping = 0.5;
    s.box.material.friction = 0.05;
  }));
  all.push_back(sliding("gravity_scale", 0.5, [](Sliding& s) {
    s.box.velocity = {2, 0, 0};
    s.box.gravity_scale = 0.5;
  }));
  all.push_back(sliding("contact_hertz", 0.02, [](Sliding& s) {
    s.height = true;
    s.settings.contact_hertz = 3;
    s.time = 10;
  }));
  all.push_back(sliding("contact_damping_ratio", 0.02, [](Sliding& s) {
    s.height = true;
    s.settings.contact_hertz = 3;
    s.settings.contact_damping_ratio = 2;
    s.time = 10;
  }));
  // One point after another, sweeps push a box up more slowly than is asked for, and aside.
  all.push_back(sliding("contact_push_speed", 12, [](Sliding& s) {
    s.height = true;
    s.settings.contact_push_speed = 0.2;
    s.box.position.z() = 0.15;
    s.time = 0.25;
  }));
  all.push_back(sliding("landing", 0.5, [](Sliding& s) {
    s.box.position.z() = 0.5;
    s.direct = false;  // it falls first
  }));
  all.push_back(sliding("restitution", 1, [](Sliding& s) {
    s.direct = false;  // it bounces
    s.height = true;
    s.box.position.z() = 1.25;
    s.box.material.restitution = 0.5;
    s.time = 0.75;
  }));
  all.push_back({"rolling_friction", 1, [](Way way, int substeps) {
                   World world({.settings = settings_of(way, substeps)});
                   world.add_body(ground());
                   BodyDef def = sphere({0, 0, 0.5});
                   def.velocity = {2, 1, 0};
                   def.angular_velocity = {-2, 4, 0};
                   def.material.rolling_friction = 0.05;
                   const BodyId id = add(world, def, way);
                   run(world, 60);
                   const Vector3 at = world.pose(id).position;
                   return std::vector<double>{at.x(), at.y(), at.z()};
                 }});
  return all;
}

// Two boxes that lie on the ground and are joined.
struct Pair {
  JointKind kind = FixedJoint{};
  Vector3 axis = Vector3::UnitX();  // of the joint's frames
  double friction = 0;
  double mass = 1000;     // kg, of the first; the second has 2000
  double distance = 1.5;  // m
  Vector3 velocity = {0, 0, 0}, other_velocity = {0, 0, 0};
  Vector3 spin = {0, 0, 0};
  Vector3 force = {0, 0, 0};  // N, on the second, in each step
  double time = 1;            // s
};

// A joint's way: contacts swept and joints at once is what a few joints in a scene of sweeps get.
Settings settings_of_joints(Way way, int substeps) {
  Settings settings = settings_of(way == Way::Joined ? Way::Swept : way, substeps);
  settings.joint_solver = way == Way::Swept || way == Way::Finer ? JointSolver::Iterative : JointSolver::Direct;
  return settings;
}

std::vector<double> run_pair(const Pair& pair, Way way, int substeps) {
  World world({.settings = settings_of_joints(way, substeps)});
  world.add_body(static_box({0, 0, -0.5}, {20, 20, 0.5}));
  std::vector<BodyId> ids;
  for (const int i : {0, 1}) {
    BodyDef def{.shape = Box{{0.5, 0.5, 0.25}}, .position = {i * pair.distance, 0, 0.25}};
    def.mass = (1 + i) * pair.mass;
    def.material.friction = pair.friction;
    def.velocity = i == 0 ? pair.velocity : pair.other_velocity;
    if (i == 1) def.angular_velocity = pair.spin;
    ids.push_back(world.add_body(def));
  }
  const Quaternion frame = min_turn(Vector3::UnitX(), pair.axis);
  const bool apart = std::holds_alternative<DistanceJoint>(pair.kind);
  const Vector3 first = {apart ? 0 : pair.distance / 2, 0, 0}, second = {apart ? 0 : -pair.distance / 2, 0, 0};
  world.add_joint({.kind = pair.kind,
                   .first = ids[0],
                   .second = ids[1],
                   .frame_first = {first, frame},
                   .frame_second = {second, frame}});
  std::int64_t direct = 0;
  const auto steps = std::lround(pair.time / dt);
  for (int i = 0; i < steps; ++i) {
    world.apply_force(ids[1], pair.force);
    direct += world.step(dt).counts.direct_islands;
  }
  if (way == Way::Direct) {
    EXPECT_GT(direct, 0.9 * static_cast<double>(steps)) << "it was swept";
  }
  std::vector<double> result;
  for (const BodyId id : ids) {
    const Vector3 at = world.pose(id).position;
    result.insert(result.end(), {at.x(), at.y(), at.z(), heading(world, id)});
  }
  return result;
}

Feature pair(const std::string& name, const std::function<void(Pair&)>& set) {
  return {name, 1, [set](Way way, int substeps) {
            Pair pair;
            set(pair);
            return run_pair(pair, way, substeps);
          }};
}

std::vector<Feature> joint_features() {
  std::vector<Feature> all;
  const Vector3 up = Vector3::UnitZ();
  all.push_back(pair("fixed", [](Pair& p) {
    p.friction = 0.3;
    p.velocity = p.other_velocity = {2, 0.5, 0};
  }));
  all.push_back(pair("ball", [](Pair& p) { p.other_velocity = {0, 1, 0}; }));
  all.push_back(pair("ball_friction", [](Pair& p) {
    p.kind = BallJoint{.friction = 300};
    p.other_velocity = {0, 1, 0};
  }));
  all.push_back(pair("rod", [](Pair& p) {
    p.kind = DistanceJoint{.distance = {.range = {1.5, 1.5}}};
    p.other_velocity = {0, 1, 0};
  }));
  all.push_back(pair("rope", [](Pair& p) {
    p.kind = DistanceJoint{.distance = {.range = {0, 1.8}}};
    p.other_velocity = {1, 0.2, 0};
  }));
  all.push_back(pair("slider_spring", [](Pair& p) {
    p.kind = SliderJoint{.offset = {.spring = JointSpring{.hertz = 0.5, .damping_ratio = 0.5, .rest = 0.3}}};
  }));
  all.push_back(pair("slider_range", [](Pair& p) {
    p.kind = SliderJoint{.offset = {.range = {0, 0.4}}};
    p.other_velocity = {1, 0, 0};
  }));
  all.push_back(pair("slider_motor", [](Pair& p) {
    p.kind = SliderJoint{.offset = {.motor = JointMotor{.speed = 0.5, .max_force = 2000}}};
  }));
  all.push_back(pair("slider_brake", [](Pair& p) {
    p.kind = SliderJoint{.offset = {.motor = JointMotor{.speed = 0, .max_force = 500}}};
    p.other_velocity = {0.5, 0, 0};
  }));
  all.push_back(pair("hinge_range", [up](Pair& p) {
    p.kind = HingeJoint{.angle = {.range = {-0.2, 0.2}}};
    p.axis = up;
    p.other_velocity = {0, 0.75, 0};
  }));
  all.push_back(pair("hinge_motor", [up](Pair& p) {
    p.kind = HingeJoint{.angle = {.motor = JointMotor{.speed = 0.5, .max_force = 1000}}};
    p.axis = up;
  }));
  all.push_back(pair("hinge_spring", [up](Pair& p) {
    p.kind = HingeJoint{.angle = {.spring = JointSpring{.hertz = 0.5, .damping_ratio = 0.5, .rest = 0.4}}};
    p.axis = up;
  }));
  all.push_back(pair("force_on_a_joint", [](Pair& p) {
    p.friction = 0.3;
    p.force = {3000, 8000, 0};
  }));
  return all;
}

class LawTest : public testing::TestWithParam<Feature> {};

TEST_P(LawTest, IsTheSameHoweverItIsSolved) {
  const Feature& feature = GetParam();
  for (const auto& [substeps, allowed] : {std::pair{4, 0.02}, std::pair{16, 1e-3}}) {
    const std::vector<double> swept = feature.run(Way::Swept, substeps);
    for (const Way way : {Way::Finer, Way::Direct, Way::Joined}) {
      if (way == Way::Finer && substeps > 4) continue;  // as soft as these are, they take a minute to sink
      const std::vector<double> other = feature.run(way, substeps);
      // Bodies with joints move to first order in the substep where they touch something.
      const double error = way == Way::Joined ? allowed + 5e-3 * 4 / substeps : allowed;
      for (std::size_t i = 0; i < swept.size(); ++i) {
        EXPECT_NEAR(other[i], swept[i], error * feature.scale) << name_of(way) << " " << substeps << " [" << i << "]";
      }
    }
  }
}

class JointLawTest : public testing::TestWithParam<Feature> {};

TEST_P(JointLawTest, IsTheSameHoweverItIsSolved) {
  const Feature& feature = GetParam();
  for (const auto& [substeps, allowed] : {std::pair{4, 0.02}, std::pair{16, 1e-3}}) {
    const std::vector<double> direct = feature.run(Way::Direct, substeps);
    for (const Way way : {Way::Swept, Way::Finer, Way::Joined}) {
      const std::vector<double> other = feature.run(way, substeps);
      for (std::size_t i = 0; i < direct.size(); ++i) {
        EXPECT_NEAR(other[i], direct[i], allowed * feature.scale)
            << name_of(way) << " " << substeps << " [" << i << "]";
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Joints, JointLawTest, testing::ValuesIn(joint_features()),
                         [](const auto& feature) { return feature.param.name; });

INSTANTIATE_TEST_SUITE_P(Features, LawTest, testing::ValuesIn(features()),
                         [](const auto& feature) { return feature.param.name; });

}  // namespace
}  // namespace atl::test
