// Systems that keep their energy, for 100 s at the defaults.

#include <algorithm>

#include "cases.h"
#include "linkages.h"

namespace atl::physics {
namespace {

// A system's moving parts, and the energy in its springs.
struct Closed {
  World world;
  std::vector<Part> parts;
  std::function<double()> stored = {};  // J

  Closed(const Resolution& at, double gravity) : world(make_world(at, gravity)) {}

  // A rod of 1 kg from one place to another, as thin as it may be.
  BodyId add_rod(const Vector3& tail, const Vector3& head, const Vector3& velocity = {0, 0, 0},
                 const Vector3& spin = {0, 0, 0}) {
    const Vector3 along = head - tail;
    const double moment = along.squaredNorm() / 12;
    return add(1, {1e-4, moment, moment}, {0.5 * (tail + head), turn_between(Vector3::UnitX(), along)}, velocity, spin);
  }
  BodyId add(double mass, const Vector3& moments, const Pose& pose, const Vector3& velocity = {0, 0, 0},
             const Vector3& spin = {0, 0, 0}) {
    parts.push_back(add_part(world, mass, moments, pose, velocity, spin));
    return parts.back().body;
  }
  // A ball that touches what others do.
  BodyId add_ball(double radius, const Vector3& place, const Vector3& velocity, const Material& material) {
    const BodyId ball = world.add_body(
        {.shape = Sphere{radius}, .position = place, .velocity = velocity, .mass = 1, .material = material});
    parts.push_back({ball, 0.4 * radius * radius * Matrix3::Identity()});
    return ball;
  }
  void add_walls(double half, const Material& material) {
    for (const Vector3& normal : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)}) {
      for (const double sign : {1.0, -1.0}) {
        world.add_body({.type = BodyType::Static, .shape = HalfSpace{sign * normal, -half}, .material = material});
      }
    }
  }
  // A spring of so many N/m between centres of mass.
  void add_spring(BodyId first, BodyId second, double rest, double stiffness) {
    world.add_joint({.kind = DistanceJoint{{.range = {}, .spring = JointSpring{.rest = rest, .stiffness = stiffness}}},
                     .first = first,
                     .second = second});
    stored = [this, before = stored, first, second, rest, stiffness] {
      const double stretch = (world.pose(first).position - world.pose(second).position).norm() - rest;
      return (before ? before() : 0) + 0.5 * stiffness * stretch * stretch;
    };
  }

  double kinetic() const {
    double sum = 0;
    for (const auto& [body, inertia] : parts) sum += kinetic_energy(world, body, inertia);
    return sum;
  }
  double energy() const {
    double sum = kinetic() + (stored ? stored() : 0);
    for (const Part& part : parts) {
      sum -= world.mass(part.body) * world.gravity().dot(world.centre_of_mass(part.body));
    }
    return sum;
  }
};

using Build = std::function<void(Closed&)>;

// The most that the energy is off within 100 s, over the largest kinetic energy.
double energy_off(const Resolution& at, double gravity, const Build& build) {
  Closed closed(at, gravity);
  build(closed);
  const double start = closed.energy();
  double off = 0, max = closed.kinetic();
  run(closed.world, at, 100, [&](double) {
    off = std::max(off, std::abs(closed.energy() - start));
    max = std::max(max, closed.kinetic());
  });
  return off / max;
}

const Vector3 origin(0, 0, 0), x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();

// Rods that hang one on the other, as these angles from straight down have them.
std::vector<BodyId> add_chain(Closed& to, const std::vector<double>& angles, const JointAxis& elbow = {}) {
  std::vector<BodyId> rods = {add_floor(to.world)};
  Vector3 from = origin;
  for (const double angle : angles) {
    const Vector3 head = from + Vector3(std::sin(angle), 0, -std::cos(angle));
    const BodyId rod = to.add_rod(from, head);
    add_hinge(to.world, rods.back(), rod, from, y, rods.size() > 1 ? elbow : JointAxis{});
    rods.push_back(rod);
    from = head;
  }
  return rods;
}

void add_ball_joint(Closed& to, BodyId first, BodyId second, const Vector3& place) {
  const auto frame = [&](BodyId body) {
    const Pose pose = to.world.pose(body);
    return Pose{pose.orientation.conjugate() * (place - pose.position)};
  };
  to.world.add_joint({.kind = BallJoint{},
                      .first = first,
                      .second = second,
                      .frame_first = frame(first),
                      .frame_second = frame(second)});
}

void spherical_pendulum(Closed& to) {
  const BodyId rod = to.add_rod(origin, Vector3(0.8, 0, -0.6), {0, 0.75, 0}, {0, 0, 0.9375});
  to.world.set_velocity(rod, Vector3(0, 0, 1.5).cross(Vector3(0.4, 0, -0.3)), {0, 0, 1.5});
  add_ball_joint(to, add_floor(to.world), rod, origin);
}

void heavy_top(Closed& to) {
  const Vector3 axle = Vector3(0.5, 0, 0.866).normalized();
  const BodyId top = to.add(1, {0.01, 0.01, 0.02}, {0.2 * axle, turn_between(z, axle)}, origin, 60 * axle);
  add_ball_joint(to, add_floor(to.world), top, origin);
}

void four_bar(Closed& to) {
  const Vector3 a = origin, b(0, 0, 0.5), c(1.5, 0, 1), d(1.4, 0, 0);
  const BodyId floor = add_floor(to.world);
  const BodyId crank = to.add_rod(a, b), coupler = to.add_rod(b, c), rocker = to.add_rod(c, d);
  add_hinge(to.world, floor, crank, a, y);
  add_hinge(to.world, crank, coupler, b, y);
  add_hinge(to.world, coupler, rocker, c, y);
  add_hinge(to.world, rocker, floor, d, y);
}

void tumbler(Closed& to) { to.add(1, {1, 2, 3}, {}, origin, {0.01, 5, 0.02}); }

void satellite_with_rotor(Closed& to) {
  const Vector3 spin(0.1, 0.2, 0.05), mount(0.3, 0.1, 0), axle = Vector3(1, 0, 1).normalized();
  const BodyId bus = to.add(100, {10, 20, 25}, {}, origin, spin);
  const BodyId rotor =
      to.add(5, {0.1, 0.06, 0.06}, {mount, turn_between(x, axle)}, spin.cross(mount), spin + 60 * axle);
  add_hinge(to.world, bus, rotor, mount, axle);
}

void thrown_ragdoll(Closed& to) {
  const BodyId trunk = to.add(5, {0.2, 0.3, 0.1}, {}, origin, {1, 2, 0.5});
  for (const double side : {1.0, -1.0}) {
    for (const double end : {1.0, -1.0}) {
      const Vector3 from(0.2 * side, 0, 0.3 * end), to_elbow(0.3 * side, 0, 0.1 * end);
      const Vector3 spin(1, 2, 0.5);
      const auto velocity = [&](const Vector3& place) { return spin.cross(place).eval(); };
      const BodyId upper =
          to.add(1, {0.01, 0.012, 0.003}, {from + 0.5 * to_elbow}, velocity(from + 0.5 * to_elbow), spin);
      const BodyId lower =
          to.add(1, {0.01, 0.012, 0.003}, {from + 1.5 * to_elbow}, velocity(from + 1.5 * to_elbow), spin);
      add_ball_joint(to, trunk, upper, from);
      add_hinge(to.world, upper, lower, from + to_elbow, y);
    }
  }
}

void orbiting_pair(Closed& to) {
  const BodyId first = to.add(1, {1, 1, 1}, {{0.6, 0, 0}}, {0, 1, 0});
  const BodyId second = to.add(2, {1, 1, 1}, {{-0.6, 0, 0}}, {0, -0.5, 0.2});
  to.add_spring(first, second, 1, 30);
}

void row_of_springs(Closed& to) {
  BodyId before = add_floor(to.world);
  for (int i = 1; i <= 5; ++i) {
    const BodyId body = to.add(1, {1, 1, 1}, {{0.5 * i, 0.02 * i * i, 0}});
    to.add_spring(before, body, 0.45, 200);
    before = body;
  }
}

void wheel_on_arm(Closed& to) {
  const BodyId arm = to.add_rod(origin, x);
  const BodyId wheel = to.add(1, {0.04, 0.08, 0.04}, {x}, origin, {0, 20, 0});
  add_hinge(to.world, add_floor(to.world), arm, origin, y);
  add_hinge(to.world, arm, wheel, x, y);
}

void pendulum_cart(Closed& to) {
  const BodyId cart = to.add(2, {1, 1, 1}, {});
  to.world.add_joint({.kind = SliderJoint{}, .first = add_floor(to.world), .second = cart});
  const BodyId rod = to.add_rod(origin, Vector3(0.94, 0, 0.34));
  add_hinge(to.world, cart, rod, origin, y);
}

constexpr Material elastic{.friction = 0, .restitution = 1};

void dropped_ball(Closed& to) {
  add_ground(to.world, elastic);
  to.add_ball(0.1, {0, 0, 1.1}, origin, elastic);
}

void ball_in_room(Closed& to) {
  to.add_walls(1, elastic);
  to.add_ball(0.1, origin, {2, 1, 1.5}, elastic);
}

void balls_in_room(Closed& to) {
  to.add_walls(1, elastic);
  std::mt19937 random(1);
  const auto speed = [&] { return 2 * uniform(random) - 1; };
  for (int i = 0; i < 27; ++i) {
    const Vector3 place(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const double vx = speed(), vy = speed(), vz = speed();
    to.add_ball(0.15, 0.6 * place, {vx, vy, vz}, elastic);
  }
}

void sliding_ball(Closed& to) {
  to.world.add_body({.type = BodyType::Static,
                     .shape = HalfSpace{Vector3(0.3, 0, 1).normalized(), 0},
                     .material = {.friction = 0, .restitution = 1}});
  to.world.add_body({.type = BodyType::Static,
                     .shape = HalfSpace{Vector3(-0.3, 0, 1).normalized(), 0},
                     .material = {.friction = 0, .restitution = 1}});
  to.add_ball(0.1, {0.2, 0, 1}, origin, elastic);
}

struct ClosedCase {
  const char* name;
  const char* what;
  double gravity;
  Build build;
  const char* known_failure = "";
  const char* known_growth = "";
};

}  // namespace

void add_energies(std::vector<PhysicsCase>& cases) {
  const ClosedCase all[] = {
      {"pendulum", "a rod let go level", g, [](Closed& to) { add_chain(to, {pi / 2}); }},
      {"double-pendulum", "two rods let go 2 and 1 rad from hanging", g,
       [](Closed& to) {
         add_chain(to, {2, 1});
       }},
      {"triple-pendulum", "three rods let go level", g,
       [](Closed& to) {
         add_chain(to, {pi / 2, pi / 2, pi / 2});
       }},
      {"chain", "ten rods let go level", g, [](Closed& to) { add_chain(to, std::vector<double>(10, pi / 2)); }},
      {"rotor-pendulum", "two rods with a rotor of 0.2 kg m^2 between them", g,
       [](Closed& to) {
         const auto rods = add_chain(to, {1.2, 0.4}, {.armature = 0.2});
         to.stored = [&to, rods] {
           const double rate = (to.world.angular_velocity(rods[2]) - to.world.angular_velocity(rods[1])).y();
           return 0.5 * 0.2 * rate * rate;
         };
       }},
      {"sprung-pendulum", "two rods with a spring of 10 N m between them", g,
       [](Closed& to) {
         const auto rods = add_chain(to, {1.2, 0.4}, {.spring = JointSpring{.stiffness = 10}});
         to.stored = [&to, rods] {
           const Vector3 a = to.world.pose(rods[1]).orientation * x, b = to.world.pose(rods[2]).orientation * x;
           const double start = 0.8, bend = std::atan2(a.cross(b).y(), a.dot(b)) - start;
           return 0.5 * 10 * bend * bend;
         };
       }},
      {"spherical-pendulum", "a rod on a ball joint", g, spherical_pendulum},
      {"heavy-top", "a top of 60 rad/s on a ball joint", g, heavy_top},
      {"four-bar", "a linkage of four bars that falls", g, four_bar},
      {"tumbler", "a body that spins about its middle axis", 0, tumbler},
      {"satellite", "a satellite with a rotor of 60 rad/s", 0, satellite_with_rotor,
       "joints of what floats are swept by default, which takes 0.013% a second from the rotor; 4e-4 at 1/240"},
      {"ragdoll", "a trunk with four limbs, thrown", g, thrown_ragdoll},
      {"orbiting-pair", "two bodies on a spring about each other", 0, orbiting_pair, "",
       "as swept springs do: the cause is not known"},
      {"row-of-springs", "five bodies in a row of springs", 0, row_of_springs},
      {"wheel-on-arm", "an arm that swings with a wheel that spins", g, wheel_on_arm},
      {"pendulum-cart", "a pendulum on a cart that slides", g, pendulum_cart},
      {"dropped-ball", "an elastic ball that falls by 1 m", g, dropped_ball},
      {"ball-in-room", "an elastic ball in a room", g, ball_in_room},
      {"balls-in-room", "27 elastic balls in a room", g, balls_in_room},
      {"ball-in-trough", "an elastic ball in a trough without friction", g, sliding_ball, "",
       "noise of single precision"},
  };
  for (const ClosedCase& closed : all) {
    cases.push_back({.name = std::string("energy-") + closed.name,
                     .what = std::string(closed.what) + ", 100 s: the most that its energy is off, by the most kinetic",
                     .unit = "",
                     .source = "conservation",
                     .measure = [=](const Resolution& at) { return energy_off(at, closed.gravity, closed.build); },
                     .known_failure = closed.known_failure,
                     .known_growth = closed.known_growth});
  }
}

}  // namespace atl::physics
