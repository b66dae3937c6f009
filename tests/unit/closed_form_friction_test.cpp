// The measures of the scenes with friction.

#include <array>
#include <cmath>
#include <numbers>

#include "support/closed_form_run.h"

namespace atl::test {
namespace {

constexpr double g = 9.81;

/// Body `first` and those after it, moved along their velocities by a common distance (m) at a common speed (m/s).
void move_on(std::vector<BodyState>& states, std::size_t first, double distance, double speed) {
  for (std::size_t i = first; i < states.size(); ++i) {
    const Vector3 direction = states[i].velocity.normalized();
    states[i].pose.position += distance * direction;
    states[i].velocity = speed * direction;
  }
}

TEST(ClosedForm, SlidingBlocks) {
  const Scene scene = load_scene("sliding-blocks:speed=4,friction=0.25,headings=12");
  // v^2 = v0^2 - 2 mu g x, turned into x by the mean speed.
  const Motion motion = [](double t, std::vector<BodyState>& states) {
    const double speed = std::max(0.0, 4 - 0.25 * g * t);
    move_on(states, 1, (16 - speed * speed) / (2 * 0.25 * g), speed);
  };
  expect_exact(scene, motion);
  const double path = 16 / (2 * 0.25 * g);
  const Errors errors = errors_of(
      scene,
      [&](double t, std::vector<BodyState>& states) {
        motion(t, states);
        states[4].pose.position += Vector3(-0.01 * path, 0.02 * path, 0);  // heading 90 degrees
      },
      scene.dt);
  EXPECT_NEAR(errors.at("lateral_drift"), 0.01, 1e-9);
  EXPECT_NEAR(errors.at("distance_error"), 0.02, 1e-9);
  EXPECT_NEAR(errors.at("analytic_error"), std::hypot(0.01, 0.02), 1e-9);
}

TEST(ClosedForm, Incline) {
  const Scene scene = load_scene("incline:angle=0.4");
  const std::array ratios = {0.5, 0.8, 0.95, 1.05, 1.5, 2.0};
  const Vector3 down(std::cos(0.4), 0, -std::sin(0.4));
  const Motion motion = [&](double t, std::vector<BodyState>& states) {
    for (std::size_t i = 0; i < ratios.size(); ++i) {
      const double acceleration = g * std::sin(0.4) * std::max(0.0, 1 - 1 / ratios[i]);
      states[i + 1].pose.position += acceleration * t * t / 2 * down;
    }
  };
  expect_exact(scene, motion);
  const double way = g * std::sin(0.4) * 4.5;
  const Errors errors = errors_of(
      scene,
      [&](double t, std::vector<BodyState>& states) {
        motion(t, states);
        states[3].pose.position += 0.02 * way * t / 3 * down;
        states[4].pose.position.y() += 0.03 * way;
        states[5].pose.position += Vector3(std::sin(0.4), 0, std::cos(0.4));  // off the plane is no sliding
      },
      scene.dt);
  EXPECT_NEAR(errors.at("hold_error"), 0.02, 1e-9);
  EXPECT_NEAR(errors.at("slide_error"), 0.03, 1e-9);
}

TEST(ClosedForm, InclineSphere) {
  const Scene scene = load_scene("incline-sphere:angle=0.5");
  const std::array ratios = {0.3, 0.6, 0.9, 1.1, 1.5, 3.0};
  const Vector3 down(std::cos(0.5), 0, -std::sin(0.5));
  const Motion motion = [&](double t, std::vector<BodyState>& states) {
    for (std::size_t i = 0; i < ratios.size(); ++i) {
      // Friction is what rolling needs, 2/7 of the pull, or what there is.
      const double friction = 2.0 / 7 * g * std::sin(0.5) * std::min(1.0, 1 / ratios[i]);
      states[i + 1].pose.position += (g * std::sin(0.5) - friction) * t * t / 2 * down;
      states[i + 1].angular_velocity.y() = friction * 0.5 / (0.4 * 0.25) * t;
    }
  };
  expect_exact(scene, motion);
  const Errors errors = errors_of(
      scene,
      [&](double t, std::vector<BodyState>& states) {
        motion(t, states);
        states[6].angular_velocity *= 0.9;
      },
      scene.dt);
  EXPECT_LT(errors.at("position_error"), exact);
  EXPECT_NEAR(errors.at("spin_error"), 0.1 * 2.5 * 2 / 7 / 3, 1e-9) << "of the spin that friction gives it";
}

TEST(ClosedForm, RollingSphere) {
  const Scene scene = load_scene("rolling-sphere");
  const double rolling = 2.0 * 7 / (7 * 0.3 * g);
  const Motion motion = [&](double t, std::vector<BodyState>& states) {
    const double slid = std::min(t, rolling);
    const double speed = 7 - 0.3 * g * slid;
    const double distance = (49 - speed * speed) / (2 * 0.3 * g) + 5 * (t - slid);
    for (std::size_t i = 1; i < states.size(); ++i) {
      // The impulse that slowed the sphere also turns it: I w = m r (v0 - v).
      const Vector3 direction = states[i].velocity / 7;
      states[i].angular_velocity = Vector3::UnitZ().cross(direction) * (7 - speed) * 0.5 / (0.4 * 0.25);
    }
    move_on(states, 1, distance, speed);
  };
  expect_exact(scene, motion);
  const Errors errors = errors_of(
      scene,
      [&](double t, std::vector<BodyState>& states) {
        motion(t, states);
        states[2].velocity *= 1.01;
      },
      scene.dt);
  EXPECT_LT(errors.at("analytic_error"), exact);
  EXPECT_NEAR(errors.at("speed_error"), 0.01, 1e-3);
}

TEST(ClosedForm, RollingResistance) {
  const Scene scene = load_scene("rolling-resistance:speed=3,rolling_friction=0.1,headings=12");
  // The kinetic energy, 7/10 m v^2, is spent at rho m g / r a metre.
  const double deceleration = 0.1 * g / 0.5 * 5 / 7;
  const Motion motion = [&](double t, std::vector<BodyState>& states) {
    const double speed = std::max(0.0, 3 - deceleration * t);
    for (std::size_t i = 1; i < states.size(); ++i) states[i].angular_velocity *= speed / 3;
    move_on(states, 1, (9 - speed * speed) / (2 * deceleration), speed);
  };
  expect_exact(scene, motion);
  const double path = 9 / (2 * deceleration);
  const Errors errors = errors_of(
      scene,
      [&](double t, std::vector<BodyState>& states) {
        motion(t, states);
        states[4].pose.position += Vector3(-0.01 * path, 0.02 * path, 0);  // heading 90 degrees
        states[5].angular_velocity *= 0.9;
        states[6].velocity *= 1.2;
      },
      scene.dt);
  EXPECT_NEAR(errors.at("lateral_drift"), 0.01, 1e-9);
  EXPECT_NEAR(errors.at("analytic_error"), std::hypot(0.01, 0.02), 1e-9);
  EXPECT_NEAR(errors.at("spin_error"), 0.1, 2e-3) << "in the first step";
  EXPECT_NEAR(errors.at("speed_error"), 0.2, 4e-3);
}

TEST(ClosedForm, Torsion) {
  const Scene scene = load_scene("torsion:spin=2,torsional_friction=0.02");
  // Moments of inertia over mass: 2/5 r^2, and (a^2 + b^2) / 12 of a box.
  const std::array decelerations = {0.02 * g / 0.1, 0.01 * g / 0.1, 0.0, 0.02 * g * 6};
  const Motion motion = [&](double t, std::vector<BodyState>& states) {
    for (std::size_t i = 0; i < decelerations.size(); ++i) {
      const double speed = std::max(0.0, 2 - decelerations[i] * t);
      const double turned = decelerations[i] > 0 ? (4 - speed * speed) / (2 * decelerations[i]) : 2 * t;
      states[i + 1].angular_velocity.z() = speed;
      states[i + 1].pose.orientation = Quaternion(Eigen::AngleAxisd(turned, Vector3::UnitZ()));
    }
  };
  expect_exact(scene, motion, 1e-7);  // an angle from a scalar product of quaternions
  const double duration = 2 / decelerations[0] + 0.5;
  const Errors errors = errors_of(
      scene,
      [&](double t, std::vector<BodyState>& states) {
        motion(t, states);
        states[1].pose.position.x() += 0.005;
        states[3].angular_velocity.y() = 0.3;
        states[4].pose.orientation = states[4].pose.orientation * Quaternion(Eigen::AngleAxisd(0.1, Vector3::UnitX()));
      },
      scene.dt);
  EXPECT_NEAR(errors.at("drift"), 0.01, 1e-9);
  EXPECT_NEAR(errors.at("spin_error"), 0.15, 1e-9);
  EXPECT_NEAR(errors.at("analytic_error"), 0.1 / (2 * duration), 1e-7);
}

TEST(ClosedForm, PushedBox) {
  const Scene scene = load_scene("pushed-box");
  // Newton's law for box and balls together: the force and friction of the ground are all that pushes them.
  const double acceleration = (150 - 0.4 * g * 35) / (10 + 25 * 2.0 / 7);
  const Vector3 direction(std::cos(std::numbers::pi / 6), 0.5, 0);
  const Motion motion = [&](double t, std::vector<BodyState>& states) {
    for (std::size_t i = 1; i < states.size(); ++i) {
      states[i].pose.position += (i == 1 ? 1 : 2.0 / 7) * acceleration * t * t / 2 * direction;
    }
  };
  expect_exact(scene, motion);
  // Balls that go with the box.
  const Errors errors = errors_of(
      scene,
      [&](double t, std::vector<BodyState>& states) {
        for (BodyState& state : states) state.pose.position += acceleration * t * t / 2 * direction;
      },
      scene.dt);
  EXPECT_LT(errors.at("box_error"), exact);
  EXPECT_NEAR(errors.at("ball_error"), 5.0 / 7, 1e-9);
}

}  // namespace
}  // namespace atl::test
