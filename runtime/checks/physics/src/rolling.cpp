// Round bodies that roll.

#include <algorithm>

#include "cases.h"

namespace atl::physics {
namespace {

// m, to the side after 50 m on level ground. `shape` is round about its z axis.
double aside_of_way(const Resolution& at, const Shape& shape, double radius, double speed) {
  World world = make_world(at);
  add_ground(world);
  const double yaw = 0.3;
  const Vector3 ahead(std::cos(yaw), std::sin(yaw), 0);
  const Vector3 axle = Vector3::UnitZ().cross(ahead);
  Matrix3 frame;
  frame << ahead, -Vector3::UnitZ(), axle;
  const BodyId body = world.add_body({.shape = shape,
                                      .position = {0, 0, radius},
                                      .orientation = Quaternion(frame),
                                      .velocity = speed * ahead,
                                      .angular_velocity = (speed / radius) * axle});
  run(world, at, 50 / speed);
  return std::abs(world.pose(body).position.dot(axle));
}

// A disc that rolls without slip, by its equations of motion about the point of contact.
struct RollingDisc {
  double mass, radius, half_height;
  Vector3 moments;  // about its own axes, z the axle
  Quaternion turn;
  Vector3 spin;
  Vector3 centre;

  // From the centre to the contact; and how it changes.
  Vector3 arm(const Quaternion& q) const {
    const Vector3 a = q * Vector3::UnitZ();
    return -radius * (Vector3::UnitZ() - a.z() * a).normalized() - std::copysign(half_height, a.z()) * a;
  }
  Vector3 arm_rate(const Quaternion& q, const Vector3& w) const {
    const Vector3 a = q * Vector3::UnitZ();
    const Vector3 da = w.cross(a);
    const Vector3 u = Vector3::UnitZ() - a.z() * a;
    const Vector3 du = -da.z() * a - a.z() * da;
    const double n = u.norm();
    return -radius * (du / n - u * (u.dot(du) / (n * n * n))) - std::copysign(half_height, a.z()) * da;
  }
  Vector3 acceleration(const Quaternion& q, const Vector3& w) const {
    const Matrix3 rotation = q.toRotationMatrix();
    const Matrix3 inertia = rotation * moments.asDiagonal() * rotation.transpose();
    const Vector3 r = arm(q);
    const Matrix3 about_contact = inertia + mass * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
    const Vector3 torque = r.cross(mass * (g * Vector3::UnitZ() - w.cross(arm_rate(q, w)))) - w.cross(inertia * w);
    return about_contact.inverse() * torque;
  }
  void advance(double seconds) {
    using State = Eigen::Matrix<double, 10, 1>;
    const State start = (State() << centre, turn.coeffs(), spin).finished();
    const State end = integrated(start, seconds, 5e-4, [&](const State& y) {
      const Quaternion q = Quaternion(y.segment<4>(3)).normalized();
      const Vector3 w = y.tail<3>();
      const Quaternion turning = Quaternion(0, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z()) * q;
      return State((State() << -w.cross(arm(q)), turning.coeffs(), acceleration(q, w)).finished());
    });
    centre = end.head<3>();
    turn = Quaternion(end.segment<4>(3)).normalized();
    spin = end.tail<3>();
  }
  double energy() const {
    const Vector3 own = turn.conjugate() * spin;
    return 0.5 * mass * spin.cross(arm(turn)).squaredNorm() + 0.5 * own.dot(moments.asDiagonal() * own) +
           mass * g * centre.z();
  }
};

struct Coin {
  double radius, half_height, tilt, speed, seconds;
};

struct CoinError {
  double tilt;    // rad, the most
  double energy;  // change over the first, at the end
};

CoinError coin_error(const Resolution& at, const Coin& coin) {
  World world = make_world(at);
  const Material material{.friction = 10};
  add_ground(world, material);
  // Its axle is tilted from y towards the vertical; it rolls along x.
  const Quaternion turn = turn_about(Vector3::UnitX(), pi / 2 - coin.tilt);
  const BodyDef def{.shape = Cylinder{coin.radius, coin.half_height}, .orientation = turn, .material = material};
  const MassProperties mass = body_mass(def);
  RollingDisc disc{mass.mass, coin.radius,     coin.half_height, mass.inertia.diagonal(),
                   turn,      Vector3::Zero(), Vector3::Zero()};
  const Vector3 axle = turn * Vector3::UnitZ();
  disc.spin = (coin.speed / coin.radius) * -axle;
  if ((-disc.spin.cross(disc.arm(turn))).x() < 0) disc.spin = -disc.spin;
  disc.centre = -disc.arm(turn);
  BodyDef placed = def;
  placed.position = disc.centre;
  placed.velocity = -disc.spin.cross(disc.arm(turn));
  placed.angular_velocity = disc.spin;
  const BodyId body = world.add_body(placed);
  const auto energy = [&] {
    return kinetic_energy(world, body, mass.inertia) + mass.mass * g * world.pose(body).position.z();
  };
  const double before = energy();
  CoinError error{0, 0};
  run(world, at, coin.seconds, [&](double) {
    disc.advance(at.dt);
    const double is = std::asin((world.pose(body).orientation * Vector3::UnitZ()).z());
    const double right = std::asin((disc.turn * Vector3::UnitZ()).z());
    error.tilt = std::max(error.tilt, std::abs(is - right));
  });
  error.energy = std::abs(energy() / before - 1);
  return error;
}

// R w over the speed with which a rolling ball hit a wall, right after.
double spin_after_wall(const Resolution& at, double phase) {
  constexpr double radius = 0.1, speed = 4;
  World world = make_world(at);
  add_ground(world, {.friction = 0});
  const Material material{.friction = 1};
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{{-1, 0, 0}, 0}, .material = material});
  const BodyId ball = world.add_body({.shape = Sphere{radius},
                                      .position = {-radius - (3 + phase) * speed * at.dt, 0, radius},
                                      .velocity = {speed, 0, 0},
                                      .angular_velocity = {0, speed / radius, 0},
                                      .material = material});
  double result = 1;
  run(world, at, 8 * at.dt, [&](double) { result = std::abs(world.angular_velocity(ball).y()) * radius / speed; });
  return result;
}

// m/s, after 5 s, of two wheels on an axle, one body, that roll at 2 m/s.
double speed_of_wheels(const Resolution& at) {
  World world = make_world(at);
  add_ground(world);
  const double radius = 0.5, speed = 2;
  const Quaternion across = turn_about(Vector3::UnitX(), pi / 2);
  const Compound wheels{{{Cylinder{radius, 0.1}, {0, -1, 0}, across},
                         {Cylinder{radius, 0.1}, {0, 1, 0}, across},
                         {Box{{0.05, 1, 0.05}}}}};
  const BodyId body = world.add_body({.shape = wheels,
                                      .position = {0, 0, radius},
                                      .velocity = {speed, 0, 0},
                                      .angular_velocity = {0, speed / radius, 0}});
  run(world, at, 5);
  return world.velocity(body).x();
}

// How far a ball with its weight below its middle swings, of how far at first, after ten swings.
double tenth_swing(const Resolution& at) {
  World world = make_world(at);
  const Material material{.friction = 1};
  add_ground(world, material);
  const double radius = 0.5, mass = 3, depth = 0.1, inertia = 0.25, lean = 0.1;
  const BodyId body = world.add_body({.shape = Sphere{radius},
                                      .position = {0, 0, radius},
                                      .orientation = turn_about(Vector3::UnitY(), lean),
                                      .mass = mass,
                                      .inertia = Matrix3(inertia * Matrix3::Identity()),
                                      .centre_of_mass = Vector3(0, 0, -depth),
                                      .material = material});
  const double rate = std::sqrt(mass * g * depth / (inertia + mass * (radius - depth) * (radius - depth)));
  run(world, at, 10 * 2 * pi / rate);
  const Vector3 up = world.pose(body).orientation * Vector3::UnitZ();
  return std::hypot(std::atan2(up.x(), up.z()), world.angular_velocity(body).y() / rate) / lean;
}

}  // namespace

void add_rolling(std::vector<PhysicsCase>& cases) {
  const auto rolls = [&](const char* name, const Shape& shape, double radius, double dt) {
    cases.push_back({.name = std::string("roll-") + name,
                     .what = std::string("a ") + name + " that rolls 50 m at 5 m/s: how far aside it gets",
                     .unit = "m",
                     .source = "symmetry",
                     .limit = 1e-3,
                     .dt = dt,
                     .measure = [=](const Resolution& at) { return aside_of_way(at, shape, radius, 5); }});
  };
  rolls("cylinder", Cylinder{0.5, 0.5}, 0.5, 1.0 / 60);
  rolls("capsule", Capsule{0.5, 0.5}, 0.5, 1.0 / 60);
  rolls("disc", Cylinder{0.5, 0.02}, 0.5, 1.0 / 240);
  cases.push_back({.name = "roll-wheels",
                   .what = "wheels on an axle, one compound, that roll at 2 m/s for 5 s: their speed",
                   .unit = "m/s",
                   .right = 2,
                   .source = "conservation",
                   .scale = 2,
                   .limit = 1e-3,
                   .measure = &speed_of_wheels});
  cases.push_back(
      {.name = "loaded-ball",
       .what = "a ball with its weight below its middle that rolls to and fro: its tenth swing over the first",
       .unit = "",
       .right = 1,
       .source = "conservation",
       .measure = &tenth_swing});
  // The critical speed of a thin disc: sqrt(g R / 3).
  const auto coin_tilts = [&](const char* name, double limit, double dt) {
    cases.push_back(
        {.name = name,
         .what = "a coin of 1 m radius that rolls at twice its critical speed, 0.3 rad tilted, 3 s: its tilt",
         .unit = "rad",
         .source = "equations of rolling, RK4 at 0.5 ms",
         .limit = limit,
         .dt = dt,
         .measure = [](const Resolution& at) {
           return coin_error(at, {1, 0.02, 0.3, 2 * std::sqrt(g / 3), 3}).tilt;
         }});
  };
  coin_tilts("coin-tilt", 0.01, 1.0 / 60);
  coin_tilts("coin-tilt-240", 0.005, 1.0 / 240);
  cases.push_back({.name = "coin-energy",
                   .what = "a thin coin of 0.1 m radius, 25 degrees, 3 s: change of its energy",
                   .unit = "",
                   .source = "conservation",
                   .dt = 1.0 / 240,
                   .measure = [](const Resolution& at) {
                     return coin_error(at, {0.1, 0.001, 25 * pi / 180, 3 * std::sqrt(g * 0.1 / 3), 3}).energy;
                   }});
  cases.push_back({.name = "rolling-impact",
                   .what = "a rolling ball of 0.1 m that hits a wall at 4 m/s, friction 1: R w / v after, worst of 8 "
                           "places in the step",
                   .unit = "",
                   .right = 2.0 / 7,
                   .source = "it rolls up the wall: 2/7",
                   .scale = 2.0 / 7,
                   .measure = [](const Resolution& at) {
                     double worst = 2.0 / 7;
                     for (int i = 0; i < 8; ++i) {
                       const double value = spin_after_wall(at, i / 8.0);
                       if (std::abs(value - 2.0 / 7) > std::abs(worst - 2.0 / 7)) worst = value;
                     }
                     return worst;
                   }});
}

}  // namespace atl::physics
