// Springs.

#include <algorithm>

#include "cases.h"

namespace atl::physics {
namespace {

// A body on an undamped spring along x that starts at rest 1 m from where it would be, at x = 1.
struct Swinging {
  World world;
  BodyId body;

  Swinging(const Resolution& at, JointSolver solver, double hertz)
      : world(make_world(at, 0, {.joint_solver = solver})),
        body(world.add_body({.shape = Sphere{0.1}, .position = {1, 0, 0}, .filter = {.mask = 0}})) {
    const BodyId anchor = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}, .filter = {.mask = 0}});
    world.add_joint({.kind = SliderJoint{{.spring = JointSpring{.hertz = hertz, .damping_ratio = 0, .rest = -1}}},
                     .first = anchor,
                     .second = body,
                     .frame_first = {.position = {1, 0, 0}}});
  }
  double x() const { return world.pose(body).position.x(); }
};

// m, in the last of ten periods.
double amplitude(const Resolution& at, JointSolver solver, double hertz) {
  Swinging swinging(at, solver, hertz);
  double max = 0;
  run(swinging.world, at, 10 / hertz, [&](double time) {
    if (time > 9 / hertz) max = std::max(max, std::abs(swinging.x()));
  });
  return max;
}

// m, the farthest off a cosine in ten periods.
double phase_error(const Resolution& at, JointSolver solver, double hertz) {
  Swinging swinging(at, solver, hertz);
  double max = 0;
  run(swinging.world, at, 10 / hertz,
      [&](double time) { max = std::max(max, std::abs(swinging.x() - std::cos(2 * pi * hertz * time))); });
  return max;
}

// A rod of 1 m on a hinge at its end, in its plane.
struct HungRod {
  static constexpr double length = 1, mass = 1;
  World world;
  BodyId hook, rod;
  JointId hinge;
  double inertia;  // kg m^2, about the hinge

  HungRod(const Resolution& at, double angle, const JointAxis& axis) : world(make_world(at)) {
    hook = world.add_body({.type = BodyType::Static, .shape = Sphere{0.01}, .filter = {.mask = 0}});
    const Vector3 along(std::sin(angle), 0, -std::cos(angle));
    const BodyDef def{.shape = Box{{0.01, 0.01, length / 2}},
                      .position = length / 2 * along,
                      .orientation = turn_about(Vector3::UnitY(), -angle),
                      .mass = mass,
                      .filter = {.mask = 0}};
    rod = world.add_body(def);
    inertia = body_mass(def).inertia(1, 1) + mass * length * length / 4;
    // Hinges turn about the x axes of their frames.
    const Quaternion frame = turn_about(Vector3::UnitZ(), pi / 2);
    hinge = world.add_joint({.kind = HingeJoint{axis},
                             .first = hook,
                             .second = rod,
                             .frame_first = {Vector3::Zero(), frame},
                             .frame_second = {{0, 0, length / 2}, frame}});
  }
  // From hanging, towards x.
  double angle() const {
    const Vector3 centre = world.pose(rod).position;
    return std::atan2(centre.x(), -centre.z());
  }
};

// m, the farthest that the tip of a rod is off, which a spring of 40 N/m pulls to a fixed point, in 3 s.
double tip_on_spring(const Resolution& at) {
  constexpr double start = 0.3, stiffness = 40, rest = 0.5;
  const Vector3 hold(1, 0, 0.5);
  HungRod hung(at, start, {});
  hung.world.add_joint(
      {.kind = DistanceJoint{{.range = {}, .spring = JointSpring{.rest = rest, .stiffness = stiffness}}},
       .first = hung.hook,
       .second = hung.rod,
       .frame_first = {hold, Quaternion::Identity()},
       .frame_second = {{0, 0, -HungRod::length / 2}, Quaternion::Identity()}});
  const auto acceleration = [&](double angle) {
    const Vector3 tip(std::sin(angle), 0, -std::cos(angle));
    const Vector3 pulls = stiffness * (1 - rest / (hold - tip).norm()) * (hold - tip);
    return (tip.z() * -pulls.x() + tip.x() * pulls.z() - HungRod::mass * g / 2 * std::sin(angle)) / hung.inertia;
  };
  Eigen::Vector2d swing(start, 0);  // the angle and its rate
  double worst = 0;
  run(hung.world, at, 3, [&](double) {
    swing = integrated(swing, at.dt, 5e-4,
                       [&](const Eigen::Vector2d& y) { return Eigen::Vector2d(y[1], acceleration(y[0])); });
    worst = std::max(worst, HungRod::length * std::abs(std::remainder(hung.angle() - swing[0], 2 * pi)));
  });
  return worst;
}

// Hz, of a rod without weight on a spring of its hinge that is to make it swing at 1 Hz.
double hinge_frequency(const Resolution& at) {
  HungRod hung(at, 0.1, {});
  hung.world.set_joint(hung.hinge, HingeJoint{{.spring = JointSpring{.stiffness = hung.inertia * 4 * pi * pi}}});
  hung.world.set_gravity(Vector3::Zero());
  // The hinge's angle is 0 where it starts, so it swings about there once it is pushed.
  const double begin = hung.angle();
  hung.world.set_velocity(hung.rod, Vector3(0.05, 0, 0.05 * std::tan(0.1)), Vector3(0, -0.1 / std::cos(0.1), 0));
  double before = 0, first = 0, last = 0;
  int crossings = 0;
  run(hung.world, at, 10.2, [&](double time) {
    const double now = hung.angle() - begin;
    if (time > at.dt && before < 0 && now >= 0) {
      last = time - at.dt * now / (now - before);
      if (crossings++ == 0) first = last;
    }
    before = now;
  });
  return (crossings - 1) / (last - first);
}

}  // namespace

void add_springs(std::vector<PhysicsCase>& cases) {
  cases.push_back({.name = "spring-to-tip",
                   .what = "a hinged rod whose tip a spring of 40 N/m pulls to a fixed point, 3 s: the farthest off",
                   .unit = "m",
                   .source = "equation of motion, RK4 at 0.5 ms",
                   .measure = tip_on_spring});
  cases.push_back({.name = "spring-of-hinge",
                   .what = "a rod hinged at its end, on a spring in N m/rad for 1 Hz: its frequency",
                   .unit = "Hz",
                   .right = 1,
                   .source = "sqrt(k / I) / (2 pi)",
                   .limit = 1e-3,
                   .measure = hinge_frequency});
  for (const JointSolver solver : {JointSolver::Direct, JointSolver::Iterative}) {
    const std::string suffix = solver == JointSolver::Direct ? "" : "-swept";
    const std::string joints = solver == JointSolver::Direct ? "direct" : "swept";
    cases.push_back(
        {.name = "spring-amplitude" + suffix,
         .what = "a body on an undamped spring of 1 Hz, joints " + joints + ": amplitude in the tenth period",
         .unit = "m",
         .right = 1,
         .source = "conservation",
         .measure = [=](const Resolution& at) { return amplitude(at, solver, 1); },
         .known_growth = solver == JointSolver::Direct ? "" : "the cause is not known"});
    cases.push_back({.name = "spring-motion" + suffix,
                     .what = "the same: the farthest off a cosine in ten periods",
                     .unit = "m",
                     .source = "A cos(2 pi f t)",
                     .measure = [=](const Resolution& at) { return phase_error(at, solver, 1); },
                     .known_failure = solver == JointSolver::Direct
                                          ? ""
                                          : "velocities are half a substep behind in joints that are swept"});
  }
}

}  // namespace atl::physics
