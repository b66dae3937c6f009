// What joints connect doesn't pass through anything either, and is not torn where it meets it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <tuple>
#include <vector>

#include "support/joined_run.h"

namespace atl::test {
namespace {

constexpr double wall_thickness = 0.1;  // m
constexpr double far = 500;             // m, where the wall ends

// Numbers in [0, 1) that fill it evenly.
double spread(int i, double ratio = 0.618033988749895) { return std::fmod(ratio * i, 1.0); }

Scene behind_a_wall(double thickness = wall_thickness) {
  Scene scene;
  scene.gravity.setZero();
  scene.bodies.push_back({.name = "wall", .def = static_box({0, 0, 0}, {thickness / 2, far, far})});
  return scene;
}

Pose seen_from(const BodyDef& body, const Vector3& point) {
  return {body.orientation.conjugate() * (point - body.position), body.orientation.conjugate()};
}

// Joins the last body but `back` to the last, at a point of the world.
void join_last(Scene& scene, const JointKind& kind, const Vector3& point, std::size_t back = 1) {
  SceneJoint joint{.name = "joint_" + std::to_string(scene.joints.size()),
                   .first = scene.bodies.size() - 1 - back,
                   .second = scene.bodies.size() - 1};
  joint.def.kind = kind;
  joint.def.frame_first = seen_from(scene.bodies[joint.first].def, point);
  joint.def.frame_second = seen_from(scene.bodies[joint.second].def, point);
  scene.joints.push_back(joint);
}

void add(Scene& scene, const BodyDef& def) {
  scene.bodies.push_back({.name = "body_" + std::to_string(scene.bodies.size()), .def = def});
}

struct Flight {
  int through = 0;    // bodies and steps
  int put_back = 0;   // likewise
  double gap = 0;     // m, that joints opened by, in steps in which bodies were put back
  double gap_else = 0;
};

// Counts what gets behind the wall.
Flight fly(const Scene& scene, JointSolver solver, int steps) {
  JoinedRun run(scene, solver);
  Flight flight;
  for (int step = 0; step < steps; ++step) {
    const StepReport report = run.world.step(dt);
    EXPECT_EQ(report.quarantined, 0);
    flight.put_back += static_cast<int>(report.counts.stopped);
    const double gap = run.drift().max;
    double& most = report.counts.stopped > 0 ? flight.gap : flight.gap_else;
    most = std::max(most, gap);
    for (const BodyId id : run.ids) flight.through += run.world.pose(id).position.x() > 0;
  }
  return flight;
}

void report(const std::string& name, const Flight& f) {
  if (std::getenv("SHOW")) std::printf("%s: through %d put back %d gap %g else %g\n", name.c_str(), f.through, f.put_back, f.gap, f.gap_else);
}

enum class Kind { Distance, Ball, Fixed };

class JoinedTunnelling : public testing::TestWithParam<JointSolver> {};

// Two balls at half a metre, thrown at the wall at any angle and phase of the step.
TEST_P(JoinedTunnelling, PairsNeverPassAWall) {
  for (const Kind kind : {Kind::Distance, Kind::Ball, Kind::Fixed}) {
    for (const double speed : {100.0, 500.0}) {
      Flight worst;
      for (int phase = 0; phase < 200; ++phase) {
        Scene scene = behind_a_wall();
        const Quaternion turn(Eigen::AngleAxisd(6.283185 * spread(phase), Vector3(0.3, 0.5, 1).normalized()));
        const Vector3 middle(-2 - speed * dt * spread(phase, 0.414213562), 0, 0);
        for (const double side : {-0.25, 0.25}) {
          BodyDef ball = sphere(middle + turn * Vector3(side, 0, 0), 0.1);
          ball.velocity = {speed, 0.2 * speed * spread(phase, 0.732), 0};
          add(scene, ball);
        }
        if (kind == Kind::Distance) {
          join_last(scene, DistanceJoint{{.range = {0.5, 0.5}}}, middle);
          for (Pose* frame : {&scene.joints[0].def.frame_first, &scene.joints[0].def.frame_second}) *frame = {};
        } else if (kind == Kind::Ball) {
          join_last(scene, BallJoint{}, middle);
        } else {
          join_last(scene, FixedJoint{}, middle);
        }
        const Flight flight = fly(scene, GetParam(), 20);
        worst.through += flight.through;
        worst.put_back += flight.put_back;
        worst.gap = std::max(worst.gap, flight.gap);
        worst.gap_else = std::max(worst.gap_else, flight.gap_else);
      }
      report("pair kind " + std::to_string(static_cast<int>(kind)) + " speed " + std::to_string(speed), worst);
      EXPECT_EQ(worst.through, 0) << static_cast<int>(kind) << ' ' << speed;
      EXPECT_GT(worst.put_back, 200);
    }
  }
}

// Links of 0.2 m from a point on, each towards `along`.
void add_chain(Scene& scene, const Vector3& from, const Vector3& along, int links, const Vector3& velocity) {
  const Quaternion turn = Quaternion::FromTwoVectors(Vector3::UnitZ(), along);
  for (int i = 0; i < links; ++i) {
    BodyDef link{.shape = Capsule{.radius = 0.03, .half_height = 0.07},
                 .position = from + (0.2 * i + 0.1) * along,
                 .orientation = turn,
                 .velocity = velocity};
    add(scene, link);
    if (i > 0) join_last(scene, BallJoint{}, from + 0.2 * i * along);
  }
}

TEST_P(JoinedTunnelling, ChainsNeverPassAThinWall) {
  for (const double speed : {30.0, 100.0}) {
    Flight worst;
    for (int phase = 0; phase < 60; ++phase) {
      Scene scene = behind_a_wall(0.02);
      const double angle = 6.283185 * spread(phase);
      const Vector3 along(std::cos(angle), std::sin(angle), 0);
      add_chain(scene, Vector3(-3 - speed * dt * spread(phase, 0.4142), 0, 0), along, 10, {speed, 0, 0});
      const Flight flight = fly(scene, GetParam(), 40);
      worst.through += flight.through;
      worst.put_back += flight.put_back;
      worst.gap = std::max(worst.gap, flight.gap);
      worst.gap_else = std::max(worst.gap_else, flight.gap_else);
    }
    report("chain speed " + std::to_string(speed), worst);
    EXPECT_EQ(worst.through, 0) << speed;
    EXPECT_GT(worst.put_back, 60);
  }
}

TEST_P(JoinedTunnelling, RagdollsNeverPassAThinWall) {
  for (const double speed : {20.0, 50.0, 100.0}) {
    Flight worst;
    for (int phase = 0; phase < 30; ++phase) {
      Scene doll = load_scene("ragdolls:count=1", static_cast<std::uint64_t>(phase + 1));
      const std::size_t fixed = doll.bodies.size() - 13;
      Scene scene = behind_a_wall(0.04);
      Vector3 middle = doll.bodies[fixed].def.position;
      for (std::size_t i = fixed; i < doll.bodies.size(); ++i) {
        SceneBody body = doll.bodies[i];
        body.def.position += Vector3(-2 - speed * dt * spread(phase), 0, 0) - middle;
        body.def.velocity = {speed, 0, 0};
        scene.bodies.push_back(body);
      }
      for (SceneJoint joint : doll.joints) {
        joint.first -= fixed - 1;
        joint.second -= fixed - 1;
        scene.joints.push_back(joint);
      }
      const Flight flight = fly(scene, GetParam(), 60);
      worst.through += flight.through;
      worst.put_back += flight.put_back;
      worst.gap = std::max(worst.gap, flight.gap);
      worst.gap_else = std::max(worst.gap_else, flight.gap_else);
    }
    report("ragdoll speed " + std::to_string(speed), worst);
    EXPECT_EQ(worst.through, 0) << speed;
    EXPECT_GT(worst.put_back, 30);
  }
}

// A heavy ball on a chain of 2 m from a hook that swings at a thin wall.
TEST_P(JoinedTunnelling, FlailsNeverPassAThinWall) {
  for (const double speed : {30.0, 60.0}) {
    Flight worst;
    for (int phase = 0; phase < 60; ++phase) {
      Scene scene = behind_a_wall(0.02);
      const double angle = -0.5 - 1.5 * spread(phase);
      const Vector3 hook(-0.3, 0, 0), along(std::sin(angle), 0, -std::cos(angle));
      add(scene, {.type = BodyType::Static, .shape = Sphere{0.02}, .position = hook});
      add_chain(scene, hook, along, 10, {});
      SceneJoint first{.name = "hook", .first = 1, .second = 2};
      first.def.frame_second.position = {0, 0, -0.1};
      scene.joints.push_back(first);
      BodyDef tip = sphere(hook + 2.1 * along, 0.1);
      tip.density = 7800;
      add(scene, tip);
      join_last(scene, BallJoint{}, hook + 2 * along);
      const Vector3 across(-along.z(), 0, along.x());
      for (std::size_t i = 2; i < scene.bodies.size(); ++i) {
        BodyDef& def = scene.bodies[i].def;
        def.velocity = speed / 2.1 * (def.position - hook).norm() * across;
        def.angular_velocity = {0, -speed / 2.1, 0};
      }
      const Flight flight = fly(scene, GetParam(), 60);
      worst.through += flight.through;
      worst.put_back += flight.put_back;
      worst.gap = std::max(worst.gap, flight.gap);
      worst.gap_else = std::max(worst.gap_else, flight.gap_else);
    }
    report("flail speed " + std::to_string(speed), worst);
    EXPECT_EQ(worst.through, 0) << speed;
    EXPECT_GT(worst.put_back, 60);
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, JoinedTunnelling, testing::Values(JointSolver::Iterative, JointSolver::Direct),
                         [](const auto& solver) { return solver_name(solver.param); });

}  // namespace
}  // namespace atl::test
