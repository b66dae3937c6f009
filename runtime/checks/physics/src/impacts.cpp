// Bodies that land and bounce.

#include <algorithm>

#include "cases.h"

namespace atl::physics {
namespace {

double aside_of_fall(const Resolution& at, const Shape& shape, double half, double height, Material material = {}) {
  World world = make_world(at);
  add_ground(world);
  const BodyId body = world.add_body({.shape = shape, .position = {0, 0, half + height}, .material = material});
  run(world, at, std::sqrt(2 * height / g) + 1);
  return world.centre_of_mass(body).head<2>().norm();
}

double speed_after_oblique_bounce(const Resolution& at, double restitution) {
  World world = make_world(at, 0);
  const Material material{.friction = 0.1, .restitution = restitution};
  add_ground(world, material);
  const BodyId ball =
      world.add_body({.shape = Sphere{0.5}, .position = {0, 0, 1.5}, .velocity = {3, 0, -4}, .material = material});
  run(world, at, 0.5);
  return world.velocity(ball).x();
}

// Rebound speed of the upper of two elastic balls that fall 1 mm apart, divided by the speed of the fall.
double cannon(const Resolution& at, double ratio) {
  constexpr double fall = 1;
  World world = make_world(at);
  const Material material{.friction = 0, .restitution = 1};
  add_ground(world, material);
  world.add_body({.shape = Sphere{0.5}, .position = {0, 0, 0.5 + fall}, .mass = ratio, .material = material});
  const BodyId top = world.add_body(
      {.shape = Sphere{0.25}, .position = {0, 0, 1 + fall + 0.001 + 0.25}, .mass = 1, .material = material});
  const double v0 = std::sqrt(2 * g * fall);
  double max = 0;
  // The launch speed follows from speed and height later on, by conservation of energy.
  run(world, at, 0.6, [&](double) {
    const double v = world.velocity(top).z();
    if (v > 0) max = std::max(max, std::sqrt(v * v + 2 * g * (world.pose(top).position.z() - (1.25 + 0.001))));
  });
  return max / v0;
}

// 1000 balls of 0.2 m that fly about without gravity in a box of 10 m with elastic walls.
struct Gas {
  World world;
  std::vector<BodyId> balls;

  // `restitution` is that of the balls, `of_walls` that of the walls: the larger of the two counts at a bounce.
  Gas(const Resolution& at, double restitution, double of_walls) : world(make_world(at, 0)) {
    constexpr int side = 10;
    constexpr double half = 5;
    for (const Vector3& normal : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)}) {
      for (const double sign : {1.0, -1.0}) {
        world.add_body({.type = BodyType::Static,
                        .shape = HalfSpace{sign * normal, -half},
                        .material = {.friction = 0, .restitution = of_walls}});
      }
    }
    std::mt19937 random(1);
    const auto speed = [&] { return 4 * (uniform(random) - 0.5); };
    for (int i = 0; i < side * side * side; ++i) {
      const Vector3 place(i % side, i / side % side, i / (side * side));
      const double vx = speed(), vy = speed(), vz = speed();
      balls.push_back(
          world.add_body({.shape = Sphere{0.2},
                          .position = (2 * half / side) * (place + Vector3::Constant(0.5)) - Vector3::Constant(half),
                          .velocity = {vx, vy, vz},
                          .material = {.friction = 0, .restitution = restitution}}));
    }
  }
  double energy() const {
    double sum = 0;
    for (const BodyId id : balls) sum += world.velocity(id).squaredNorm();
    return sum;
  }
};

// The largest change of energy of an elastic body without friction that is thrown at a wall, without gravity, in 200
// orientations.
double thrown(const Resolution& at, const Shape& shape, const Vector3& moments) {
  const Material material{.friction = 0, .restitution = 1};
  const Matrix3 inertia = moments.asDiagonal();
  std::mt19937 random(1);
  const auto part = [&] { return 2 * uniform(random) - 1; };
  double worst = 0;
  for (int i = 0; i < 200; ++i) {
    World world = make_world(at, 0);
    add_ground(world, material);
    const double x = part(), y = part(), z = part(), angle = pi * part();
    const double wx = part(), wy = part(), wz = part();
    const BodyId body = world.add_body({.shape = shape,
                                        .position = {0, 0, 1.5},
                                        .orientation = turn_about({x, y, z}, angle),
                                        .velocity = {1, 0, -4},
                                        .angular_velocity = {wx, wy, wz},
                                        .mass = 1.0,
                                        .inertia = inertia,
                                        .material = material});
    const double before = kinetic_energy(world, body, inertia);
    run(world, at, 1);
    worst = std::max(worst, std::abs(kinetic_energy(world, body, inertia) / before - 1));
  }
  return worst;
}

// A ball hits two that touch, all of mass 1 and without friction. Returns their energy after it by that before it,
// plus by how much one gets more than the other.
double break_of_three(const Resolution& at) {
  World world = make_world(at, 0);
  const Material material{.friction = 0, .restitution = 1};
  const double r = 0.1, speed = 8;
  const auto add = [&](double x, double y, double v) {
    return world.add_body(
        {.shape = Sphere{r}, .position = {x, y, 0}, .velocity = {v, 0, 0}, .mass = 1, .material = material});
  };
  const BodyId cue = add(-1, 0, speed), left = add(std::sqrt(3.0) * r, r, 0), right = add(std::sqrt(3.0) * r, -r, 0);
  run(world, at, 0.5);
  double sum = 0;
  for (const BodyId id : {cue, left, right}) sum += world.velocity(id).squaredNorm();
  return sum / (speed * speed) + std::abs(world.velocity(left).norm() - world.velocity(right).norm()) / speed;
}

// The speeds of five elastic balls in a row that touch, hit by one: how far they are, at most, off the last one's
// leaving alone, by that of the first.
double cradle(const Resolution& at) {
  World world = make_world(at, 0);
  const Material material{.friction = 0, .restitution = 1};
  std::vector<BodyId> balls;
  for (int i = 0; i < 5; ++i) {
    balls.push_back(world.add_body({.shape = Sphere{0.1},
                                    .position = {i == 0 ? -0.5 : 0.2 * i, 0, 0},
                                    .velocity = {i == 0 ? 1.0 : 0.0, 0, 0},
                                    .mass = 1,
                                    .material = material}));
  }
  run(world, at, 1);
  double worst = 0;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    worst = std::max(worst, std::abs(world.velocity(balls[i]).x() - (i + 1 == balls.size() ? 1 : 0)));
  }
  return worst;
}

// The energy of an elastic box without friction that falls on a corner, after 100 s, by that of the start.
double bouncing_box(const Resolution& at) {
  World world = make_world(at);
  const Material material{.friction = 0, .restitution = 1};
  add_ground(world, material);
  const BodyDef def{.shape = Box{{0.2, 0.3, 0.4}},
                    .position = {0, 0, 2},
                    .orientation = turn_about({1, 2, 3}, 0.7),
                    .angular_velocity = {1, 2, 0.5},
                    .material = material};
  const MassProperties mass = body_mass(def);
  const BodyId body = world.add_body(def);
  const auto energy = [&] {
    return kinetic_energy(world, body, mass.inertia) + mass.mass * g * world.pose(body).position.z();
  };
  const double before = energy();
  run(world, at, 100);
  return energy() / before;
}

double energy_of_gas(const Resolution& at) {
  Gas gas(at, 1, 1);
  const double before = gas.energy();
  run(gas.world, at, 8);
  return gas.energy() / before;
}

// How well the square root of temperature of balls that lose some of it falls as 1 / (1 + t / tau): R^2 of a line
// through its inverse, once they have forgotten how they began.
double haff(const Resolution& at) {
  Gas gas(at, 0.8, 1);
  double n = 0, st = 0, sy = 0, stt = 0, syy = 0, sty = 0;
  run(gas.world, at, 20, [&](double t) {
    if (t < 2) return;
    const double y = 1 / std::sqrt(gas.energy());
    n += 1, st += t, sy += y, stt += t * t, syy += y * y, sty += t * y;
  });
  const double covariance = n * sty - st * sy;
  return covariance * covariance / ((n * stt - st * st) * (n * syy - sy * sy));
}

// Speed of a wave of toppling dominoes by sqrt(g h), between the 20th and the 60th.
double domino_speed(const Resolution& at, double push) {
  constexpr int count = 70;
  const double h = 0.05, thickness = 0.1 * h, pitch = 0.5 * h + thickness;
  World world = make_world(at);
  const Material material{.friction = 0.2};
  add_ground(world, {.friction = 0.6});
  std::vector<BodyId> bodies;
  for (int i = 0; i < count; ++i) {
    bodies.push_back(world.add_body(
        {.shape = Box{{thickness / 2, h / 4, h / 2}}, .position = {i * pitch, 0, h / 2}, .material = material}));
  }
  world.set_velocity(bodies[0], Vector3(push, 0, 0), Vector3(0, push / (h / 2), 0));
  // When each leans by a tenth, between two steps.
  std::vector<double> toppled(count, 0), leans(count, 0);
  run(world, at, 4, [&](double time) {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (toppled[i] > 0) continue;
      const double before = leans[i];
      leans[i] = (world.pose(bodies[i]).orientation * Vector3::UnitZ()).x();
      if (leans[i] > 0.1) toppled[i] = time - at.dt * (leans[i] - 0.1) / (leans[i] - before);
    }
  });
  return 40 * pitch / (toppled[60] - toppled[20]) / std::sqrt(g * h);
}

// s, after which a ball of restitution 0.8 that falls by 1 m has come to rest.
double time_to_rest(const Resolution& at) {
  World world = make_world(at);
  const Material material{.friction = 0, .restitution = 0.8};
  add_ground(world, material);
  const BodyId ball = world.add_body({.shape = Sphere{0.1}, .position = {0, 0, 1.1}, .material = material});
  double last = 0;
  run(world, at, 6, [&](double time) {
    if (std::abs(world.velocity(ball).z()) > 1e-3) last = time;
  });
  return last;
}

}  // namespace

void add_impacts(std::vector<PhysicsCase>& cases) {
  cases.push_back({.name = "bounces-to-rest",
                   .what = "a ball of restitution 0.8 that falls by 1 m: when it has come to rest",
                   .unit = "s",
                   .right = 9 * std::sqrt(2 / g),
                   .source = "sqrt(2 h / g) (1 + e) / (1 - e)",
                   .scale = 9 * std::sqrt(2 / g),
                   .dt = 1.0 / 240,
                   .measure = time_to_rest});
  const auto falls = [&](const char* name, const char* what, const Shape& shape, double half, double height) {
    cases.push_back({.name = name,
                     .what = std::string(what) + ": how far aside it comes to rest",
                     .unit = "m",
                     .source = "symmetry",
                     .limit = 1e-3,
                     .measure = [=](const Resolution& at) { return aside_of_fall(at, shape, half, height); }});
  };
  falls("drop-cube-2.5", "a cube of 1 m dropped flat from 2.5 m", Box{}, 0.5, 2.5);
  falls("drop-cube-6", "the same from 6 m", Box{}, 0.5, 6);
  falls("drop-cylinder-2.5", "a cylinder of 1 m dropped flat from 2.5 m", Cylinder{}, 0.5, 2.5);
  falls("drop-cone-2.5", "a cone of 1 m dropped flat from 2.5 m", Cone{}, 0.5, 2.5);
  for (const double e : {0.0, 0.5, 0.9}) {
    cases.push_back({.name = "oblique-bounce-e" + std::to_string(static_cast<int>(10 * e)),
                     .what = "a ball that bounces at (3, -4) m/s, sliding, friction 0.1, restitution " +
                             std::to_string(e).substr(0, 3) + ": its speed along the wall",
                     .unit = "m/s",
                     .right = 3 - 0.1 * (1 + e) * 4,
                     .source = "v - mu (1 + e) u; Walton, 1993",
                     .scale = 3,
                     .measure = [=](const Resolution& at) { return speed_after_oblique_bounce(at, e); }});
  }
  for (const double ratio : {3.0, 100.0}) {
    cases.push_back({.name = "cannon-" + std::to_string(static_cast<int>(ratio)),
                     .what = "Galileo's cannon: of two elastic balls 1 mm apart, the lower " +
                             std::to_string(static_cast<int>(ratio)) + " times as heavy: the upper one's speed",
                     .unit = "",
                     .right = (3 * ratio - 1) / (ratio + 1),
                     .source = "two impacts one after the other: (3 M - m) / (M + m)",
                     .scale = (3 * ratio - 1) / (ratio + 1),
                     .measure = [=](const Resolution& at) { return cannon(at, ratio); }});
  }
  cases.push_back({.name = "gas-1000",
                   .what = "1000 elastic balls without friction in a box for 8 s: their energy",
                   .unit = "",
                   .right = 1,
                   .source = "conservation",
                   .measure = energy_of_gas});
  const auto throws = [&](const char* name, const char* what, const Shape& shape, const Vector3& moments) {
    cases.push_back({.name = name,
                     .what = std::string("an elastic ") + what +
                             " thrown at a wall at 4 m/s, turned in 200 ways: the most that its energy changes",
                     .unit = "",
                     .source = "conservation",
                     .measure = [=](const Resolution& at) { return thrown(at, shape, moments); }});
  };
  throws("throw-box", "box of 1 x 0.5 x 0.25 m", Box{{0.5, 0.25, 0.125}}, Vector3(5, 17, 20) / 192);
  throws("throw-cylinder", "cylinder of 1 m", Cylinder{}, Vector3(7, 7, 6) / 48);
  throws("throw-capsule", "capsule of 1 m", Capsule{.radius = 0.25, .half_height = 0.25}, {0.06, 0.06, 0.03});
  cases.push_back({.name = "break-of-three",
                   .what = "an elastic ball that hits two which touch: energy after, and difference of the two",
                   .unit = "",
                   .right = 1,
                   .source = "conservation and symmetry",
                   .limit = 1e-3,
                   .measure = break_of_three});
  cases.push_back(
      {.name = "cradle",
       .what = "five elastic balls in a row that touch, hit by one: farthest off the last one's leaving alone",
       .unit = "",
       .source = "conservation; each impact in turn",
       .limit = 1e-3,
       .measure = cradle});
  cases.push_back({.name = "bouncing-box",
                   .what = "an elastic box that bounces on its corners for 100 s: energy after",
                   .unit = "",
                   .right = 1,
                   .source = "conservation",
                   .measure = bouncing_box});
  cases.push_back({.name = "haff-cooling",
                   .what = "the same of restitution 0.8, 20 s: R^2 of a line through its inverse root of energy",
                   .unit = "",
                   .right = 1,
                   .source = "Haff, J. Fluid Mech. 134, 1983: T falls as (1 + t / tau)^-2",
                   .measure = haff});
  cases.push_back({.name = "dominoes-5cm",
                   .what = "dominoes of 5 cm at half their height, friction 0.2: speed by sqrt(g h), mean of 8 pushes",
                   .unit = "",
                   .right = 1.375,
                   .source = "converged, at dt 1/3840",
                   .scale = 1.375,
                   .dt = 1.0 / 240,
                   .measure = [](const Resolution& at) {
                     constexpr int pushes = 8;
                     double sum = 0;
                     for (int i = 0; i < pushes; ++i) sum += domino_speed(at, 0.26 + 0.01 * i);
                     return sum / pushes;
                   }});
}

}  // namespace atl::physics
