// The measures of the scenes with impacts, and of the blocks on their edges.

#include <array>
#include <cmath>

#include "support/closed_form_run.h"

namespace atl::test {
namespace {

/// Height and speed of a ball that is dropped from a height (m) and bounces.
std::pair<double, double> bounced(double height, double restitution, double t) {
  double speed = 0, up = height;
  for (;;) {
    const double lands = (speed + std::sqrt(speed * speed + 2 * g * up)) / g;
    if (t < lands) return {up + speed * t - g * t * t / 2, speed - g * t};
    t -= lands;
    speed = restitution * std::sqrt(speed * speed + 2 * g * up);
    up = 0;
  }
}

Motion bouncing(double height, double restitution) {
  return [=](double t, std::vector<BodyState>& states) {
    const auto [up, speed] = bounced(height, restitution, t);
    states[1].pose.position.z() = 0.5 + up;
    states[1].velocity.z() = speed;
  };
}

TEST(ClosedForm, BouncingBall) {
  for (const double restitution : {0.5, 0.7, 0.9, 1.0}) {
    const Scene scene = load_scene("bouncing-ball:restitution=" + std::to_string(restitution));
    expect_exact(scene, bouncing(5, restitution));
  }
  const Scene scene = load_scene("bouncing-ball");
  const Errors errors = errors_of(scene, bouncing(5, 0.71), scene.dt);
  EXPECT_NEAR(errors.at("analytic_error"), 0.71 * 0.71 - 0.7 * 0.7, 1e-9);
  EXPECT_NEAR(errors.at("bounce_error"), 0.01 / 0.7, 1e-9);
}

TEST(ClosedForm, ElasticBall) {
  const Scene scene = load_scene("elastic-ball");
  expect_exact(scene, bouncing(2, 1));
  // 1% of the speed is lost each time: after 15 impacts the highest is 0.99^30 of the start.
  const Errors errors = errors_of(scene, bouncing(2, 0.99), scene.dt);
  EXPECT_LT(errors.at("energy_gain"), exact);
  EXPECT_NEAR(errors.at("energy_loss"), 1 - std::pow(0.99, 30), 0.03);
  EXPECT_GT(errors_of(scene, bouncing(2, 1.001), scene.dt).at("energy_gain"), 0.02);
}

/// Exchanges momentum between two spheres without loss, along a normal.
void collide(BodyState& a, BodyState& b, double mass_a, double mass_b, const Vector3& normal) {
  const double impulse = 2 / (1 / mass_a + 1 / mass_b) * (a.velocity - b.velocity).dot(normal);
  a.velocity -= impulse / mass_a * normal;
  b.velocity += impulse / mass_b * normal;
}

TEST(ClosedForm, ElasticPair) {
  const Scene scene = load_scene("elastic-pair:speed=3,ratio=5,offset=0.3");
  const double lost = 1e-3;
  for (const double keep : {1.0, 1 - lost}) {
    const Motion motion = [&](double t, std::vector<BodyState>& states) {
      for (std::size_t i = 0; i < states.size(); i += 2) {
        // Checks the positions at the impact; each pair touches a little later than the one before.
        const double touch = 0.5 + 0.0037 * static_cast<double>(i / 2);
        if (t < touch) return;
        const Vector3 touching = states[i + 1].pose.position - states[i].pose.position - touch * states[i].velocity;
        ASSERT_NEAR(touching.norm(), 1, 1e-12);
        collide(states[i], states[i + 1], *scene.bodies[i].def.mass, *scene.bodies[i + 1].def.mass, touching);
        states[i + 1].velocity *= keep;
      }
    };
    if (keep == 1) {
      expect_exact(scene, motion);
    } else {
      // The light one that a heavy one hits leaves at 2 * 5 / 6 of its speed.
      const Errors errors = errors_of(scene, motion, scene.dt);
      EXPECT_NEAR(errors.at("head_on_error"), lost * 10 / 6, 1e-9);
      EXPECT_NEAR(errors.at("analytic_error"), lost * 10 / 6, 1e-9);
      EXPECT_GT(errors.at("momentum_error"), lost / 10);
      EXPECT_GT(errors.at("energy_error"), lost / 10);
    }
  }
}

TEST(ClosedForm, Cradle) {
  const Scene scene = load_scene("cradle:count=4,speed=3");
  const std::vector<BodyState> start = starting_states(scene);
  // One collision after the other, each as it comes.
  const Motion motion = [&](double t, std::vector<BodyState>& states) {
    double now = 0;
    for (std::size_t i = 0; i + 1 < states.size(); ++i) {
      const double gap = states[i + 1].pose.position.x() - states[i].pose.position.x() - 1;
      const double meets = now + gap / 3;
      if (t < meets) break;
      states[i].pose.position.x() += gap;
      collide(states[i], states[i + 1], 1, 1, Vector3::UnitX());
      now = meets;
    }
  };
  expect_exact(scene, motion);
  // All of the row takes some of it.
  const Errors errors = errors_of(
      scene,
      [&](double t, std::vector<BodyState>& states) {
        motion(t, states);
        if (t < 0.6) return;
        states[4].velocity.x() -= 0.3;
        states[3].velocity.x() += 0.3;
      },
      scene.dt);
  EXPECT_NEAR(errors.at("last_error"), 0.1, 1e-9);
  EXPECT_NEAR(errors.at("others_error"), 0.1, 1e-9);
  EXPECT_LT(errors.at("momentum_error"), exact);
  EXPECT_NEAR(errors.at("energy_error"), 1 - 0.81 - 0.01, 1e-9);
}

/// A block on its edge in its own terms: m = 1, moments about the edge, one step of Euler's midpoint at a time.
struct Tilting {
  double half_width, half_height, push;  // m, m, N/kg
  double tilt = 0, rate = 0;

  double acceleration(double at) const {
    const double x = -half_width * std::cos(at) + half_height * std::sin(at);  // of the centre from the edge
    const double z = half_width * std::sin(at) + half_height * std::cos(at);
    return (push * z + g * x) / (4.0 / 3 * (half_width * half_width + half_height * half_height));
  }
  void step(double h) {
    const double middle = tilt + h / 2 * rate, at_middle = rate + h / 2 * acceleration(tilt);
    tilt += h * at_middle;
    rate += h * acceleration(middle);
  }
};

BodyState tilted(double tilt, double rate, const BodyState& from) {
  BodyState state = from;
  state.pose.orientation = Quaternion(Eigen::AngleAxisd(tilt, Vector3::UnitY()));
  state.angular_velocity = {0, rate, 0};
  return state;
}

TEST(ClosedForm, TippingBlock) {
  const Scene scene = load_scene("tipping-block:slenderness=4");
  const std::array ratios = {0.5, 0.9, 1.1, 1.3, 1.6};
  std::array<Tilting, 5> blocks;
  const auto restart = [&] {
    for (std::size_t i = 0; i < ratios.size(); ++i) blocks[i] = {0.25, 1, ratios[i] * g / 4};
  };
  double now = 0, late = 0;
  const Motion motion = [&](double t, std::vector<BodyState>& states) {
    const int count = static_cast<int>(std::ceil((t - now) / 1e-5));
    for (std::size_t i = 2; i < ratios.size(); ++i) {
      for (int k = 0; k < count; ++k) blocks[i].step((t - now) / count);
      states[i + 1] = tilted(blocks[i].tilt * (1 + late), blocks[i].rate, states[i + 1]);
    }
    now = t;
  };
  restart();
  for (const auto& [name, error] : errors_of(scene, motion, scene.dt)) EXPECT_LT(error, exact) << name;
  restart();
  now = 0;
  late = 0.01;
  const Errors errors = errors_of(scene, motion, scene.dt);
  EXPECT_NEAR(errors.at("tip_error"), 0.01, 5e-4) << "at a tilt next to the last, 0.5 rad";
  EXPECT_EQ(errors.at("hold_error"), 0);
  const Errors leaning = errors_of(
      scene, [](double, std::vector<BodyState>& states) { states[2] = tilted(-0.01, 0, states[2]); }, scene.dt);
  EXPECT_NEAR(leaning.at("hold_error"), 0.02, 1e-9);
}

/// Rocks from edge to edge; `kept` of the rate at each landing.
Errors rock(const Scene& scene, double kept, double dt) {
  const auto measure = scene.closed_form->measure();
  const Vector3 half = std::get<Box>(scene.bodies[1].def.shape).half_extents;
  Tilting block = {half.x(), half.z(), 0};
  block.tilt = 2 * std::atan2(scene.bodies[1].def.orientation.y(), scene.bodies[1].def.orientation.w());
  double side = 1;
  for (int step = 1; step * dt < scene.steps * scene.dt * (1 + 1e-12); ++step) {
    const int count = static_cast<int>(std::ceil(dt / 1e-5));
    for (int k = 0; k < count; ++k) {
      block.step(dt / count);
      if (block.tilt < 0) {  // on to the other edge
        side = -side;
        block.tilt = -block.tilt;
        block.rate *= -kept;
      }
    }
    std::vector<BodyState> states = starting_states(scene);
    states[1] = tilted(side * block.tilt, side * block.rate, states[1]);
    measure->observe(step * dt, states, {});
  }
  return by_name(measure->errors());
}

TEST(ClosedForm, RockingBlock) {
  const Scene scene = load_scene("rocking-block");
  const double kept = 1 - 1.5 / 17;  // sin^2 of the slenderness is 1 / (1 + 4^2)
  // The times of peaks are read off the rate as a straight line between two steps.
  for (const double dt : sampling) {
    const Errors errors = rock(scene, kept, dt);
    EXPECT_LT(errors.at("peak_error"), 5e-4) << dt << ": the landings are found to 1e-5 s";
    EXPECT_LT(errors.at("time_error"), 5e-4 + 0.1 * dt * dt) << dt;
  }
  const Errors lively = rock(scene, 1, scene.dt);
  EXPECT_GT(lively.at("peak_error"), 0.3);
  EXPECT_GT(lively.at("time_error"), 0.1);
  EXPECT_GT(rock(scene, kept + 0.01, scene.dt).at("peak_error"), 5e-3);
}

}  // namespace
}  // namespace atl::test
