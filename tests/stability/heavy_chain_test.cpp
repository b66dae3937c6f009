// Chains that swing down under a ball up to 1e5 times as heavy as a link, at default settings: nothing stretches, and
// energy stays.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "support/joined_run.h"

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

}  // namespace
}  // namespace atl::test
