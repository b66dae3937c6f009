// Whatever touches within a step is told, however it ends: by every shape, solver and restitution, where no weight
// brings it back.

#include <atoll/forces.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

struct Hit {
  std::string name;
  Shape shape;  // half a metre high
  double restitution = 0;
  Settings settings = {};
  bool joined = false;  // with a rider
  bool by_law = false;  // in a step for each substep
};
void PrintTo(const Hit& hit, std::ostream* out) { *out << hit.name; }

enum class Against { Ground, Slab, Itself };

class HitEvents : public testing::TestWithParam<Hit> {
 protected:
  // Steps in which a body's velocity changed, and nobody was told to touch.
  static int untold(const Hit& hit, Against against, int phase) {
    Settings settings = hit.settings;
    settings.contact_events = true;
    settings.sleeping = false;
    World world({.gravity = Vector3::Zero(), .settings = settings});
    const Material material{.restitution = hit.restitution};
    BodyDef other{.type = BodyType::Static, .shape = HalfSpace{}, .material = material};
    if (against == Against::Slab)
      other = {.type = BodyType::Static, .shape = Box{{3, 3, 0.5}}, .position = {0, 0, -0.5}, .material = material};
    if (against == Against::Itself) other = {.shape = hit.shape, .position = {0, 0, -0.5}, .material = material};
    const BodyId at_rest = world.add_body(other);
    const double gap = 0.05 + 0.031 * phase, speed = 20 + 0.7 * phase;
    const BodyId id = world.add_body(
        {.shape = hit.shape, .position = {0, 0, 0.5 + gap}, .velocity = {0, 0, -speed}, .material = material});
    if (hit.joined) {
      const BodyId rider = world.add_body({.shape = Sphere{0.1},
                                           .position = {0, 0, 0.5 + gap},
                                           .velocity = {0, 0, -speed},
                                           .mass = 1e-3 * world.mass(id),
                                           .filter = {.mask = 0}});
      world.add_joint({.kind = FixedJoint{}, .first = id, .second = rider});
    }
    bool touches = false;
    int count = 0, changes = 0;
    for (int step = 0; step < 40; ++step) {
      const Vector3 before = world.velocity(id);
      if (hit.by_law) {
        world.step(dt, [](Forces&) {});
      } else {
        world.step(dt);
      }
      const Vector3 gained = world.velocity(id) - before;
      for (const ContactEvent& event : world.contact_events()) {
        EXPECT_EQ(std::minmax(event.a, event.b), std::minmax(at_rest, id));
        touches = event.began;
        const double mass = world.mass(id) * (hit.joined ? 1 + 1e-3 : 1);
        if (!event.began) continue;
        // But for friction, where balls of compounds meet askew.
        EXPECT_NEAR(event.impulse, mass * gained.norm(), 5e-3 * mass * speed) << phase;
        if (changes == 0) {
          EXPECT_NEAR(event.approach_speed, speed, 1e-3 * speed) << phase;
        }
      }
      const bool changed = gained.norm() > 1e-3 * speed;
      changes += changed;
      count += changed && !touches;
    }
    EXPECT_GT(changes, 0) << phase;
    return count;
  }
};

TEST_P(HitEvents, TellOfAllThatChangesAVelocity) {
  for (const Against against : {Against::Ground, Against::Slab, Against::Itself}) {
    int lost = 0;
    for (int phase = 0; phase < 50; ++phase) lost += untold(GetParam(), against, phase);
    EXPECT_EQ(lost, 0) << "against " << static_cast<int>(against);
  }
}

std::vector<Hit> all_hits() {
  const Settings swept{.contact_solver = ContactSolver::Iterative, .joint_solver = JointSolver::Iterative};
  const Settings direct{.contact_solver = ContactSolver::Direct, .joint_solver = JointSolver::Direct};
  const Compound pair{
      {{.shape = Sphere{0.5}, .position = {-0.6, 0, 0}}, {.shape = Sphere{0.5}, .position = {0.6, 0, 0}}}};
  std::vector<Hit> hits = {{"sphere", Sphere{0.5}},
                           {"box", Box{{0.5, 0.5, 0.5}}},
                           {"capsule", Capsule{0.25, 0.25}},
                           {"cylinder", Cylinder{0.5, 0.5}},
                           {"compound", pair}};
  const std::size_t shapes = hits.size();
  for (std::size_t i = 0; i < shapes; ++i) {
    const Hit plain = hits[i];
    const auto add = [&](const char* how, const auto& change) {
      Hit hit = plain;
      hit.name += std::string("_") + how;
      change(hit);
      hits.push_back(hit);
    };
    add("bouncing", [](Hit& hit) { hit.restitution = 0.5; });
    add("swept", [&](Hit& hit) { hit.settings = swept; });
    add("direct", [&](Hit& hit) { hit.settings = direct; });
    add("joined", [&](Hit& hit) {
      hit.settings = direct;
      hit.joined = true;
    });
    add("rigid", [](Hit& hit) { hit.settings.stabilisation = Stabilisation::SplitImpulse; });
    add("by_law", [](Hit& hit) { hit.by_law = true; });
  }
  return hits;
}

INSTANTIATE_TEST_SUITE_P(Shapes, HitEvents, testing::ValuesIn(all_hits()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace atl::test
