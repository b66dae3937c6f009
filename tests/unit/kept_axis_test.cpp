// Pairs that move in small steps, each contact found from the last, without FCL: the axes part them as well as those
// found anew.

#include <collision/narrowphase/collide.h>
#include <collision/shapes/shape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>

#include "random_solids.h"
#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

// From the first shape to the second, frame of the first.
Vector3 normal_of(const Manifold& manifold, const Pose& second) {
  return manifold.reference_is_second ? Vector3(-(second.orientation * manifold.normal)) : manifold.normal;
}

struct Kinds {
  ShapeKind first, second;
  friend void PrintTo(const Kinds& kinds, std::ostream* out) {
    *out << static_cast<int>(kinds.first) << "-" << static_cast<int>(kinds.second);
  }
};

class KeptAxis : public testing::TestWithParam<Kinds> {
 protected:
  Random random_{7};
};

TEST_P(KeptAxis, PartsAsWellAsAFreshOne) {
  constexpr int pairs = 60, steps = 60;
  int looks = 0, asked = 0, worse = 0, lost = 0;
  for (int i = 0; i < pairs; ++i) {
    test::Solids solids;
    const Shape first = solids.random(GetParam().first, random_, 24);
    const Shape second = solids.random(GetParam().second, random_, 24);
    const double size = std::min(first.inner_radius, second.inner_radius);
    const double margin = 0.05 * size;
    Pose pose{(first.bounding_radius + second.bounding_radius) * random_.direction(), random_.rotation()};
    Manifold found;
    while (found.count == 0) {
      pose.position *= 1 - 0.01 * size;
      found = {};
      collide(first, second, pose, margin, found);
    }
    for (int step = 0; step < steps; ++step) {
      // They stay as deep in each other as a hundredth of their size, and slide and turn.
      pose.position -= (found.min_separation() + 0.01 * size) * normal_of(found, pose);
      pose.position += 0.005 * size * random_.direction();
      pose.orientation = (random_.rotation(0.01) * pose.orientation).normalized();
      Manifold kept = as_last(found), fresh;
      asked += asks_fcl(collide(first, second, pose, margin, kept));
      collide(first, second, pose, margin, fresh);
      ++looks;
      lost += kept.count == 0 && fresh.count > 0;
      worse += kept.count > 0 && fresh.count > 0 && kept.min_separation() < fresh.min_separation() - 2e-3 * size;
      found = fresh.count > 0 && kept.count == 0 ? fresh : kept;
      if (found.count == 0) break;
    }
  }
  EXPECT_GT(looks, pairs * steps / 2);
  EXPECT_EQ(lost, 0);
  // Overlapping solids may have two axes that no neighbour is better than. Each way finds the lesser one at times.
  EXPECT_LE(worse, looks / 200);
  EXPECT_EQ(asked, 0);
}

constexpr ShapeKind box = ShapeKind::Box, capsule = ShapeKind::Capsule, cylinder = ShapeKind::Cylinder,
                    cone = ShapeKind::Cone, hull = ShapeKind::Hull, ellipsoid = ShapeKind::Ellipsoid,
                    tapered = ShapeKind::TaperedCapsule;

INSTANTIATE_TEST_SUITE_P(Solids, KeptAxis,
                         testing::Values(Kinds{box, box}, Kinds{hull, hull}, Kinds{box, hull}, Kinds{box, capsule},
                                         Kinds{capsule, hull}, Kinds{box, cylinder}, Kinds{cylinder, cylinder},
                                         Kinds{cylinder, hull}, Kinds{box, cone}, Kinds{cone, hull},
                                         Kinds{cylinder, cone}, Kinds{capsule, cylinder}, Kinds{capsule, cone},
                                         Kinds{cone, cone}, Kinds{box, ellipsoid}, Kinds{hull, ellipsoid},
                                         Kinds{cylinder, ellipsoid}, Kinds{ellipsoid, ellipsoid},
                                         Kinds{capsule, ellipsoid}, Kinds{cone, tapered}, Kinds{hull, tapered},
                                         Kinds{ellipsoid, tapered}, Kinds{tapered, tapered}));

}  // namespace
}  // namespace atl::collision
