// Joined bodies don't pass through anything either, and joints aren't torn by an impact.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/joined_run.h"
#include "support/thrown.h"

namespace atl::test {
namespace {

constexpr double full_turn = 2 * std::numbers::pi;

struct Flights {
  int through = 0;   // bodies and steps: behind the middle of the wall
  int put_back = 0;  // likewise

  void add(const Scene& scene, JointSolver solver, int steps) {
    JoinedRun run(scene, solver);
    for (int step = 0; step < steps; ++step) {
      const StepReport report = run.world.step(dt);
      EXPECT_EQ(report.quarantined, 0);
      put_back += static_cast<int>(report.counts.stopped);
      for (const BodyId id : run.ids) through += run.world.pose(id).position.x() > 0;
    }
  }
};

class JoinedTunnelling : public testing::TestWithParam<JointSolver> {};

TEST_P(JoinedTunnelling, PairsNeverPassAWall) {
  for (const JointKind& kind :
       {JointKind{DistanceJoint{{.range = {0.5, 0.5}}}}, JointKind{BallJoint{}}, JointKind{FixedJoint{}}}) {
    for (const double speed : {100.0, 500.0}) {
      Flights flights;
      for (int phase = 0; phase < 200; ++phase) {
        Scene scene = before_a_wall(0.1);
        throw_pair(scene, kind, {-2 - speed * dt * spread(phase, 0.414213562), 0, 0},
                   Quaternion(Eigen::AngleAxisd(full_turn * spread(phase), Vector3(0.3, 0.5, 1).normalized())),
                   {speed, 0.2 * speed * spread(phase, 0.732050808), 0});
        flights.add(scene, GetParam(), 20);
      }
      EXPECT_EQ(flights.through, 0) << kind.index() << ' ' << speed;
      EXPECT_GT(flights.put_back, 400);
    }
  }
}

TEST_P(JoinedTunnelling, ChainsNeverPassAThinWall) {
  for (const double speed : {30.0, 100.0}) {
    Flights flights;
    for (int phase = 0; phase < 60; ++phase) {
      Scene scene = before_a_wall(0.02);
      const double angle = full_turn * spread(phase);
      throw_chain(scene, {-3 - speed * dt * spread(phase, 0.414213562), 0, 0}, {std::cos(angle), std::sin(angle), 0},
                  10, {speed, 0, 0});
      flights.add(scene, GetParam(), 40);
    }
    EXPECT_EQ(flights.through, 0) << speed;
    EXPECT_GT(flights.put_back, 600);
  }
}

TEST_P(JoinedTunnelling, RagdollsNeverPassAThinWall) {
  for (const double speed : {20.0, 50.0, 100.0}) {
    Flights flights;
    for (int phase = 0; phase < 30; ++phase) {
      Scene scene = before_a_wall(0.04);
      throw_ragdoll(scene, static_cast<std::uint64_t>(phase + 1), {-2 - speed * dt * spread(phase), 0, 0},
                    {speed, 0, 0});
      flights.add(scene, GetParam(), 60);
    }
    EXPECT_EQ(flights.through, 0) << speed;
    EXPECT_GT(flights.put_back, 390);
  }
}

TEST_P(JoinedTunnelling, FlailsNeverPassAThinWall) {
  for (const double speed : {30.0, 60.0}) {
    Flights flights;
    for (int phase = 0; phase < 60; ++phase) {
      Scene scene = before_a_wall(0.02);
      swing_flail(scene, {-0.3, 0, 0}, -0.5 - 1.5 * spread(phase), speed);
      flights.add(scene, GetParam(), 60);
    }
    EXPECT_EQ(flights.through, 0) << speed;
    EXPECT_GT(flights.put_back, 60);
  }
}

// Two balls on a stick that turns: where it is put back to, the joint in its middle is open by what the way of the
// centres is off their circles, at most.
TEST_P(JoinedTunnelling, JointsOpenByTheSquareOfTheTurnWhereTheyAreStopped) {
  constexpr double arm = 0.25;
  for (const double turn : {0.05, 0.2, 0.5}) {
    int stops = 0;
    double gap = 0;
    for (int phase = 0; phase < 100; ++phase) {
      Scene scene = before_a_wall(0.1);
      throw_pair(scene, FixedJoint{}, {-2 - 100 * dt * spread(phase), 0, 0}, Quaternion::Identity(), Vector3::Zero());
      for (const std::size_t ball : {1, 2}) {
        BodyDef& def = scene.bodies[ball].def;
        def.angular_velocity = {0, 0, turn / dt};
        def.velocity = Vector3(100, 0, 0) + def.angular_velocity.cross(Vector3(ball == 1 ? -arm : arm, 0, 0));
      }
      JoinedRun run(scene, GetParam());
      bool stopped = false;
      for (int step = 0; step < 5 && !stopped; ++step) stopped = run.world.step(dt).counts.stopped > 0;
      const double speeds = run.world.velocity(run.ids[1]).x() + run.world.velocity(run.ids[2]).x();
      if (!stopped || std::abs(speeds - 200) > 0.1) continue;  // it has touched the wall
      ++stops;
      gap = std::max(gap, run.drift().max);
    }
    EXPECT_GT(stops, 50);
    EXPECT_LT(gap, 2 * arm * turn * turn / 8 + 1e-4) << turn;
    EXPECT_GT(gap, 0.5 * 2 * arm * turn * turn / 8) << turn;
  }
}

// A chain that slides fast touches the ground, and one tile after another, all the time; that must not slow it down.
TEST_P(JoinedTunnelling, ChainsSlideOverTilesAtTheirSpeed) {
  for (const double speed : {30.0, 60.0}) {
    Scene scene;
    for (int i = 0; i < 160; ++i) {
      BodyDef tile = static_box({-5 + 0.5 * i, 0, -0.5}, {0.25, 5, 0.5});
      tile.material.friction = 0;
      add(scene, tile);
    }
    throw_chain(scene, {0, 0, 0.03}, {1, 0, 0}, 10, {speed, 0, 0});
    JoinedRun run(scene, GetParam());
    const double from = run.world.pose(run.ids.back()).position.x();
    double way = 0;
    for (int step = 0; step < 60; ++step) {
      run.world.step(dt);
      way += dt * run.world.velocity(run.ids.back()).x();
    }
    EXPECT_NEAR(run.world.pose(run.ids.back()).position.x() - from, way, 0.01 * way);
  }
}

// A chain that lies on smooth ground, of which one end is kicked sideways, moves as it does without the ground.
TEST_P(JoinedTunnelling, AChainThatLiesAndWhipsIsNotHeld) {
  const auto tip_after = [&](bool on_ground, int steps) {
    Scene scene;
    scene.gravity.setZero();
    BodyDef smooth = ground(0);
    smooth.position.z() = on_ground ? 0 : -10;
    add(scene, smooth);
    throw_chain(scene, {0, 0, 0.0299}, {1, 0, 0}, 10, Vector3::Zero());
    scene.bodies.back().def.velocity = {0, 40, 0};
    JoinedRun run(scene, GetParam());
    for (int step = 0; step < steps; ++step) run.world.step(dt);
    return run.world.pose(run.ids.back()).position;
  };
  for (const int steps : {1, 3, 10}) {
    // Alone it keeps its energy, on the ground it loses some: by 5% of its way they differ.
    const double way = 40 * steps * dt;
    EXPECT_NEAR((tip_after(true, steps) - tip_after(false, steps)).norm(), 0, 0.05 * way) << steps;
    EXPECT_GT((tip_after(true, steps) - Vector3(1.9, 0, 0.03)).norm(), 0.05) << steps;
  }
}

// Balls on arms that fold up about their joint, which flies along: they meet, and the whole goes on.
TEST_P(JoinedTunnelling, BodiesOfAnAssemblyMeetAndDoNotHoldIt) {
  for (int phase = 0; phase < 50; ++phase) {
    Scene scene;
    scene.gravity.setZero();
    for (const double side : {-1.0, 1.0}) {
      BodyDef ball = sphere({side * (0.3 + 0.005 * phase), 0, 0}, 0.1);
      ball.velocity = {-80 * side, 30, 0};
      add(scene, ball);
    }
    join(scene, DistanceJoint{{.range = {0, 2}}}, 0, 1, Vector3::Zero());
    scene.joints.back().def.collide = true;
    scene.joints.back().def.frame_first = scene.joints.back().def.frame_second = {};
    JoinedRun run(scene, GetParam());
    for (int step = 0; step < 30; ++step) {
      run.world.step(dt);
      ASSERT_LT(run.world.pose(run.ids[0]).position.x(), run.world.pose(run.ids[1]).position.x()) << phase;
    }
    EXPECT_NEAR(run.world.velocity(run.ids[0]).y(), 30, 1e-3);
    EXPECT_GT(run.world.pose(run.ids[0]).position.y(), 0.8 * 30 * 30 * dt) << phase;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, JoinedTunnelling, testing::Values(JointSolver::Iterative, JointSolver::Direct),
                         [](const auto& solver) { return solver_name(solver.param); });

}  // namespace
}  // namespace atl::test
