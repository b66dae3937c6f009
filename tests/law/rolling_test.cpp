// Rolling: the lowest point of a round surface stays under its centre as the body turns, wherever the body's centre of
// mass is.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

const Quaternion on_its_side(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitY()));

World plane_world(ContactSolver contacts) {
  World world({.settings = {.contact_solver = contacts, .sleeping = false}});
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .material = {.friction = 1}});
  return world;
}

struct Roller {
  std::string name;
  Shape shape;
};

// Shapes that roll about the x axis with radius 0.5.
std::vector<Roller> rollers() {
  const auto wheel = [](double x) { return CompoundChild{Cylinder{0.5, 0.1}, {x, 0, 0}, on_its_side}; };
  return {{"two balls", Compound{{{Sphere{0.5}, {-1, 0, 0}}, {Sphere{0.5}, {1, 0, 0}}}}},
          {"capsule", Compound{{{Capsule{0.5, 1}, {0, 0, 0}, on_its_side}}}},
          {"cylinder", Compound{{{Cylinder{0.5, 1}, {0, 0, 0}, on_its_side}}}},
          {"wheels", Compound{{wheel(-1), wheel(1), {Box{{1, 0.05, 0.05}}}}}}};
}

// A compound of wheels that a turn put on its side once gained 23% of its speed in 2 s.
TEST(Rolling, IsSteadyWhateverTheShapesFrame) {
  for (const ContactSolver contacts : {ContactSolver::Iterative, ContactSolver::Direct}) {
    for (const double dt : {1.0 / 60, 1.0 / 240}) {
      for (const Roller& roller : rollers()) {
        World world = plane_world(contacts);
        const BodyId body = world.add_body({.shape = roller.shape,
                                            .position = {0, 0, 0.5},
                                            .velocity = {0, 2, 0},
                                            .angular_velocity = {-4, 0, 0},
                                            .material = {.friction = 1}});
        for (int step = 0; step < 5 / dt; ++step) world.step(dt);
        EXPECT_LT((world.velocity(body) - Vector3(0, 2, 0)).norm(), 2e-3) << roller.name << ", dt " << dt;
        EXPECT_LT((world.angular_velocity(body) - Vector3(-4, 0, 0)).norm(), 4e-3) << roller.name << ", dt " << dt;
        EXPECT_NEAR(world.pose(body).position.z(), 0.5, 2e-3) << roller.name << ", dt " << dt;
      }
    }
  }
}

// With its weight at depth d below its middle, what rolls is a pendulum of w^2 = m g d / (I + m (r - d)^2), which keeps
// its energy: the tenth swing is as large as the first, and as long.
void expect_steady_swings(const std::string& name, const Shape& shape, const Quaternion& frame, ContactSolver contacts,
                          double dt) {
  World world = plane_world(contacts);
  const double r = 0.5, m = 3, d = 0.1, inertia = 0.25, start = 0.1;
  const Quaternion tilt(Eigen::AngleAxisd(start, Vector3::UnitX()));
  const BodyId body = world.add_body({.shape = shape,
                                      .position = {0, 0, r},
                                      .orientation = tilt * frame,
                                      .mass = m,
                                      .inertia = Matrix3(inertia * Matrix3::Identity()),
                                      .centre_of_mass = Vector3(frame.conjugate() * Vector3(0, 0, -d)),
                                      .material = {.friction = 1}});
  const double w = std::sqrt(m * 9.81 * d / (inertia + m * (r - d) * (r - d)));
  const double swings = 10;
  for (int step = 0; step < std::lround(swings * 2 * std::numbers::pi / w / dt); ++step) world.step(dt);
  const Vector3 up = world.pose(body).orientation * frame.conjugate() * Vector3::UnitZ();
  const double lean = std::atan2(-up.y(), up.z()), rate = world.angular_velocity(body).x();
  const double max = std::hypot(lean, rate / w);
  EXPECT_NEAR(max / start, 1, 0.01) << name << ", dt " << dt;
  // The phase after 63 rad; the finite width of the swing accounts for some hundredths of the error.
  EXPECT_NEAR(std::atan2(rate / w, lean), 0, 0.1) << name << ", dt " << dt;
}

// A ball of which the weight is off its middle once swung 1.3 times as far with each swing.
TEST(Rolling, OfWhatIsLoadedKeepsItsEnergy) {
  for (const ContactSolver contacts : {ContactSolver::Iterative, ContactSolver::Direct}) {
    for (const double dt : {1.0 / 60, 1.0 / 240}) {
      const Quaternion straight = Quaternion::Identity();
      expect_steady_swings("ball", Sphere{0.5}, straight, contacts, dt);
      expect_steady_swings("cylinder", Cylinder{0.5, 1}, on_its_side, contacts, dt);
      expect_steady_swings("capsule", Capsule{0.5, 1}, on_its_side, contacts, dt);
      expect_steady_swings("child", Compound{{{Cylinder{0.5, 1}, {0, 0, 0}, on_its_side}}}, straight, contacts, dt);
    }
  }
}

// Wheels whose cylinders are turned into their bodies' frames, as robots' are, in all ways to solve them.
TEST(Rolling, OfACartIsSteady) {
  const Quaternion across(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitX()));
  for (const JointSolver joints : {JointSolver::Iterative, JointSolver::Direct}) {
    for (const ContactSolver contacts : {ContactSolver::Iterative, ContactSolver::Direct}) {
      World world({.settings = {.contact_solver = contacts, .joint_solver = joints, .sleeping = false}});
      world.add_body({.type = BodyType::Static, .shape = HalfSpace{}});
      const double r = 0.2, v = 2;
      const BodyId car = world.add_body(
          {.shape = Box{{0.6, 0.3, 0.1}}, .position = {0, 0, r + 0.05}, .velocity = {v, 0, 0}, .mass = 20.0});
      for (const double x : {-0.5, 0.5}) {
        for (const double y : {-0.4, 0.4}) {
          const BodyId wheel = world.add_body({.shape = Compound{{{Cylinder{r, 0.04}, {0, 0, 0}, across}}},
                                               .position = {x, y, r},
                                               .velocity = {v, 0, 0},
                                               .angular_velocity = {0, v / r, 0},
                                               .mass = 1.0});
          world.add_joint(joint_at(world, HingeJoint{}, car, wheel, Vector3(x, y, r), Vector3::UnitY()));
        }
      }
      for (int step = 0; step < 300; ++step) world.step(dt);
      EXPECT_LT((world.velocity(car) - Vector3(v, 0, 0)).norm(), 2e-3);
      EXPECT_NEAR(world.pose(car).position.z(), r + 0.05, 2e-3);
    }
  }
}

// A disc that goes round in a circle without slip, its axis tilted from the vertical: it rolls at `rolls` rad/s about
// its axis, while that goes round at `round`.
struct Circling {
  Cylinder disc;
  double tilt, round, rolls;

  Vector3 axis() const { return {std::sin(tilt), 0, std::cos(tilt)}; }
  Vector3 arm() const { return disc.radius * Vector3(std::cos(tilt), 0, -std::sin(tilt)) - disc.half_height * axis(); }
  Vector3 spin() const { return rolls * axis() - round * std::sin(tilt) * Vector3(std::cos(tilt), 0, -std::sin(tilt)); }
};

// The rate at which it rolls, so that its weight and the change of its angular momentum about the contact agree.
double rolls_at(const Cylinder& disc, double tilt, double round) {
  const double s = std::sin(tilt), c = std::cos(tilt), r = disc.radius, h = disc.half_height;
  const double across = r * r / 4 + h * h / 3, along = r * r / 2;
  const double x = r * c - h * s, z = -r * s - h * c, p = -round * s;
  return (-g * x + z * round * p * h - round * across * p * c) / (round * along * s - z * round * r);
}

struct Motion {
  double tilt;    // rad, off by at most
  double energy;  // at the end, over that before
};

Motion circle(const Circling& of, const Settings& settings, double step, double seconds) {
  World world({.settings = settings});
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .material = {.friction = 1}});
  const BodyDef def{.shape = of.disc,
                    .position = -of.arm().z() * Vector3::UnitZ(),
                    .orientation = Quaternion(Eigen::AngleAxisd(of.tilt, Vector3::UnitY())),
                    .velocity = -of.spin().cross(of.arm()),
                    .angular_velocity = of.spin(),
                    .material = {.friction = 1}};
  const BodyId body = world.add_body(def);
  const MassProperties mass = body_mass(def);
  const auto energy = [&] {
    const Vector3 own = world.pose(body).orientation.conjugate() * world.angular_velocity(body);
    const double moves = world.velocity(body).squaredNorm();
    return 0.5 * mass.mass * moves + 0.5 * own.dot(mass.inertia * own) +
           mass.mass * g * (world.pose(body).position.z() - of.disc.half_height);
  };
  const double before = energy();
  double off = 0;
  for (int i = 0; i < std::lround(seconds / step); ++i) {
    world.step(step);
    off = std::max(off, std::abs(std::acos((world.pose(body).orientation * Vector3::UnitZ()).z()) - of.tilt));
  }
  return {off, energy() / before};
}

// Twice as fast as it needs not to fall over. Contacts that stayed where they were as a step began let it lean by 0.1
// rad more in a second.
TEST(Rolling, OfACoinInACircleIsSteady) {
  const Cylinder coin{0.1, 0.005};
  const double tilt = std::numbers::pi / 2 - 0.3, round = 1.4527;
  const Circling circling{coin, tilt, round, rolls_at(coin, tilt, round)};
  for (const ContactSolver contacts : {ContactSolver::Auto, ContactSolver::Direct}) {
    for (const int substeps : {1, 4}) {
      const Motion at_60 = circle(circling, {.substeps = substeps, .contact_solver = contacts}, 1.0 / 60, 3);
      EXPECT_LT(at_60.tilt, 1e-3) << substeps;
      EXPECT_NEAR(at_60.energy, 1, 5e-4) << substeps;
      const Motion at_240 = circle(circling, {.substeps = substeps, .contact_solver = contacts}, 1.0 / 240, 3);
      EXPECT_LT(at_240.tilt, 1e-4) << substeps;
      EXPECT_NEAR(at_240.energy, 1, 3e-5) << substeps;
    }
  }
}

// Euler's disk loses nothing where nothing rubs. It goes round 12 times in a second, and lay flat after a half.
TEST(Rolling, OfEulersDiskKeepsItsEnergy) {
  const Cylinder disc{0.0375, 0.005};
  const double tilt = 10 * std::numbers::pi / 180, s = std::sin(tilt), c = std::cos(tilt);
  // It rolls on its rim about an axis through its centre, which stays where it is.
  const double r = disc.radius, h = disc.half_height;
  const double across = r * r / 4 + h * h / 3, along = r * r / 2;
  const double round = std::sqrt(g * (r * c - h * s) / (across * s * c - along * s * s * h / r));
  const Circling circling{disc, tilt, round, round * s * h / r};
  for (const ContactSolver contacts : {ContactSolver::Auto, ContactSolver::Direct}) {
    const Motion motion = circle(circling, {.contact_solver = contacts}, 1.0 / 960, 1);
    EXPECT_NEAR(motion.energy, 1, 0.01);
    EXPECT_LT(motion.tilt, 2e-3);
  }
}

// A top whose weight is below the middle of its ball: its momentum about the line from its centre of mass to the
// contact lasts while it slips (Jellett, "A treatise on the theory of friction", 1872), and by RK4 at 10 us 0.9923 of
// its energy is left after 4 s, tilted by 0.037 rad. It turns by 3.3 rad in a step of 1/60 s.
TEST(Rolling, OfATopOnABallKeepsJellettsIntegral) {
  const double r = 0.025, mass = 0.05, moment = 0.4 * mass * r * r, below = 0.15 * r;
  for (const ContactSolver contacts : {ContactSolver::Auto, ContactSolver::Direct}) {
    for (const double step : {1.0 / 60, 1.0 / 240, 1.0 / 960}) {
      World world({.settings = {.contact_solver = contacts}});
      world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .material = {.friction = 0.3}});
      const Quaternion tilted(Eigen::AngleAxisd(0.1, Vector3::UnitY()));
      const BodyId top = world.add_body({.shape = Sphere{r},
                                         .position = {0, 0, r},
                                         .orientation = tilted,
                                         .angular_velocity = tilted * Vector3(0, 0, 200),
                                         .mass = mass,
                                         .inertia = Matrix3(moment * Matrix3::Identity()),
                                         .centre_of_mass = Vector3(0, 0, -below),
                                         .material = {.friction = 0.3}});
      const auto axis = [&] { return Vector3(world.pose(top).orientation * Vector3::UnitZ()); };
      const auto integral = [&] {
        return -moment * world.angular_velocity(top).dot(below * axis() - r * Vector3::UnitZ());
      };
      const auto energy = [&] {
        return 0.5 * mass * world.velocity(top).squaredNorm() +
               0.5 * moment * world.angular_velocity(top).squaredNorm() +
               mass * g * (world.pose(top).position - below * axis()).z();
      };
      const double integral_before = integral(), energy_before = energy();
      run(world, static_cast<int>(std::lround(4 / step)), step);
      EXPECT_NEAR(integral() / integral_before, 1, 1e-4) << step;
      EXPECT_NEAR(energy() / energy_before, 0.9923, 5e-4) << step;
      EXPECT_LT(std::acos(axis().z()), 0.06) << step;
    }
  }
}

}  // namespace
}  // namespace atl::test
