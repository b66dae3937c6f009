// Bodies that spin, held by joints.

#include <algorithm>

#include "cases.h"

namespace atl::physics {
namespace {

Settings with(JointSolver solver) {
  Settings settings;
  settings.joint_solver = solver;
  return settings;
}

// The most that the angular momentum of a body changes that is held at its centre, by what it was.
double held_spin(const Resolution& at) {
  World world = make_world(at, 0);
  const BodyDef def{.shape = Box{{0.5, 0.3, 0.1}}, .angular_velocity = {0.02, 2, 0.02}};
  const MassProperties mass = body_mass(def);
  const BodyId anchor = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
  const BodyId body = world.add_body(def);
  world.add_joint({.kind = BallJoint{}, .first = anchor, .second = body});
  const auto momentum = [&] {
    return Vector3(world_inertia(world, body, mass.inertia) * world.angular_velocity(body));
  };
  const Vector3 before = momentum();
  double max = 0;
  run(world, at, 20, [&](double) { max = std::max(max, (momentum() - before).norm() / before.norm()); });
  return max;
}

// The energy that a top on a ball joint ends with after 10 s, by what it began with.
double top_energy(const Resolution& at, JointSolver solver, double spin) {
  World world = make_world(at, g, with(solver));
  const double arm = 0.3;
  const Quaternion turn = turn_about(Vector3::UnitX(), pi / 6);
  const Vector3 axis = turn * Vector3::UnitZ();
  const BodyDef def{.shape = Cylinder{0.2, 0.02},
                    .position = arm * axis,
                    .orientation = turn,
                    .angular_velocity = spin * axis,
                    .filter = {.mask = 0}};
  const MassProperties mass = body_mass(def);
  const BodyId anchor = world.add_body({.type = BodyType::Static, .shape = Sphere{0.01}, .filter = {.mask = 0}});
  const BodyId body = world.add_body(def);
  world.add_joint({.kind = BallJoint{}, .first = anchor, .second = body, .frame_second = {.position = {0, 0, -arm}}});
  const auto energy = [&] {
    return kinetic_energy(world, body, mass.inertia) + mass.mass * g * world.pose(body).position.z();
  };
  const double before = energy();
  double worst = 1;
  run(world, at, 10, [&](double) {
    const double now = energy() / before;
    if (std::abs(now - 1) > std::abs(worst - 1)) worst = now;
  });
  return worst;
}

// The most that the angular momentum about the common centre of mass changes, by what it was.
double two_rods(const Resolution& at, JointSolver solver) {
  World world = make_world(at, 0, with(solver));
  const BodyDef first{
      .shape = Box{{0.5, 0.1, 0.05}}, .position = {0.5, 0, 0}, .angular_velocity = {3, 4, 0}, .filter = {.mask = 0}};
  const BodyDef second{.shape = Box{{0.3, 0.05, 0.1}}, .position = {-0.3, 0, 0}, .filter = {.mask = 0}};
  const BodyId a = world.add_body(first);
  const BodyId b = world.add_body(second);
  world.set_velocity(a, Vector3(3, 4, 0).cross(Vector3(0.5, 0, 0)), Vector3(3, 4, 0));
  world.add_joint({.kind = BallJoint{},
                   .first = a,
                   .second = b,
                   .frame_first = {.position = {-0.5, 0, 0}},
                   .frame_second = {.position = {0.3, 0, 0}}});
  const Matrix3 of_first = body_mass(first).inertia;
  const Matrix3 of_second = body_mass(second).inertia;
  const auto momentum = [&] {
    const double ma = world.mass(a), mb = world.mass(b);
    const Vector3 centre = (ma * world.pose(a).position + mb * world.pose(b).position) / (ma + mb);
    return Vector3(world_inertia(world, a, of_first) * world.angular_velocity(a) +
                   world_inertia(world, b, of_second) * world.angular_velocity(b) +
                   ma * (world.pose(a).position - centre).cross(world.velocity(a)) +
                   mb * (world.pose(b).position - centre).cross(world.velocity(b)));
  };
  const Vector3 before = momentum();
  double max = 0;
  run(world, at, 8, [&](double) { max = std::max(max, (momentum() - before).norm() / before.norm()); });
  return max;
}

}  // namespace

void add_spins(std::vector<PhysicsCase>& cases) {
  cases.push_back({.name = "held-spin",
                   .what = "a box held at its centre, 2 rad/s about its middle axis, 20 s: change of angular momentum",
                   .unit = "",
                   .source = "conservation",
                   .measure = held_spin});
  for (const double spin : {30.0, 100.0}) {
    for (const JointSolver solver : {JointSolver::Direct, JointSolver::Iterative}) {
      const bool direct = solver == JointSolver::Direct;
      cases.push_back({.name = "top-" + std::to_string(static_cast<int>(spin)) + (direct ? "" : "-swept"),
                       .what = "a heavy top, " + std::to_string(static_cast<int>(spin)) + " rad/s, 10 s, joints " +
                               (direct ? "direct" : "swept") + ": its energy, where it is farthest off",
                       .unit = "",
                       .right = 1,
                       .source = "conservation",
                       .limit = direct ? 0.01 : 0.1,
                       .measure = [=](const Resolution& at) { return top_energy(at, solver, spin); }});
    }
  }
  for (const JointSolver solver : {JointSolver::Auto, JointSolver::Direct}) {
    const bool direct = solver == JointSolver::Direct;
    cases.push_back({.name = direct ? "two-rods-direct" : "two-rods",
                     .what = std::string("two rods on a ball joint that tumble freely, 8 s, joints ") +
                             (direct ? "direct" : "as by default") + ": change of angular momentum",
                     .unit = "",
                     .source = "conservation",
                     .measure = [=](const Resolution& at) { return two_rods(at, solver); }});
  }
}

}  // namespace atl::physics
