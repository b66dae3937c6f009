// Pendulums and gyroscopes: mechanisms of a few bodies whose equations of motion are short.

#include <algorithm>

#include "cases.h"
#include "linkages.h"

namespace atl::physics {
namespace {

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

// Two rods of 1 m and 1 kg that hang one on the other, and what acts where they join.
struct Elbow {
  double armature = 0;   // kg m^2
  double stiffness = 0;  // N m
  double damping = 0;    // N m s
  double rest = 0;       // rad, of the bend as it starts

  // Angles from straight down, and their rates.
  Eigen::Vector4d rates(const Eigen::Vector4d& y) const {
    const double bend = y[0] - y[1], bending = y[2] - y[3];
    const double coupling = 0.5 * std::cos(bend) - armature;
    Matrix2 mass;
    mass << 4.0 / 3 + armature, coupling, coupling, 1.0 / 3 + armature;
    const double torque = stiffness * (bend - rest) + damping * bending;
    const Vector2 load(-1.5 * g * std::sin(y[0]) - 0.5 * std::sin(bend) * y[3] * y[3] - torque,
                       -0.5 * g * std::sin(y[1]) + 0.5 * std::sin(bend) * y[2] * y[2] + torque);
    const Vector2 acceleration = mass.inverse() * load;
    return {y[2], y[3], acceleration[0], acceleration[1]};
  }
  JointAxis axis() const {
    JointAxis axis{.armature = armature};
    if (stiffness > 0 || damping > 0) axis.spring = JointSpring{.stiffness = stiffness, .damping = damping};
    return axis;
  }
};

Vector3 hanging(double angle) { return {std::sin(angle), 0, -std::cos(angle)}; }

// m, by which the tip of a double pendulum that is let go is off at most.
double elbow_error(const Resolution& at, const Elbow& elbow, const Vector2& start, double seconds) {
  World world = mechanism_world(at, g);
  Rods rods(world);
  const Vector3 middle = hanging(start[0]);
  const BodyId upper = rods.add({0, 0, 0}, middle);
  const BodyId lower = rods.add(middle, middle + hanging(start[1]));
  add_hinge(world, add_floor(world), upper, {0, 0, 0}, Vector3::UnitY());
  add_hinge(world, upper, lower, middle, Vector3::UnitY(), elbow.axis());
  Eigen::Vector4d y(start[0], start[1], 0, 0);
  double worst = 0;
  run(world, at, seconds, [&](double) {
    y = integrated(y, at.dt, 1e-3, [&](const Eigen::Vector4d& state) { return elbow.rates(state); });
    const Pose pose = world.pose(lower);
    const Vector3 tip = pose.position + pose.orientation * Vector3(0.5, 0, 0);
    worst = std::max(worst, (tip - hanging(y[0]) - hanging(y[1])).norm());
  });
  return worst;
}

// rad, by which a rod that is let go a degree from its highest place is off after one way down and up.
double upright_error(const Resolution& at) {
  World world = mechanism_world(at, g);
  Rods rods(world);
  const double start = 179 * pi / 180;
  const BodyId rod = rods.add({0, 0, 0}, hanging(start));
  add_hinge(world, add_floor(world), rod, {0, 0, 0}, Vector3::UnitY());
  Vector2 y(start, 0);
  double worst = 0;
  run(world, at, 3, [&](double) {
    y = integrated(y, at.dt, 1e-3, [&](const Vector2& s) { return Vector2(s[1], -1.5 * g * std::sin(s[0])); });
    worst = std::max(worst, (world.pose(rod).orientation * Vector3::UnitX() - hanging(y[0])).norm());
  });
  return worst;
}

// rad, by which a pendulum stands off what it should on a pivot that shakes fast enough to hold it upright.
double kapitza(const Resolution& at) {
  World world = mechanism_world(at, g);
  Rods rods(world);
  const double reach = 0.05, beat = 150, start = pi - 0.3;
  const auto pivot_speed = [&](double t) { return reach * beat * std::cos(beat * t); };
  const BodyId pivot = world.add_body({.type = BodyType::Kinematic, .shape = Sphere{0.01}, .filter = no_contact});
  // It starts with the pivot's speed.
  const BodyId rod = rods.add({0, 0, 0}, hanging(start), {0, 0, pivot_speed(0)});
  add_hinge(world, pivot, rod, {0, 0, 0}, Vector3::UnitY());
  Eigen::Vector3d y(start, 0, 0);
  double worst = 0;
  for (int i = 0; i < std::lround(2 / at.dt); ++i) {
    const double t = i * at.dt, next = t + at.dt;
    world.set_velocity(pivot, {0, 0, reach * (std::sin(beat * next) - std::sin(beat * t)) / at.dt}, {0, 0, 0});
    world.step(at.dt);
    y = integrated(y, at.dt, 1e-4, [&](const Eigen::Vector3d& s) {
      const double rise = -reach * beat * beat * std::sin(beat * s[2]);
      return Eigen::Vector3d(s[1], -1.5 * (g + rise) * std::sin(s[0]), 1);
    });
    worst = std::max(worst, (world.pose(rod).orientation * Vector3::UnitX() - hanging(y[0])).norm());
  }
  return worst;
}

// m, by which the tip of a Furuta pendulum is off at most in 2 s: an arm that turns freely, with a pendulum across.
double furuta(const Resolution& at) {
  World world = mechanism_world(at, g);
  const double reach = 0.5, arm_moment = 0.05, mass = 0.2, half = 0.3, across = 0.006, along = 1e-4;
  const double lean = 0.5, turning = 1;
  const Vector3 up(0, std::sin(lean), std::cos(lean));
  const Part arm = add_part(world, 1, Vector3::Constant(arm_moment), {}, {0, 0, 0}, {0, 0, turning});
  const Vector3 centre = Vector3(reach, 0, 0) + half * up;
  const Part pendulum = add_part(world, mass, {across, across, along}, {centre, turn_between(Vector3::UnitZ(), up)},
                                 turning * Vector3::UnitZ().cross(centre), {0, 0, turning});
  add_hinge(world, add_floor(world), arm.body, {0, 0, 0}, Vector3::UnitZ());
  add_hinge(world, arm.body, pendulum.body, {reach, 0, 0}, Vector3::UnitX());
  const double about_pivot = mass * half * half + across;
  Eigen::Vector4d y(0, lean, turning, 0);
  double worst = 0;
  run(world, at, 2, [&](double) {
    y = integrated(y, at.dt, 1e-3, [&](const Eigen::Vector4d& state) {
      const double s = std::sin(state[1]), c = std::cos(state[1]);
      const double coupling = mass * reach * half * c;
      Matrix2 inertia;
      inertia << arm_moment + mass * reach * reach + about_pivot * s * s + along * c * c, coupling, coupling,
          about_pivot;
      const double slope = 2 * s * c * (about_pivot - along);
      const Vector2 load(-slope * state[3] * state[2] + mass * reach * half * s * state[3] * state[3],
                         0.5 * slope * state[2] * state[2] + mass * g * half * s);
      const Vector2 acceleration = inertia.inverse() * load;
      return Eigen::Vector4d(state[2], state[3], acceleration[0], acceleration[1]);
    });
    const Vector3 out(std::cos(y[0]), std::sin(y[0]), 0), ahead(-out.y(), out.x(), 0);
    const Vector3 right = reach * out + half * (std::sin(y[1]) * ahead + std::cos(y[1]) * Vector3::UnitZ());
    worst = std::max(worst, (world.pose(pendulum.body).position - right).norm());
  });
  return worst;
}

// rad, by which the outer ring of a gyroscope in gimbals is off at most in 10 s.
double gimbals(const Resolution& at) {
  World world = mechanism_world(at, 0);
  const double outer_moment = 0.05, rotor_across = 0.02, rotor_along = 0.03;
  const Vector3 inner_moments(0.01, 0.015, 0.02);
  const double tilt = 0.3, ring_rate = 0.5, tilt_rate = 1, rotor_rate = 50;
  const Quaternion turn = turn_about(Vector3::UnitX(), tilt);
  const Vector3 axle = turn * Vector3::UnitY();
  const Vector3 ring_spin(0, 0, ring_rate), inner_spin = ring_spin + Vector3(tilt_rate, 0, 0);
  const Part outer = add_part(world, 1, Vector3::Constant(outer_moment), {}, {0, 0, 0}, ring_spin);
  const Part inner = add_part(world, 1, inner_moments, {{0, 0, 0}, turn}, {0, 0, 0}, inner_spin);
  const Part rotor = add_part(world, 1, {rotor_across, rotor_along, rotor_across}, {{0, 0, 0}, turn}, {0, 0, 0},
                              inner_spin + rotor_rate * axle);
  add_hinge(world, add_floor(world), outer.body, {0, 0, 0}, Vector3::UnitZ());
  add_hinge(world, outer.body, inner.body, {0, 0, 0}, Vector3::UnitX());
  add_hinge(world, inner.body, rotor.body, {0, 0, 0}, axle);
  const auto about_z = [&](double s, double c) {
    return outer_moment + (rotor_across + inner_moments.z()) * c * c + inner_moments.y() * s * s;
  };
  const double s0 = std::sin(tilt), c0 = std::cos(tilt);
  const double rotor_momentum = rotor_along * (rotor_rate + ring_rate * s0);
  const double momentum = about_z(s0, c0) * ring_rate + rotor_momentum * s0;
  // Angle of the ring, tilt, and the tilt's rate.
  Eigen::Vector3d y(0, tilt, tilt_rate);
  double worst = 0;
  run(world, at, 10, [&](double) {
    y = integrated(y, at.dt, 5e-4, [&](const Eigen::Vector3d& state) {
      const double s = std::sin(state[1]), c = std::cos(state[1]), moment = about_z(s, c);
      const double rate = (momentum - rotor_momentum * s) / moment;
      const double slope = 2 * s * c * (inner_moments.y() - rotor_across - inner_moments.z());
      const double torque = rotor_momentum * c * rate + 0.5 * slope * rate * rate;
      return Eigen::Vector3d(rate, state[2], torque / (rotor_across + inner_moments.x()));
    });
    const Vector3 x = world.pose(outer.body).orientation * Vector3::UnitX();
    worst = std::max(worst, std::abs(std::remainder(std::atan2(x.y(), x.x()) - y[0], 2 * pi)));
  });
  return worst;
}

// A satellite that tumbles with a rotor of 60 rad/s aboard, 100 s: the most that its angular momentum changes, by what
// it was.
double satellite(const Resolution& at) {
  World world = mechanism_world(at, 0);
  const Vector3 spin(0.1, 0.2, 0.05), mount(0.3, 0.1, 0), axle = Vector3(1, 0, 1).normalized();
  const Part bus = add_part(world, 100, {10, 20, 25}, {}, {0, 0, 0}, spin);
  const Part rotor = add_part(world, 5, {0.1, 0.06, 0.06}, {mount, turn_between(Vector3::UnitX(), axle)},
                              spin.cross(mount), spin + 60 * axle);
  add_hinge(world, bus.body, rotor.body, mount, axle);
  const Vector3 before = angular_momentum(world, {bus, rotor});
  double max = 0;
  run(world, at, 100, [&](double) {
    max = std::max(max, (angular_momentum(world, {bus, rotor}) - before).norm() / before.norm());
  });
  return max;
}

// rad/s over torque / damping: how fast a rod turns against a damper that outweighs its inertia, pushed at its centre
// or turned.
double damped_rate(const Resolution& at, bool by_torque) {
  World world = mechanism_world(at, 0);
  const double damping = 200, torque = 20, arm = 0.3;
  const Part rod = add_part(world, 5, Vector3::Constant(1.3), {{arm, 0, 0}});
  const JointId hinge = add_hinge(world, add_floor(world), rod.body, {0, 0, 0}, Vector3::UnitZ(),
                                  {.spring = JointSpring{.stiffness = 0, .damping = damping}});
  double half_way = 0;
  const int steps = static_cast<int>(std::lround(2 / at.dt));
  for (int i = 0; i < steps; ++i) {
    if (i == steps / 2) half_way = world.joint_state(hinge).position[0];
    const Vector3 along = Vector3::UnitZ().cross(world.pose(rod.body).orientation * Vector3::UnitX());
    if (by_torque) world.apply_force(rod.body, {0, 0, 0}, {0, 0, torque});
    if (!by_torque) world.apply_force(rod.body, torque / arm * along, {0, 0, 0});
    world.step(at.dt);
  }
  return (world.joint_state(hinge).position[0] - half_way) / (torque / damping);
}

struct SpentServo {
  static constexpr double moment = 0.1, damping = 200, torque = 150;
  static double right() {
    const double rate = torque / damping, time = 2 * moment / damping;
    return rate * (1 - time * (1 - std::exp(-1 / time)));
  }
};

// rad, that a servo without the force to get anywhere else turns a light rod with an armature in 1 s against a damper.
double spent_servo(const Resolution& at) {
  World world = mechanism_world(at, 0);
  const Part rod = add_part(world, 1, Vector3::Constant(SpentServo::moment), {});
  const JointId hinge = add_hinge(
      world, add_floor(world), rod.body, {0, 0, 0}, Vector3::UnitZ(),
      {.spring = JointSpring{.stiffness = 0, .damping = SpentServo::damping},
       .motor = JointMotor{.max_force = SpentServo::torque, .servo = JointServo{.target = 10, .stiffness = 3500}},
       .armature = SpentServo::moment});
  run(world, at, 1);
  return world.joint_state(hinge).position[0];
}

// The speed that is told of what creeps back against a damper of so many 1/s, over that with which it does.
double reported_speed_share(const Resolution& at, double rate) {
  World world = mechanism_world(at, 0);
  const double stiffness = rate, start = 0.5;  // of 1 kg: it creeps back within a second
  const Part body = add_part(world, 1, {1, 1, 1}, {});
  world.add_joint({.kind = SliderJoint{{.spring = JointSpring{.rest = start, .stiffness = stiffness, .damping = rate}}},
                   .first = add_floor(world),
                   .second = body.body});
  run(world, at, 0.5);
  // The slower of the two rates of an overdamped oscillation.
  const double decay = (rate - std::sqrt(rate * rate - 4 * stiffness)) / 2;
  return world.velocity(body.body).x() / (decay * (start - world.pose(body.body).position.x()));
}

}  // namespace

void add_pendulums(std::vector<PhysicsCase>& cases) {
  cases.push_back({.name = "double-pendulum",
                   .what = "two rods of 1 m and 1 kg that swing one on the other: their tip, farthest off in 10 s",
                   .unit = "m",
                   .source = "Lagrange's equations, RK4 at 1 ms",
                   .measure = [](const Resolution& at) {
                     return elbow_error(at, {}, {0.8, 0.4}, 10);
                   }});
  cases.push_back(
      {.name = "armature-on-base",
       .what = "the same with a rotor of 0.2 kg m^2 and a spring between them: their tip, farthest off in 5 s",
       .unit = "m",
       .source = "Lagrange's equations, RK4 at 1 ms",
       .measure = [](const Resolution& at) {
         return elbow_error(at, {.armature = 0.2, .stiffness = 5, .damping = 0.2, .rest = 0.8}, {1.2, 0.4}, 5);
       }});
  cases.push_back({.name = "upright-pendulum",
                   .what = "a rod let go 1 degree from upright: its direction, farthest off in 3 s",
                   .unit = "rad",
                   .source = "equation of the pendulum, RK4 at 1 ms",
                   .measure = upright_error});
  cases.push_back({.name = "kapitza",
                   .what = "a pendulum held upright by a pivot that shakes by 5 cm at 150 rad/s: farthest off in 2 s",
                   .unit = "rad",
                   .source = "equation of the pendulum, RK4 at 0.1 ms",
                   .dt = 1.0 / 1920,
                   .measure = kapitza});
  cases.push_back({.name = "furuta",
                   .what = "a pendulum on an arm that turns freely: its centre, farthest off in 2 s",
                   .unit = "m",
                   .source = "Lagrange's equations, RK4 at 1 ms",
                   .measure = furuta});
  cases.push_back({.name = "gimbals",
                   .what = "a rotor of 50 rad/s in two gimbals: the angle of the outer, farthest off in 10 s",
                   .unit = "rad",
                   .source = "Routh's equations, RK4 at 0.5 ms",
                   .dt = 1.0 / 240,
                   .measure = gimbals});
  cases.push_back(
      {.name = "satellite",
       .what = "a satellite that tumbles with a rotor of 60 rad/s aboard, 100 s: change of angular momentum",
       .unit = "",
       .source = "conservation",
       .limit = 1e-7,
       .measure = satellite});
  for (const bool by_torque : {false, true}) {
    cases.push_back({.name = std::string("damped-hinge-") + (by_torque ? "torque" : "force"),
                     .what = std::string("a rod against a damper of c/I 114/s, by ") +
                             (by_torque ? "a torque" : "a force at its centre") + ": rate over torque / c",
                     .unit = "",
                     .right = 1,
                     .source = "balance of torques",
                     .measure = [=](const Resolution& at) { return damped_rate(at, by_torque); }});
  }
  cases.push_back({.name = "spent-servo",
                   .what = "a servo of 150 N m, all of it spent on a damper of c/I 1000/s: turned in 1 s",
                   .unit = "rad",
                   .right = SpentServo::right(),
                   .source = "torque / c, after exp(-c t / I)",
                   .scale = SpentServo::right(),
                   .measure = spent_servo});
  for (const double rate : {500.0, 5000.0}) {
    cases.push_back({.name = "reported-speed-" + std::to_string(static_cast<int>(rate)),
                     .what = "what creeps back against a damper of " + std::to_string(static_cast<int>(rate)) +
                             " 1/s: the speed that is told over that of its motion",
                     .unit = "",
                     .right = 1,
                     .source = "damped oscillation",
                     .measure = [=](const Resolution& at) { return reported_speed_share(at, rate); }});
  }
}

}  // namespace atl::physics
