// A body that is light, or turns easily, between heavy ones that joints hold to it gives no energy away that it hasn't,
// at default settings.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

double energy_of(const World& world) {
  double energy = 0;
  for (const BodyId id : world.bodies()) {
    const Vector3 spin = world.pose(id).orientation.conjugate() * world.angular_velocity(id);
    energy += 0.5 * world.mass(id) * world.velocity(id).squaredNorm();
    energy += 0.5 * spin.dot(*world.definition(id).inertia * spin);
  }
  return energy;
}

struct Flight {
  double start = 0, max = 0;  ///< J
  double apart = 0;           ///< m, the most of any joint
};

// A bar with a wheel at each end, beside it, that turns about an axis across both: its moment of inertia about its
// length is a fraction of theirs, and no mass is.
Flight fly(const JointKind& kind, double thickness, double radius, int substeps = 4) {
  World world({.gravity = {0, 0, 0}, .settings = {.substeps = substeps}});
  const Vector3 spin(0, 0, 2);
  const BodyId bar = world.add_body({.shape = Box{{0.7, thickness, 2 * thickness}}, .angular_velocity = spin});
  const Quaternion tilt(std::sqrt(0.5), std::sqrt(0.5), 0, 0);
  std::vector<std::pair<Vector3, BodyId>> wheels;
  for (const double side : {-1.0, 1.0}) {
    const Vector3 place(side * 0.4, 0.2, 0);
    const BodyId wheel = world.add_body({.shape = Cylinder{radius, 0.08},
                                         .position = place,
                                         .orientation = tilt,
                                         .velocity = spin.cross(place),
                                         .angular_velocity = spin});
    world.add_joint(joint_at(world, kind, bar, wheel, place, {0, 1, 0}));
    wheels.emplace_back(place, wheel);
  }
  Flight flight{.start = energy_of(world)};
  for (int step = 0; step < 600; ++step) {
    world.step(dt);
    flight.max = std::max(flight.max, energy_of(world));
    for (const auto& [place, wheel] : wheels) {
      const Pose at = world.pose(bar);
      const Vector3 gap = at.position + at.orientation * place - world.pose(wheel).position;
      flight.apart = std::max(flight.apart, gap.norm());
    }
  }
  EXPECT_TRUE(world.quarantined().empty());
  return flight;
}

TEST(LightBetweenHeavy, WheelsOnAThinBarGainNoEnergy) {
  for (const double thickness : {0.02, 0.03, 0.05, 0.07}) {
    for (const double radius : {0.1, 0.15, 0.2, 0.24, 0.26, 0.3}) {
      const Flight flight = fly(HingeJoint{}, thickness, radius);
      EXPECT_LT(flight.max, 1.001 * flight.start) << thickness << " " << radius;
      EXPECT_LT(flight.apart, 1e-3) << thickness << " " << radius;
    }
  }
}

TEST(LightBetweenHeavy, NorDoOthersHeldInOtherWays) {
  for (const double radius : {0.24, 0.3}) {
    for (const JointKind& kind : std::vector<JointKind>{FixedJoint{}, BallJoint{}, UniversalJoint{}}) {
      const Flight flight = fly(kind, 0.05, radius);
      EXPECT_LT(flight.max, 1.001 * flight.start) << kind.index() << " " << radius;
    }
    for (const int substeps : {2, 8, 16}) {
      const Flight flight = fly(HingeJoint{}, 0.05, radius, substeps);
      EXPECT_LT(flight.max, 1.001 * flight.start) << substeps << " " << radius;
    }
  }
}

}  // namespace
}  // namespace atl::test
