// Multibody benchmarks: mechanisms of several loops, and drives.

#include <atoll/forces.h>

#include <algorithm>
#include <array>

#include "cases.h"
#include "linkages.h"

namespace atl::physics {
namespace {

// J, by which the energy of rods that turn without friction is off, at most, in ten seconds.
double energy_drift(World& world, const Rods& rods, const Resolution& at) {
  const double start = rods.energy();
  double worst = 0;
  run(world, at, 10, [&](double) { worst = std::max(worst, std::abs(rods.energy() - start)); });
  return worst;
}

// Square windows side by side, pushed over at 1 m/s: all rods come to lie in a line, where the mechanism could fold
// another way, twice a turn.
double windows(const Resolution& at, int count) {
  World world = mechanism_world(at, g);
  Rods rods(world);
  const BodyId floor = add_floor(world);
  std::vector<BodyId> posts;
  for (int i = 0; i <= count; ++i) {
    posts.push_back(rods.add({1.0 * i, 0, 0}, {1.0 * i, 0, 1}, {0.5, 0, 0}));
    world.set_velocity(posts.back(), {0.5, 0, 0}, {0, 1, 0});
  }
  for (int i = 0; i <= count; ++i) {
    add_hinge(world, floor, posts[static_cast<std::size_t>(i)], {1.0 * i, 0, 0}, Vector3::UnitY());
    if (i == count) break;
    const BodyId beam = rods.add({1.0 * i, 0, 1}, {1.0 * i + 1, 0, 1}, {1, 0, 0});
    add_hinge(world, posts[static_cast<std::size_t>(i)], beam, {1.0 * i, 0, 1}, Vector3::UnitY());
    add_hinge(world, beam, posts[static_cast<std::size_t>(i) + 1], {1.0 * i + 1, 0, 1}, Vector3::UnitY());
  }
  return energy_drift(world, rods, at);
}

// Bricard's: five rods along the edges of a cube and the ground, six hinges, each across both of its rods. By counting
// rows it could not move.
double bricard(const Resolution& at) {
  World world = mechanism_world(at, g);
  Rods rods(world);
  const BodyId floor = add_floor(world);
  const std::array<Vector3, 6> corners = {Vector3(0, 0, 0),  Vector3(1, 0, 0),  Vector3(1, 0, -1),
                                          Vector3(1, 1, -1), Vector3(0, 1, -1), Vector3(0, 1, 0)};
  std::array<BodyId, 6> links;
  for (std::size_t i = 0; i < 5; ++i) links[i] = rods.add(corners[i], corners[i + 1]);
  links[5] = floor;
  for (std::size_t i = 0; i < 6; ++i) {
    const Vector3 before = corners[i] - corners[(i + 5) % 6];
    const Vector3 after = corners[(i + 1) % 6] - corners[i];
    add_hinge(world, links[(i + 5) % 6], links[i], corners[i], before.cross(after));
  }
  return energy_drift(world, rods, at);
}

// Andrews' squeezer: seven bodies in a plane, a spring and a torque. rad, by which its motor has turned after 0.03 s.
double squeezer(const Resolution& at) {
  World world = mechanism_world(at, 0);
  const double beta = -0.0617138900142764496, theta = 0, gamma = 0.455279819163070380, phi = 0.222668390165885885,
               delta = 0.487364979543842550, omega = -0.222668390165885885, epsilon = 1.23054744454982119;
  const double rr = 0.007, d = 0.028, da = 0.0115, ra = 0.00092, sa = 0.01874, sb = 0.01043, sc = 0.018, sd = 0.02,
               e = 0.02, ea = 0.01421, zt = 0.04, ta = 0.02308, tb = 0.00916, u = 0.04, ua = 0.01228, ub = 0.00449,
               zf = 0.02, fa = 0.01421;
  const Vector3 a(-0.06934, -0.00227, 0), b(-0.03635, 0.03273, 0), c(0.014, 0.072, 0);
  const auto along = [](double angle) { return Vector3(std::cos(angle), std::sin(angle), 0); };
  const auto across = [](double angle) { return Vector3(std::sin(angle), -std::cos(angle), 0); };
  const auto add = [&](double mass, double moment, const Vector3& centre, double angle) {
    return world.add_body({.shape = Sphere{0.001},
                           .position = centre,
                           .orientation = turn_about(Vector3::UnitZ(), angle),
                           .mass = mass,
                           .inertia = Matrix3(moment * Matrix3::Identity()),
                           .filter = no_contact});
  };
  const BodyId floor = world.add_body({.type = BodyType::Static, .shape = Sphere{0.001}, .filter = no_contact});
  const BodyId k1 = add(0.04325, 2.194e-6, ra * along(beta), beta);
  const BodyId k2 = add(0.00365, 4.410e-7, rr * along(beta) - da * along(beta + theta), beta + theta);
  const BodyId k3 = add(0.02373, 5.255e-6, b + sa * across(gamma) + sb * along(gamma), gamma);
  const BodyId k4 = add(0.00706, 5.667e-7, a + zt * along(delta) + (e - ea) * across(phi + delta), phi + delta);
  const BodyId k5 = add(0.07050, 1.169e-5, a + ta * across(delta) - tb * along(delta), delta);
  const BodyId k6 =
      add(0.00706, 5.667e-7, a + u * across(epsilon) + (zf - fa) * along(omega + epsilon), omega + epsilon);
  const BodyId k7 = add(0.05498, 1.912e-5, a + ua * across(epsilon) - ub * along(epsilon), epsilon);
  const Vector3 meeting = rr * along(beta) - d * along(beta + theta), z = Vector3::UnitZ();
  add_hinge(world, floor, k1, Vector3::Zero(), z);
  add_hinge(world, k1, k2, rr * along(beta), z);
  for (const BodyId arm : {k3, k4, k6}) add_hinge(world, k2, arm, meeting, z);
  add_hinge(world, floor, k3, b, z);
  add_hinge(world, k4, k5, a + zt * along(delta), z);
  add_hinge(world, floor, k5, a, z);
  add_hinge(world, k6, k7, a + u * across(epsilon), z);
  add_hinge(world, floor, k7, a, z);
  const Vector3 pulled = b + sd * along(gamma) + sc * across(gamma);
  const Pose of_k3 = world.pose(k3);
  world.add_joint({.kind = DistanceJoint{{.range = {}, .spring = JointSpring{.rest = 0.07785, .stiffness = 4530}}},
                   .first = floor,
                   .second = k3,
                   .frame_first = {.position = c},
                   .frame_second = {.position = of_k3.orientation.conjugate() * (pulled - of_k3.position)}});
  double turned = beta;
  const auto angle = [&] {
    const Vector3 x = world.pose(k1).orientation * Vector3::UnitX();
    return std::atan2(x.y(), x.x());
  };
  const int steps = static_cast<int>(std::lround(0.03 / at.dt));
  for (int i = 0; i < steps; ++i) {
    world.apply_force(k1, Vector3::Zero(), {0, 0, 0.033});
    world.step(at.dt);
    turned += std::remainder(angle() - turned, 2 * pi);
  }
  return turned;
}

// A governor: two arms of 1 m with balls of 5 kg at their ends, hinged to a shaft that turns freely, lift a sleeve of 1
// kg by stiff springs and dampers from the middle of each. The IFToMM benchmark A05 has arms of some inertia too.
struct Governor {
  static constexpr double ball = 5, ball_moment = 0.05, sleeve = 1, shaft_moment = 0.2, sleeve_moment = 0.01,
                          stiffness = 8e5, damping = 4e4, start = pi / 6, spin = 2 * pi;
  static double level(double lean) { return std::cos(lean); }  // m, of the sleeve below the top, springs at rest
  static constexpr double rest = 0.5;                          // m, of springs
};

// m: how far the sleeve is off Lagrange's equations, at most, in 5 s.
double governor(const Resolution& at) {
  using Go = Governor;
  World world = mechanism_world(at, g);
  const Vector3 z = Vector3::UnitZ();
  const BodyId floor = add_floor(world);
  const auto add = [&](double mass, double moment, const Vector3& place, const Vector3& velocity) {
    return world.add_body({.shape = Sphere{0.01},
                           .position = place,
                           .velocity = velocity,
                           .angular_velocity = Go::spin * z,
                           .mass = mass,
                           .inertia = Matrix3(moment * Matrix3::Identity()),
                           .filter = no_contact});
  };
  const BodyId shaft = add(1, Go::shaft_moment, {0, 0, 0}, {0, 0, 0});
  const BodyId sleeve = add(Go::sleeve, Go::sleeve_moment, {0, 0, -Go::level(Go::start)}, {0, 0, 0});
  add_hinge(world, floor, shaft, {0, 0, 0}, z);
  const Quaternion down = turn_between(Vector3::UnitX(), z);
  world.add_joint({.kind = SliderJoint{},
                   .first = shaft,
                   .second = sleeve,
                   .frame_first = {world.pose(sleeve).position, down},
                   .frame_second = {{0, 0, 0}, down}});
  for (const double side : {1.0, -1.0}) {
    const Vector3 tip(side * std::sin(Go::start), 0, -std::cos(Go::start));
    const BodyId arm = add(Go::ball, Go::ball_moment, tip, Go::spin * z.cross(tip));
    add_hinge(world, shaft, arm, {0, 0, 0}, Vector3::UnitY());
    world.add_joint(
        {.kind = DistanceJoint{{.range = {},
                                .spring =
                                    JointSpring{.rest = Go::rest, .stiffness = Go::stiffness, .damping = Go::damping}}},
         .first = arm,
         .second = sleeve,
         .frame_first = {.position = -0.5 * tip}});
  }
  // Lean and its rate, what the sleeve is below the top and its rate; the spin is from the angular momentum.
  const auto moment = [](double lean) {
    return 2 * (Go::ball * std::sin(lean) * std::sin(lean) + Go::ball_moment) + Go::shaft_moment + Go::sleeve_moment;
  };
  const double momentum = moment(Go::start) * Go::spin;
  using State = Eigen::Vector4d;
  const auto rates = [&](const State& y) {
    const double s = std::sin(y[0]), c = std::cos(y[0]), spin = momentum / moment(y[0]);
    const double across = 0.5 * s, along = y[2] - 0.5 * c, length = std::hypot(across, along);
    const double lean_part = 0.5 * (across * c + along * s) / length, level_part = along / length;
    const double stretching = lean_part * y[1] + level_part * y[3];
    const double force = Go::stiffness * (length - Go::rest) + Go::damping * stretching;
    const double turning = Go::ball * s * (c * spin * spin - g) - force * lean_part;
    return State(y[1], turning / (Go::ball + Go::ball_moment), y[3], g - 2 * force * level_part / Go::sleeve);
  };
  State y(Go::start, 0, Go::level(Go::start), 0);
  double worst = 0;
  run(world, at, 5, [&](double) {
    y = integrated(y, at.dt, 2e-5, rates);
    worst = std::max(worst, std::abs(-world.pose(sleeve).position.z() - y[2]));
  });
  return worst;
}

// A joint along x whose body of 2 kg starts at rest at 0.
struct Slider {
  World world;
  BodyId body;

  Slider(const Resolution& at, const JointAxis& axis, double gravity = 0)
      : world(mechanism_world(at, 0)), body(world.add_body({.shape = Sphere{0.1}, .mass = 2.0, .filter = no_contact})) {
    world.set_gravity({-gravity, 0, 0});
    const BodyId rail = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}, .filter = no_contact});
    world.add_joint({.kind = SliderJoint{axis}, .first = rail, .second = body});
  }
  double x() const { return world.pose(body).position.x(); }
  double speed() const { return world.velocity(body).x(); }
};

// m, the farthest that a servo's motion to 0.5 m is off a damped oscillation, in 3 s.
double servo_motion(const Resolution& at) {
  constexpr double target = 0.5, stiffness = 200, damping = 4, decay = damping / 4;
  Slider slider(at, {.motor = JointMotor{.max_force = 1e3, .servo = JointServo{target, stiffness, damping}}});
  const double turn = std::sqrt(stiffness / 2 - decay * decay);
  double worst = 0;
  run(slider.world, at, 3, [&](double t) {
    const double x = target * (1 - std::exp(-decay * t) * (std::cos(turn * t) + decay / turn * std::sin(turn * t)));
    worst = std::max(worst, std::abs(slider.x() - x));
  });
  return worst;
}

// m/s, what falls for 1 s with a rotor of 3 kg on its joint.
double armature_fall(const Resolution& at) {
  Slider slider(at, {.armature = 3}, g);
  run(slider.world, at, 1);
  return -slider.speed();
}

// The energy left after ten seconds of bouncing on the end of a range.
double bounces(const Resolution& at) {
  Slider slider(at, {.range = {-1, unlimited, 1}}, g);
  run(slider.world, at, 10);
  return (0.5 * slider.speed() * slider.speed() + g * (slider.x() + 1)) / g;
}

// m, the farthest that a body on a spring by force law is off a damped oscillation, in 10 s.
double law_motion(const Resolution& at) {
  World world = make_world(at, 0);
  const BodyId body = world.add_body({.shape = Sphere{0.1}, .position = {1, 0, 0}, .mass = 2.0});
  constexpr double omega = 2 * pi, decay = 0.1 * omega;
  const ForceLaw law = [&](Forces& forces) {
    forces.add(body, -2 * omega * omega * world.pose(body).position - 4 * decay * world.velocity(body));
  };
  const double turn = std::sqrt(omega * omega - decay * decay);
  double worst = 0;
  for (int i = 1; i <= std::lround(10 / at.dt); ++i) {
    world.step(at.dt, law);
    const double t = i * at.dt;
    const double x = std::exp(-decay * t) * (std::cos(turn * t) + decay / turn * std::sin(turn * t));
    worst = std::max(worst, std::abs(world.pose(body).position.x() - x));
  }
  return worst;
}

}  // namespace

void add_mechanisms(std::vector<PhysicsCase>& cases) {
  cases.push_back({.name = "windows-8",
                   .what = "eight four-bar windows of rods of 1 m, 1 kg, pushed over at 1 m/s: energy off in 10 s",
                   .unit = "J",
                   .source = "conservation; IFToMM multibody benchmark A02",
                   .scale = 21 * g,
                   .measure = [](const Resolution& at) { return windows(at, 8); }});
  cases.push_back({.name = "bricard",
                   .what = "Bricard's mechanism of five rods of 1 m, 1 kg: energy off in 10 s",
                   .unit = "J",
                   .source = "conservation; IFToMM multibody benchmark A04",
                   .scale = 5 * g,
                   .measure = bricard});
  cases.push_back({.name = "squeezer",
                   .what = "Andrews' squeezer: by what its motor has turned after 0.03 s",
                   .unit = "rad",
                   .right = 15.8107711962990,
                   .source = "Hairer and Wanner, Solving ODEs II, VII.7; IFToMM A03",
                   .limit = 0.01,
                   .dt = 1e-4,
                   .measure = squeezer});
  cases.push_back(
      {.name = "governor",
       .what = "a governor with springs of 8e5 N/m and 4e4 N s/m: the farthest that its sleeve is off in 5 s",
       .unit = "m",
       .source = "Lagrange's equations, RK4 at 20 us; after IFToMM multibody benchmark A05",
       .measure = governor});
  cases.push_back({.name = "servo-motion",
                   .what = "2 kg by a servo of 200 N/m and 4 N s/m to 0.5 m: the farthest off in 3 s",
                   .unit = "m",
                   .source = "damped oscillation",
                   .scale = 0.5,
                   .measure = servo_motion});
  cases.push_back({.name = "armature-fall",
                   .what = "2 kg that fall with an armature of 3 kg: speed after 1 s",
                   .unit = "m/s",
                   .right = g * 2 / 5,
                   .source = "m g / (m + a)",
                   .scale = g * 2 / 5,
                   .measure = armature_fall});
  cases.push_back({.name = "range-bounces",
                   .what = "a body that bounces on the end of its range, e = 1: energy left after 10 s",
                   .unit = "",
                   .right = 1,
                   .source = "Newton's law of restitution",
                   .measure = bounces});
  cases.push_back({.name = "force-law",
                   .what = "a spring and damper by force law, 1 Hz, damping ratio 0.1: the farthest off in 10 s",
                   .unit = "m",
                   .source = "damped oscillation",
                   .measure = law_motion});
}

}  // namespace atl::physics
