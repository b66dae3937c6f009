// Bodies squeezed where contacts can't all open: wedges, clamps and pockets of one compound. Whatever the solver,
// forces are of the size of the load, and nothing is launched.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "support/bodies.h"
#include "support/random.h"

namespace atl::test {
namespace {

struct Squeeze {
  double force = 0;   ///< N, the largest normal force of a pair
  double load = 0;    ///< N: what presses, by what slopes make of it, and what springs as stiff as contacts push with
  double launch = 0;  ///< m/s, upward or aside
  bool quarantined = false;
};

// A box between the two walls of a pocket, with a load on top. Walls are children of one body, parallel or leaning out,
// and overlap the box by up to 2 mm. Whatever it does, it doesn't fall far.
Squeeze squeeze(std::uint32_t seed, ContactSolver solver) {
  Random random(seed);
  const double lean = seed % 2 == 0 ? 0 : random.real(0.1, 0.6);  // rad, from the vertical
  const double overlap = random.real(0, 2e-3);
  const double ratio = std::pow(10, random.real(0, 4));
  const double mu = random.real(0.05, 0.8);
  const bool free = seed % 3 == 0;  // the pocket lies on the ground
  World world({.settings = {.contact_solver = solver}});
  world.add_body(ground());
  Compound pocket;
  const Box wall{{0.1, 0.5, 0.6}};
  for (const double side : {-1.0, 1.0}) {
    const Quaternion turn(Eigen::AngleAxisd(side * lean, Vector3::UnitY()));
    pocket.children.push_back({.shape = wall,
                               .position = Vector3(side * 0.25, 0, 0.6) + turn * Vector3(side * 0.1, 0, 0),
                               .orientation = turn});
  }
  // Under the box, by half a centimetre, and down to the ground.
  pocket.children.push_back({.shape = Box{{0.6, 0.5, 0.5475}}, .position = {0, 0, 0.0475}});
  BodyDef base{.type = free ? BodyType::Dynamic : BodyType::Static, .shape = pocket, .position = {0, 0, 0.5}};
  base.density = 2000;
  base.material.friction = mu;
  const BodyId under = world.add_body(base);
  BodyDef wedged{.shape = Box{{0.25 + overlap / 2, 0.25, 0.25}}, .position = {0, 0, 1.1}};
  wedged.material.friction = mu;
  // Its lower edges touch the walls.
  wedged.position.z() += 0.25;
  const BodyId id = world.add_body(wedged);
  BodyDef weight = box({0, 0, wedged.position.z() + 0.5}, {0.2, 0.2, 0.25});
  weight.density = 1000 * ratio;
  const BodyId heavy = world.add_body(weight);
  Squeeze seen;
  const double spring = std::pow(2 * std::numbers::pi * 60, 2) * world.mass(id);
  const double slopes = std::max(1.0, 0.5 / (lean > 0 ? std::sin(lean) : mu));
  seen.load = slopes * (world.mass(id) + world.mass(heavy)) * g + spring * overlap;
  if (free) seen.load += world.mass(under) * g;
  for (int step = 0; step < 120; ++step) {
    const StepReport report = world.step(dt);
    seen.quarantined |= report.first_quarantined >= 0;
    for (const BodyId body : {id, heavy, under}) {
      const Vector3 velocity = world.velocity(body);
      seen.launch = std::max({seen.launch, velocity.z(), velocity.head<2>().norm()});
    }
    if (step < 60) continue;
    for (const ContactForce& force : world.contact_forces()) seen.force = std::max(seen.force, force.normal_force);
  }
  return seen;
}

TEST(Wedges, PushNoHarderThanTheyAreLoadedAndLaunchNothing) {
  for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct}) {
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
      const Squeeze seen = squeeze(seed, solver);
      const std::string which = std::to_string(seed) + (solver == ContactSolver::Direct ? " direct" : " auto");
      EXPECT_FALSE(seen.quarantined) << which;
      EXPECT_LT(seen.force, 2 * seen.load) << which;
      EXPECT_LT(seen.launch, 1) << which;
    }
  }
}

}  // namespace
}  // namespace atl::test
