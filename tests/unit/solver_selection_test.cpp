// Which islands are not swept, by what lies on their contacts.

#include <gtest/gtest.h>
#include <solver/select/solver_selection.h>
#include <solver/tuning.h>

#include <cmath>
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
  LoadInput input() const { return {islands, bodies, manifolds.data(), {0, 0, -9.81}, 1.0 / 60, settings}; }
  std::vector<SolveMode> choose(bool estimates = true) {
    LoadInput here = input();
    here.estimates = estimates;
    jobs::Arena arena(1);
    const auto modes = selection.choose(here, arena);
    return {modes.begin(), modes.end()};
  }
  LoadEstimate::Overload overload(std::size_t island) {
    return LoadEstimate().of(input(), island, build_of(islands, island));
  }
};

const std::vector<SolveMode> none = {};
const std::vector<SolveMode> second_at_once = {SolveMode::Sweep, SolveMode::Direct};

// At 30 Hz a contact between boxes of 1 kg gives by 2 g / 35500 s^2 = 0.55 mm for each box above, so that in columns,
// of half a metre of half thickness, five are too many (0.43%); on the ground it gives by an eighth of that.
TEST(SolverSelection, SolvesColumnsAtOnceFromFiveBoxesOn) {
  Piles piles({4, 5});
  EXPECT_EQ(piles.choose(), second_at_once);
  EXPECT_STREQ(piles.selection.why(1), "contacts give way under what they carry");
  EXPECT_EQ(Piles({4, 4}).choose(), none);
}

// Substeps make contacts stiffer, but sweeps don't settle a column any sooner.
TEST(SolverSelection, ColumnsNeedTheSameWithManySubsteps) {
  Piles piles({4, 20});
  piles.settings.substeps = 32;
  EXPECT_EQ(piles.choose(), second_at_once);
}

TEST(SolverSelection, JoinedBodiesAreSolvedAtOnceWhereTheyAreCrushed) {
  const auto with_top = [](double mass) {
    Piles piles({4, 4}, {{5, 6, 0}});
    piles.bodies.inverse_mass[8] = 1 / mass;
    return piles.choose();
  };
  EXPECT_EQ(with_top(63), none);
  EXPECT_EQ(with_top(65), second_at_once);
}

// Between estimates an island keeps its mode, unless it becomes another.
TEST(SolverSelection, KeepsModesBetweenEstimates) {
  Piles piles({4, 5});
  EXPECT_EQ(piles.choose(false), second_at_once);  // they are new
  for (std::uint32_t body = 5; body < 10; ++body) {
    EXPECT_EQ(piles.selection.finding(body).mode, SolveMode::Direct);
    piles.bodies.gravity_scale[body] = 0;  // an estimate finds nothing now
  }
  EXPECT_EQ(piles.choose(false), second_at_once);
  piles.selection.forget(7);
  EXPECT_EQ(piles.choose(false), none);
}

TEST(SolverSelection, WhatCanNotBeSolvedIsTriedAgainLater) {
  Piles piles({5});
  const std::vector<SolveMode> at_once = {SolveMode::Direct};
  EXPECT_EQ(piles.choose(), at_once);
  piles.selection.note_failed(std::vector<std::uint32_t>{4, 3, 2, 1}, piles.awake, 1.0 / 60);
  const int steps = static_cast<int>(std::lround(tuning::failed_time * 60));
  for (int step = 0; step < steps; ++step) {
    EXPECT_EQ(piles.choose(), none) << step;
    piles.selection.note_failed({}, piles.awake, 1.0 / 60);
  }
  EXPECT_EQ(piles.choose(), at_once);
}

TEST(SolverSelection, TimeStandsStillForSleepers) {
  Piles piles({4});
  piles.selection.note_failed(std::vector<std::uint32_t>{2, 3}, piles.awake, 1.0 / 60);
  piles.awake[2] = 0;
  for (int step = 0; step < 200; ++step) piles.selection.note_failed({}, piles.awake, 1.0 / 60);
  EXPECT_EQ(piles.selection.finding(2).swept, tuning::failed_time);
  EXPECT_EQ(piles.selection.finding(3), SolverSelection::Finding{});
  piles.selection.forget(2);
  EXPECT_EQ(piles.selection.finding(2), SolverSelection::Finding{});
}

// An island that is asked to be solved at once, and can't be.
TEST(SolverSelection, TellsWhatIsRefused) {
  Piles piles({4});
  const auto choose_direct = [&] { return piles.selection.choose_direct(piles.input())[0]; };
  EXPECT_EQ(choose_direct(), SolveMode::Direct);
  EXPECT_TRUE(piles.selection.refused().empty());
  piles.bodies.locks[3] = 1;
  EXPECT_EQ(choose_direct(), SolveMode::Sweep);
  ASSERT_EQ(piles.selection.refused().size(), 1u);
  EXPECT_STREQ(piles.selection.refused()[0].why, "motions of its bodies are locked");
}

TEST(LoadEstimate, CountsBodiesThatCarryTooMuch) {
  Piles piles({4, 20});
  EXPECT_EQ(piles.overload(0).bodies, 0u);
  EXPECT_EQ(piles.overload(1).bodies, 16u);
  EXPECT_FALSE(piles.overload(1).deep);
}

// The lower half thickness counts, which at a rim is a tenth of the arm. What doesn't respond has none.
TEST(LoadEstimate, MeasuresOverlapsAgainstThickness) {
  const auto overloads = [](float thickness, float across, std::size_t contact) {
    Piles piles({4});
    piles.manifolds[contact].anchor_first[2] = thickness;
    piles.manifolds[contact].anchor_first[0] = across;
    return piles.overload(0).bodies;
  };
  EXPECT_EQ(overloads(0.39f, 0, 1), 0u);  // three boxes: 1.66 mm over 0.43%
  EXPECT_EQ(overloads(0.38f, 0, 1), 1u);
  EXPECT_EQ(overloads(0.001f, 3.9f, 1), 0u);
  EXPECT_EQ(overloads(0.001f, 3.8f, 1), 1u);
  EXPECT_EQ(overloads(0.001f, 0, 0), 0u);
}

TEST(LoadEstimate, CallsDeepWhatOverlapsByAPartOfTheArm) {
  const auto deep = [](double mass) {
    Piles piles({4});
    piles.bodies.inverse_mass[4] = 1 / mass;
    return piles.overload(0).deep;
  };
  EXPECT_FALSE(deep(105));  // 0.276 mm for each of the boxes' weights, over 60 mm, on the third; twice that in all
  EXPECT_TRUE(deep(220));
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
  // An angular velocity that brings the second point down: its place depends on the tangents.
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
