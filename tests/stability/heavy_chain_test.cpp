// Chains that swing down under a ball up to 1e5 times as heavy as a link, at default settings: nothing stretches, and
// energy stays.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "support/joined_run.h"
#include "support/min_turn.h"

namespace atl::test {
namespace {

struct Swing {
  double gap = 0;      ///< m, the largest of any joint after any step in which no link turned too fast to be followed
  double end_gap = 0;  ///< m, as the run ends
  double energy = 0;   ///< the largest change, over the weight times the length
};

Swing swing(const std::string& scene, int links, int steps) {
  JoinedRun run(scene);
  const double start = run.energy();
  const double scale = run.total_mass() * g * 0.5 * links;
  constexpr double followed = 0.5;  // rad a substep
  Swing worst;
  double turned = 0;
  for (int step = 0; step < steps; ++step) {
    EXPECT_EQ(run.world.step(run.scene.dt).first_quarantined, -1) << scene << ", step " << step;
    const double turned_before = turned;
    turned = run.world.angular_velocities().colwise().norm().maxCoeff() * substep();
    worst.end_gap = run.drift().max;
    if (std::max(turned, turned_before) < followed) worst.gap = std::max(worst.gap, worst.end_gap);
    worst.energy = std::max(worst.energy, std::abs(run.energy() - start) / scale);
  }
  return worst;
}

TEST(HeavyChain, NeitherStretchesNorGainsEnergy) {
  const Swing worst = swing("chain:links=100,ratio=1000", 100, 600);
  EXPECT_LT(worst.gap, 1e-8);
  EXPECT_LT(worst.energy, 1e-12);
  // How fast the lighter ones whip is chance.
  constexpr int first = 95, lengths = 8;
  double gaps = 0;
  for (int links = first; links < first + lengths; ++links) {
    const std::string scene = "chain:links=" + std::to_string(links) + ",ratio=100000";
    const Swing whip = swing(scene, links, 600);
    gaps += whip.gap;
    EXPECT_LT(whip.energy, 2e-3) << scene;
  }
  EXPECT_LT(gaps / lengths, 1e-3);
}

TEST(HeavyChain, OfAThousandLinksNeither) {
  const Swing worst = swing("chain:links=1000,ratio=1000", 1000, 200);
  EXPECT_LT(worst.gap, 1e-5);
  EXPECT_LT(worst.energy, 1e-4);
}

// Its end cracks like a whip, a radian in a substep of 4 ms: joints there open by 10 cm, and
// close within the next steps.
TEST(HeavyChain, ThatIsLightAtItsEndLosesSomeEnergy) {
  const Swing worst = swing("chain:links=100,ratio=1", 100, 600);
  EXPECT_LT(worst.gap, 5e-3);
  EXPECT_LT(worst.end_gap, 1e-3);
  EXPECT_LT(worst.energy, 0.2);
}

enum class Link { Ball, TwoBalls, Hinge, Rod };

// Planks, a joint every .5 m between them, that exactly span two posts, with a load at the middle. Rods are between
// their middles.
Scene taut_bridge(int planks, double mass, Link link) {
  Scene scene;
  const CollisionFilter none = {.mask = 0};
  const auto add = [&](const BodyDef& def) {
    scene.bodies.push_back({.def = def});
    return scene.bodies.size() - 1;
  };
  const auto add_post = [&](double x) {
    return add({.type = BodyType::Static, .shape = Sphere{0.1}, .position = {x, 0, 0}, .filter = none});
  };
  const auto pin_at = [&](std::size_t first, std::size_t second, const Vector3& point) {
    JointDef def{.kind = BallJoint{}};
    if (link == Link::Hinge) def.kind = HingeJoint{};  // about y
    def.frame_first.orientation = def.frame_second.orientation = min_turn(Vector3::UnitX(), Vector3::UnitY());
    def.frame_first.position = point - scene.bodies[first].def.position;
    def.frame_second.position = point - scene.bodies[second].def.position;
    scene.joints.push_back({.def = def, .first = first, .second = second});
  };
  const auto connect = [&](std::size_t first, std::size_t second, double x) {
    const double length = (scene.bodies[second].def.position - scene.bodies[first].def.position).norm();
    if (link == Link::Rod) {
      const JointDef rod{.kind = DistanceJoint{{.range = {length, length}}}};
      scene.joints.push_back({.def = rod, .first = first, .second = second});
    } else if (link == Link::TwoBalls) {
      for (const double y : {-0.4, 0.4}) pin_at(first, second, {x, y, 0});
    } else {
      pin_at(first, second, {x, 0, 0});
    }
  };
  std::size_t before = add_post(0);
  const std::size_t middle = before + 1 + static_cast<std::size_t>(planks) / 2;
  for (int i = 0; i < planks; ++i) {
    const double x = 0.25 + 0.5 * i;
    const std::size_t plank = add({.shape = Box{{0.25, 0.5, 0.05}}, .position = {x, 0, 0}, .mass = 25, .filter = none});
    connect(before, plank, 0.5 * i);
    before = plank;
  }
  connect(before, add_post(0.5 * planks), 0.5 * planks);
  const Vector3 hangs = scene.bodies[middle].def.position;
  const std::size_t load =
      add({.shape = Sphere{0.5}, .position = hangs - Vector3::UnitZ(), .mass = mass, .filter = none});
  pin_at(middle, load, hangs);
  return scene;
}

// It can't give way: no motion closes its joints but one that lifts the load, and light planks would rather turn far.
TEST(HeavyChain, ThatJustSpansItsPostsStaysTaut) {
  for (const Link link : {Link::Ball, Link::TwoBalls, Link::Hinge, Link::Rod}) {
    for (const double mass : {25.0, 5e3, 1e6}) {
      for (const int substeps : {1, 4, 8}) {
        Scene scene = taut_bridge(60, mass, link);
        scene.settings.substeps = substeps;
        JoinedRun run(scene);
        const double start = run.energy();
        double gap = 0, gained = 0;
        for (int i = 0; i < 120; ++i) {
          run.world.step(dt);
          gap = std::max(gap, run.drift().max);
          gained = std::max(gained, run.energy() - start);
        }
        const std::string of = std::to_string(mass) + " kg, " + std::to_string(substeps) + " substeps, link " +
                               std::to_string(static_cast<int>(link));
        EXPECT_LT(gap, 5e-4) << of;
        EXPECT_LT(gained, 1e-5 * mass * g) << of;
      }
    }
  }
}

}  // namespace
}  // namespace atl::test
