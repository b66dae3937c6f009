// Sensors: who is in them, when that changes, and that nobody feels them.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace atl {
namespace {

constexpr double dt = 1.0 / 60;

// A ball that falls through a sensor from 1.25 m to 0.75 m onto a floor at -10 m.
struct Fall {
  World world;
  BodyId sensor, ball;

  explicit Fall(const Shape& gate = Box{{1, 1, 0.25}}) {
    sensor = world.add_body(
        {.type = BodyType::Static, .shape = gate, .position = {0, 0, 1}, .sensor = true, .name = "gate"});
    ball = world.add_body({.shape = Sphere{0.1}, .position = {0, 0, 2}});
  }
};

TEST(Sensors, TellWhoEntersAndWhoLeavesAndHoldNobodyUp) {
  for (const Shape& gate :
       {Shape(Box{{1, 1, 0.25}}), Shape(Cylinder{0.5, 0.25}),
        Shape(Compound{{{Box{{0.2, 0.2, 0.25}}, {-0.2, 0, 0}}, {Box{{0.2, 0.2, 0.25}}, {0.2, 0, 0}}}})}) {
    Fall fall(gate);
    World alone;
    const BodyId twin = alone.add_body({.shape = Sphere{0.1}, .position = {0, 0, 2}});
    std::vector<std::pair<bool, double>> events;
    for (int step = 0; step < 60; ++step) {
      fall.world.step(dt);
      alone.step(dt);
      EXPECT_EQ(fall.world.pose(fall.ball).position, alone.pose(twin).position);
      const double z = fall.world.pose(fall.ball).position.z();
      const bool inside = std::abs(z - 1) <= 0.35;
      EXPECT_EQ(fall.world.bodies_in(fall.sensor), inside ? std::vector{fall.ball} : std::vector<BodyId>{}) << z;
      for (const SensorEvent& event : fall.world.sensor_events()) {
        EXPECT_EQ(event.sensor, fall.sensor);
        EXPECT_EQ(event.body, fall.ball);
        events.emplace_back(event.entered, z);
      }
    }
    ASSERT_EQ(events.size(), 2u);
    EXPECT_TRUE(events[0].first);
    EXPECT_FALSE(events[1].first);
  }
}

TEST(Sensors, ThatAreCarriedAlongNoticeWhatTheyPass) {
  World world({.gravity = Vector3::Zero()});
  const BodyId cart = world.add_body({.shape = Box{}, .velocity = {2, 0, 0}, .filter = {.mask = 0}});
  const BodyId feeler = world.add_body(
      {.shape = Sphere{0.2}, .position = {1, 0, 0}, .velocity = {2, 0, 0}, .density = 1, .sensor = true});
  world.add_joint({.kind = FixedJoint{}, .first = cart, .second = feeler, .frame_first = {{1, 0, 0}}});
  const BodyId post = world.add_body({.type = BodyType::Kinematic, .shape = Sphere{0.2}, .position = {3, 0.1, 0}});
  world.add_body({.type = BodyType::Static, .shape = Sphere{0.2}, .position = {2, 0.1, 0}});
  std::vector<SensorEvent> events;
  for (int step = 0; step < 100; ++step) {
    world.step(dt);
    events.insert(events.end(), world.sensor_events().begin(), world.sensor_events().end());
  }
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].body, post);
  EXPECT_TRUE(events[0].entered);
  EXPECT_FALSE(events[1].entered);
}

TEST(Sensors, GoByFiltersOfBodiesAndChildren) {
  World world({.gravity = Vector3::Zero()});
  const BodyId sensor =
      world.add_body({.type = BodyType::Static, .shape = Box{}, .filter = {.category = 1, .mask = 4}, .sensor = true});
  const BodyId wanted = world.add_body({.shape = Sphere{0.2}, .filter = {.category = 4}});
  const BodyId other = world.add_body({.shape = Sphere{0.2}, .position = {0.3, 0, 0}, .filter = {.category = 2}});
  const BodyId half =
      world.add_body({.shape = Compound{{{.shape = Sphere{0.1}, .filter = CollisionFilter{.category = 4}},
                                         {.shape = Sphere{0.1}, .position = {2, 0, 0}}}},
                      .position = {0, 0.3, 0},
                      .filter = {.category = 2}});
  world.add_body({.type = BodyType::Static, .shape = Box{}, .sensor = true});
  world.set_collision_enabled(wanted, other, false);
  world.step(dt);
  EXPECT_EQ(world.bodies_in(sensor), (std::vector{wanted, half}));
  world.set_filter(sensor, {.mask = 2});
  world.step(dt);
  EXPECT_EQ(world.bodies_in(sensor), std::vector{other});
  world.remove_body(other);
  world.step(dt);
  ASSERT_EQ(world.sensor_events().size(), 2u) << "of both sensors";
  EXPECT_EQ(world.sensor_events()[0].sensor, sensor);
  EXPECT_EQ(world.sensor_events()[0].body, other);
  EXPECT_FALSE(world.sensor_events()[0].entered);
  world.remove_body(sensor);
  world.step(dt);
  EXPECT_TRUE(world.sensor_events().empty());
}

TEST(Sensors, NoticeSleepersAndDoNotWakeThem) {
  World world({.settings = {.sleeping = true}});
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{}});
  const BodyId box = world.add_body({.shape = Box{}, .position = {0, 0, 0.5}});
  for (int step = 0; step < 120; ++step) world.step(dt);
  ASSERT_TRUE(world.is_asleep(box));
  const BodyId sensor = world.add_body({.type = BodyType::Kinematic,
                                        .shape = Sphere{0.2},
                                        .position = {2, 0, 0.5},
                                        .velocity = {-1, 0, 0},
                                        .sensor = true});
  int entered = 0;
  for (int step = 0; step < 120; ++step) {
    world.step(dt);
    for (const SensorEvent& event : world.sensor_events()) entered += event.entered ? 1 : 0;
  }
  EXPECT_EQ(entered, 1);
  EXPECT_EQ(world.bodies_in(sensor), std::vector{box});
  EXPECT_TRUE(world.is_asleep(box));
}

TEST(Sensors, AreFoundByQueriesThatAskForThem) {
  const Fall fall;
  const Ray down{.origin = {0.5, 0, 3}};
  const Queries queries(fall.world);
  EXPECT_FALSE(queries.cast_ray(down));
  const auto hit = queries.cast_ray(down, {.sensors = true});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->body, fall.sensor);
  EXPECT_NEAR(hit->distance, 1.75, 1e-12);
}

TEST(Sensors, AreSolids) {
  World world;
  for (const Shape& shape : {Shape(HalfSpace{}), Shape(HeightField(2, 2, 1, 1, {0, 0, 0, 0}))}) {
    try {
      world.add_body({.type = BodyType::Static, .shape = shape, .sensor = true});
      ADD_FAILURE() << "it was taken";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("on a sensor; expected a solid"), std::string::npos) << error.what();
    }
  }
  const BodyId body = world.add_body({});
  EXPECT_THROW(world.bodies_in(body), Error);
}

}  // namespace
}  // namespace atl
