// Springs.

#include <algorithm>

#include "cases.h"

namespace atl::physics {
namespace {

// m, of a body on an undamped spring of 1 m amplitude in the last of ten periods.
double amplitude(const Resolution& at, JointSolver solver, double hertz) {
  Settings settings;
  settings.joint_solver = solver;
  World world = make_world(at, 0, settings);
  const BodyId anchor = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}, .filter = {.mask = 0}});
  const BodyId body = world.add_body({.shape = Sphere{0.1}, .position = {1, 0, 0}, .filter = {.mask = 0}});
  world.add_joint({.kind = SliderJoint{{.spring = JointSpring{.hertz = hertz, .damping_ratio = 0, .rest = -1}}},
                   .first = anchor,
                   .second = body,
                   .frame_first = {.position = {1, 0, 0}}});
  double most = 0;
  run(world, at, 10 / hertz, [&](double time) {
    if (time > 9 / hertz) most = std::max(most, std::abs(world.pose(body).position.x()));
  });
  return most;
}

// m, where it is after 9.7 periods
double phase_error(const Resolution& at, JointSolver solver, double hertz) {
  Settings settings;
  settings.joint_solver = solver;
  World world = make_world(at, 0, settings);
  const BodyId anchor = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}, .filter = {.mask = 0}});
  const BodyId body = world.add_body({.shape = Sphere{0.1}, .position = {1, 0, 0}, .filter = {.mask = 0}});
  world.add_joint({.kind = SliderJoint{{.spring = JointSpring{.hertz = hertz, .damping_ratio = 0, .rest = -1}}},
                   .first = anchor,
                   .second = body,
                   .frame_first = {.position = {1, 0, 0}}});
  double most = 0;
  run(world, at, 10 / hertz, [&](double time) {
    most = std::max(most, std::abs(world.pose(body).position.x() - std::cos(2 * pi * hertz * time)));
  });
  return most;
}

}  // namespace

void add_springs(std::vector<PhysicsCase>& cases) {
  for (const JointSolver solver : {JointSolver::Direct, JointSolver::Iterative}) {
    const std::string suffix = solver == JointSolver::Direct ? "" : "-swept";
    const std::string joints = solver == JointSolver::Direct ? "direct" : "swept";
    cases.push_back(
        {.name = "spring-amplitude" + suffix,
         .what = "a body on an undamped spring of 1 Hz, joints " + joints + ": amplitude in the tenth period",
         .unit = "m",
         .right = 1,
         .source = "conservation",
         .measure = [=](const Resolution& at) { return amplitude(at, solver, 1); }});
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
