// Features beside plain bodies and joints, in all modes of the solvers: the same bits on any number of threads,
// continued after a save, restored into another world, and replayed.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/continued.h"
#include "support/long_tests.h"
#include "support/scene_run.h"
#include "support/temporary_file.h"

namespace atl::test::features_matrix_test {
namespace {

constexpr int steps = 36;

/// A feature: how bodies are made, what functions a world is given, and what is done to it ahead of a step.
struct Feature {
  const char* name;
  std::function<void(BodyDef&, int)> define = [](BodyDef&, int) {};
  std::function<void(World&)> equip = [](World&) {};
  std::function<void(World&, const std::vector<BodyId>&, int)> act = [](World&, const std::vector<BodyId>&, int) {};
  bool counts = true;  // whether what it does shows in the state's hash
};

Compound pieces(int i) {
  return {{{.shape = Box{{0.2, 0.3, 0.2}}, .position = {-0.2, 0, 0}, .material = Material{.friction = 0.1 * (i % 5)}},
           {.shape = Sphere{0.25},
            .position = {0.25, 0, 0},
            .material = Material{.restitution = 0.3, .rolling_friction = 0.01},
            .filter = CollisionFilter{.mask = i % 3 == 0 ? 3u : 1u}}}};
}

const std::vector<Feature>& features() {
  static const std::vector<Feature> all = {
      {.name = "filter",
       .equip =
           [](World& world) {
             world.set_contact_filter(
                 [](const ContactCandidate& of) { return (of.a.index + 2 * of.b.index) % 5 != 0; });
           },
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step % 7 == 3) world.refilter(bodies[static_cast<std::size_t>(step) % bodies.size()]);
           }},
      // One that says something else as time goes by, without a memory of its own.
      {.name = "moody_filter",
       .equip =
           [](World& world) {
             world.set_contact_filter([](const ContactCandidate& of) {
               return of.a.index == 0 || of.world.pose(of.b).position.z() > of.world.pose(of.a).position.z();
             });
           },
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step % 4 == 1) world.refilter(bodies[static_cast<std::size_t>(step) % bodies.size()]);
           }},
      {.name = "modifier",
       .equip =
           [](World& world) {
             world.set_contact_modifier([](ModifiableContact& contact) {
               const std::uint32_t kind = (contact.a.index + contact.b.index) % 6;
               if (kind == 0) contact.friction *= 0.25;
               if (kind == 1) contact.restitution = 0.5;
               if (kind == 2) contact.run_surface(contact.a, {0.5, 0.2, 0});
               if (kind == 3) contact.points.back().enabled = false;
               if (kind == 4) contact.enabled = contact.world.velocity(contact.b).z() < 0.1;
             });
           }},
      {.name = "both_functions",
       .equip =
           [](World& world) {
             world.set_contact_filter([](const ContactCandidate& of) { return (of.a.index + of.b.index) % 4 != 1; });
             world.set_contact_modifier([](ModifiableContact& contact) {
               contact.friction = 0.1 + 0.1 * (contact.b.index % 7);
               if (contact.normal.z() < 0.2 && contact.a.index != 0) contact.points.front().enabled = false;
             });
           },
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             if (step == 10) world.remove_body(bodies[3]);
             if (step == 12) world.add_body({.shape = Sphere{0.3}, .position = {0, 0.1, 6}});
             if (step == 20) world.set_contact_filter({});
           }},
      {.name = "sensors",
       .define = [](BodyDef& def, int i) { def.sensor = i % 6 == 5; },
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             for (const SensorEvent& event : world.sensor_events()) {
               const Vector3 centre = world.centre_of_mass(event.body);
               if (step % 5 == 0 && event.entered) world.apply_impulse(event.body, {0, 0, 20}, centre);
             }
             if (step == 15) world.set_filter(bodies[5], {.mask = 2});
           }},
      {.name = "children", .define = [](BodyDef& def, int i) { def.shape = pieces(i); }},
      {.name = "set_shape",
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             const BodyId id = bodies[static_cast<std::size_t>(step) % bodies.size()];
             if (step % 5 == 2) world.set_shape(id, Capsule{.radius = 0.2, .half_height = 0.2});
             if (step % 5 == 4) world.set_shape(id, pieces(step));
           }},
      {.name = "set_heights",
       .act =
           [](World& world, const std::vector<BodyId>&, int step) {
             if (step == 0) {
               world.add_body({.type = BodyType::Static,
                               .shape = HeightField(9, 9, 0.25, 0.25, std::vector(81, 0.1)),
                               .position = {-1, -1, 0},
                               .name = "hills"});
             }
             const double height = step % 6 == 1 ? std::nan("") : 0.05 * (step % 5);
             const auto column = static_cast<std::uint32_t>(step % 6);
             if (step % 3 == 1) world.set_heights(*world.find_body("hills"), column, 2, 2, std::vector(6, height));
           }},
      {.name = "set_material",
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             const BodyId id = bodies[static_cast<std::size_t>(step) % bodies.size()];
             if (step % 4 == 1) world.set_material(id, {.friction = 0.05 * (step % 9), .restitution = 0.02 * step});
             if (step % 4 == 3) world.set_material(id, {.friction = 0.4, .torsional_friction = 0.02});
           }},
      {.name = "user_data_and_names",
       .act =
           [](World& world, const std::vector<BodyId>& bodies, int step) {
             const BodyId id = bodies[static_cast<std::size_t>(step) % bodies.size()];
             world.set_user_data(id, world.user_data(id) + 1);
             world.set_name(id, "body " + std::to_string(step));
           },
       .counts = false},
  };
  return all;
}

MakeStep fill_with(World& world, const Feature& feature) {
  world.add_body(ground());
  std::vector<BodyId> bodies;
  for (int i = 0; i < 18; ++i) {
    const Vector3 position(0.45 * (i % 3) - 0.4, 0.4 * (i / 3 % 2), 0.5 + 0.55 * (i / 3));
    BodyDef def = i % 4 == 0 ? sphere(position, 0.3) : box(position, {0.3, 0.25, 0.25});
    feature.define(def, i);
    bodies.push_back(world.add_body(def));
  }
  // A rope that lies in the pile.
  for (std::size_t i = 6; i < 9; ++i) {
    world.add_joint(joint_at(world, BallJoint{}, bodies[i], bodies[i + 1],
                             0.5 * (world.pose(bodies[i]).position + world.pose(bodies[i + 1]).position)));
  }
  return [bodies, act = feature.act](World& of, int number) {
    act(of, bodies, number);
    of.step(dt);
  };
}

using Case = std::tuple<std::size_t, JointSolver, ContactSolver, bool>;

class FeatureIn : public testing::TestWithParam<Case> {
 protected:
  const Feature& feature = features()[std::get<0>(GetParam())];
  Settings settings = {.target = std::get<3>(GetParam()) ? all_targets() : ErrorTarget{},
                       .contact_solver = std::get<2>(GetParam()),
                       .joint_solver = std::get<1>(GetParam()),
                       .sleeping = true,
                       .contact_events = true};
};

TEST_P(FeatureIn, HasTheSameBitsHoweverItIsContinued) {
  const auto fill = [&](World& world) { return fill_with(world, feature); };
  const auto trail = expect_same_bits({fill, settings, steps, feature.equip}, {{.threads = 2}});
  World plain({.settings = settings});
  fill_with(plain, {.name = "none", .define = feature.define});
  bool differs = false;
  for (const std::uint64_t hash : trail) {
    plain.step(dt);
    differs |= plain.state_hash() != hash;
  }
  const bool is_all_definition = std::string(feature.name) == "children";
  EXPECT_EQ(differs, feature.counts && !is_all_definition) << "whether it does anything";
}

// Bodies that are thrown into heaps, where continuous collision asks of what it meets, also on ways aside of what it
// touches.
TEST(ContactFilterInHeaps, IsAskedInOneOrderAndReplayed) {
  for (const char* name : {"pile:bodies=150", "ragdolls:count=4", "drum:boxes=60"}) {
    std::vector<std::pair<BodyId, BodyId>> asked[2];
    std::uint64_t hashes[2];
    for (const int threads : {1, 2}) {
      SceneRun run(load_scene(name), {.threads = threads});
      const auto number = static_cast<std::size_t>(threads - 1);
      run.world.set_contact_filter([&](const ContactCandidate& of) {
        asked[number].emplace_back(of.a, of.b);
        return of.a.index < 8 || (of.a.index + of.b.index) % 5 != 0;
      });
      const TemporaryFile file(".heap");
      run.world.record(file.path());
      std::int64_t swept = 0;
      for (int i = 0; i < 70; ++i) {
        for (const BodyId id : run.ids) {
          if (i % 20 != 10 || id.index % 3 != 0 || run.world.type(id) != BodyType::Dynamic) continue;
          run.world.set_velocity(id, {60.0 - id.index % 7 * 20, 40.0 - id.index % 5 * 20, -80}, Vector3::Zero());
        }
        swept += run.world.step(run.scene.dt).counts.swept;
      }
      EXPECT_GT(swept, 100) << name;
      run.world.stop_recording();
      hashes[number] = run.world.state_hash();
      const ReplayResult replayed = replay(file.path(), {.threads = 3 - threads});
      EXPECT_FALSE(replayed.divergence) << name;
      EXPECT_EQ(replayed.hash, hashes[number]) << name;
    }
    EXPECT_EQ(asked[0], asked[1]) << name;
    EXPECT_EQ(hashes[0], hashes[1]) << name;
  }
}

// All combinations in long tests, else half of them: still each two of feature, solvers and target together.
std::vector<Case> cases() {
  std::vector<Case> chosen;
  for (std::size_t feature = 0; feature < features().size(); ++feature) {
    for (int joints = 0; joints < 3; ++joints) {
      for (int contacts = 0; contacts < 3; ++contacts) {
        for (const bool target : {false, true}) {
          if (!long_tests() && (feature + static_cast<std::size_t>(joints + contacts + target)) % 2 == 1) continue;
          chosen.emplace_back(feature, static_cast<JointSolver>(joints), static_cast<ContactSolver>(contacts), target);
        }
      }
    }
  }
  return chosen;
}

INSTANTIATE_TEST_SUITE_P(Modes, FeatureIn, testing::ValuesIn(cases()), [](const auto& test) {
  return std::string(features()[std::get<0>(test.param)].name) + "_" + std::to_string(test.index);
});

}  // namespace
}  // namespace atl::test::features_matrix_test
