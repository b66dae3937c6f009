// When overloaded contacts get their island another solver, and for how long.

#include <gtest/gtest.h>
#include <solver/select/solver_selection.h>

#include <vector>

namespace atl::solver {
namespace {

// Islands of boxes on a floor, body 0, each touching the floor and the one before: contacts are as many as bodies.
struct Piles {
  BodyTable bodies;
  Islands islands;
  std::vector<TouchingPair> pairs;
  std::vector<std::uint8_t> awake;
  std::vector<collision::ContactManifold> manifolds;
  SolverSelection selection;
  SolverSettings settings;

  explicit Piles(const std::vector<int>& heights, const std::vector<JointLink>& links = {}) {
    std::uint32_t count = 1;
    for (const int height : heights) count += static_cast<std::uint32_t>(height);
    bodies.resize(count);
    awake.assign(count, 1);
    awake[0] = 0;
    std::vector<std::uint32_t> candidates;
    std::uint32_t body = 1;
    for (const int height : heights) {
      for (int i = 0; i < height; ++i, ++body) {
        bodies.mobility[body] = Mobility::Dynamic;
        bodies.inverse_mass[body] = 1;
        bodies.position(body) = Vector3(3.0 * body, 0, 0.5 + i);
        candidates.push_back(body);
        pairs.push_back({i == 0 ? 0 : body - 1, body, static_cast<std::uint32_t>(pairs.size())});
        collision::ContactManifold manifold = {};
        manifold.normal[2] = 1;
        manifold.anchor_first[2] = 0.5f;
        manifold.anchor_second[2] = -0.5f;
        manifolds.push_back(manifold);
      }
    }
    islands.build(candidates, awake, pairs, links);
    selection.resize(count);
  }
  std::vector<SolveMode> choose() {
    const auto modes = selection.choose({islands, bodies, manifolds.data(), {0, 0, -9.81}, 1.0 / 60, settings});
    return {modes.begin(), modes.end()};
  }
  void note(std::vector<OverloadedBody> overloaded, std::vector<std::uint32_t> failed = {}, double dt = 1.0 / 60) {
    selection.note(overloaded, failed, awake, dt);
  }
};

const std::vector<SolveMode> none = {};

TEST(SolverSelection, CostsNothingWhereNothingIsOverloaded) {
  Piles piles({5, 5});
  EXPECT_EQ(piles.choose(), none);
  piles.note({});
  EXPECT_TRUE(piles.selection.loaded().empty());
}

TEST(SolverSelection, ALoadHasToLastAndAnImpactDoesNot) {
  Piles piles({4, 4});
  for (int step = 0; step < 2; ++step) {
    piles.note({{6, false}});
    EXPECT_EQ(piles.choose(), none) << step;
  }
  piles.note({{6, false}, {6, false}});
  EXPECT_EQ(piles.choose(), (std::vector<SolveMode>{SolveMode::Sweep, SolveMode::Direct}));
  // It wears off as it came.
  piles.note({});
  EXPECT_EQ(piles.choose(), none);
  for (int step = 0; step < 2; ++step) piles.note({});
  EXPECT_TRUE(piles.selection.loaded().empty());
}

// It is the time that counts, not the steps: a load lasts after 0.04 s, and what is done about it for half a second.
TEST(SolverSelection, LoadsLastAsLongInShortSteps) {
  for (const int rate : {60, 240, 1000}) {
    Piles piles({4});
    int steps = 0;
    for (; piles.choose().empty(); ++steps) piles.note({{2, false}}, {}, 1.0 / rate);
    EXPECT_NEAR(static_cast<double>(steps) / rate, 0.04, 1.5 / rate) << rate;
    for (int i = 0; i < rate; ++i) piles.note({{2, false}}, {}, 1.0 / rate);
    for (steps = 0; !piles.choose().empty(); ++steps) piles.note({}, {}, 1.0 / rate);
    EXPECT_NEAR(static_cast<double>(steps) / rate, 0.5 - 0.04, 2.0 / rate) << rate;
  }
}

// Substeps make contacts stiffer, but sweeps don't settle a column any sooner.
TEST(SolverSelection, ColumnsNeedTheSameWithManySubsteps) {
  Piles piles({4, 20});
  piles.settings.substeps = 32;
  for (std::uint32_t body = 1; body < 25; ++body) piles.selection.arrive(body);
  EXPECT_EQ(piles.choose(), (std::vector<SolveMode>{SolveMode::Sweep, SolveMode::Direct}));
}

TEST(SolverSelection, JoinedBodiesAreSolvedAtOnceAsSoonAsTheyAreCrushed) {
  Piles piles({4, 4}, {{1, 2, 0}});
  for (int step = 0; step < 5; ++step) piles.note({{2, false}});
  EXPECT_EQ(piles.choose(), none);
  piles.note({{2, true}});
  EXPECT_EQ(piles.choose(), (std::vector<SolveMode>{SolveMode::Direct, SolveMode::Sweep}));
}

TEST(SolverSelection, WhatCanNotBeSolvedIsTriedAgainLater) {
  Piles piles({4});
  for (int step = 0; step < 10; ++step) piles.note({{2, false}});
  EXPECT_EQ(piles.choose(), std::vector<SolveMode>{SolveMode::Direct});
  piles.note({{2, true}}, {4, 3, 2, 1});
  EXPECT_EQ(piles.choose(), none);
  for (int step = 0; step < 120; ++step) {
    piles.note({{2, true}, {3, true}});
    EXPECT_EQ(piles.choose(), none) << step;
  }
  for (int step = 0; step < 3; ++step) piles.note({{2, false}});
  EXPECT_EQ(piles.choose(), std::vector<SolveMode>{SolveMode::Direct});
}

// An island that is asked to be solved at once, and can't be.
TEST(SolverSelection, TellsWhatIsRefused) {
  Piles piles({4});
  const auto choose_direct = [&] {
    return piles.selection.choose_direct(
        {piles.islands, piles.bodies, piles.manifolds.data(), {0, 0, -9.81}, 1.0 / 60, piles.settings})[0];
  };
  EXPECT_EQ(choose_direct(), SolveMode::Direct);
  EXPECT_TRUE(piles.selection.refused().empty());
  piles.bodies.locks[3] = 1;
  EXPECT_EQ(choose_direct(), SolveMode::Sweep);
  ASSERT_EQ(piles.selection.refused().size(), 1u);
  EXPECT_STREQ(piles.selection.refused()[0].why, "motions of its bodies are locked");
}

TEST(SolverSelection, SleepersKeepTheirStrain) {
  Piles piles({4});
  for (int step = 0; step < 5; ++step) piles.note({{2, false}});
  const auto before = piles.selection.load_history(2);
  piles.awake[2] = 0;
  for (int step = 0; step < 50; ++step) piles.note({});
  EXPECT_EQ(piles.selection.load_history(2), before);
  piles.awake[2] = 1;
  for (int step = 0; step < 50; ++step) piles.note({});
  EXPECT_EQ(piles.selection.load_history(2), SolverSelection::LoadHistory{});
}

TEST(SolverSelection, ForgetsWhoIsGone) {
  Piles piles({4});
  for (int step = 0; step < 5; ++step) piles.note({{2, false}, {3, false}});
  piles.selection.forget(2);
  EXPECT_EQ(piles.selection.loaded().size(), 1u);
  EXPECT_EQ(piles.selection.load_history(2), SolverSelection::LoadHistory{});
  piles.selection.forget(1);
  EXPECT_EQ(piles.selection.loaded().size(), 1u);
  piles.selection.arrive(4);
  piles.selection.forget_all();
  EXPECT_TRUE(piles.selection.loaded().empty());
  EXPECT_TRUE(piles.selection.arrived().empty());
  EXPECT_EQ(piles.selection.load_history(3), SolverSelection::LoadHistory{});
}

// At 30 Hz a contact between boxes of 1 kg gives by 2 g / 35500 s^2 = 0.55 mm for each box above, so that in columns,
// of half a metre of half thickness, five are too many (0.5%); on the ground it gives by an eighth of that.
TEST(SolverSelection, EstimatesTheLoadsOfWhatIsNew) {
  Piles piles({4, 20});
  for (std::uint32_t body = 1; body < 25; ++body) piles.selection.arrive(body);
  EXPECT_EQ(piles.choose(), (std::vector<SolveMode>{SolveMode::Sweep, SolveMode::Direct}));
  std::vector<std::uint32_t> expected;
  for (std::uint32_t body = 5; body <= 20; ++body) expected.push_back(body);
  const auto strained = piles.selection.loaded();
  EXPECT_EQ(std::vector<std::uint32_t>(strained.begin(), strained.end()), expected);
  EXPECT_TRUE(piles.selection.arrived().empty());
}

// A box that leans on one edge and whose other one comes down.
struct Rocking : Piles {
  Rocking() : Piles({1}) {
    collision::ContactManifold& manifold = manifolds[0];
    manifold.x[0] = -0.5f;
    manifold.x[1] = 0.5f;
    manifold.separation[1] = 0.01f;
    for (const int i : {2, 3}) manifold.separation[i] = collision::no_point;
    manifold.normal_impulse[0] = 0.1f;
    bodies.radius[1] = 0.8;
    bodies.angular_velocity(1) = turning();
  }
  // What brings the second point down: the tangents decide where it is.
  Vector3 turning() const {
    const collision::Tangents tangents = collision::tangents(manifolds[0].normal);
    const Vector3 x(tangents.first[0], tangents.first[1], tangents.first[2]);
    return -2 * x.cross(Vector3::UnitZ());
  }
};

TEST(SolverSelection, GivesLandingsFinerSubsteps) {
  Rocking rocking;
  EXPECT_EQ(rocking.choose(), std::vector<SolveMode>{SolveMode::Landing});
  EXPECT_STREQ(rocking.selection.why(0), "something lands in it that leans on something else");
}

TEST(SolverSelection, LeavesOtherLandingsToTheSweeps) {
  Rocking away;
  away.bodies.angular_velocity(1) *= -1;
  EXPECT_EQ(away.choose(), none);
  Rocking slow;
  slow.bodies.angular_velocity(1) *= 0.05;
  EXPECT_EQ(slow.choose(), none);
  Rocking high;
  high.manifolds[0].separation[1] = 0.1f;
  EXPECT_EQ(high.choose(), none);
  Rocking free;
  free.manifolds[0].normal_impulse[0] = 0;
  EXPECT_EQ(free.choose(), none);
}

}  // namespace
}  // namespace atl::solver
