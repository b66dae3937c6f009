#pragma once
/// A few bodies and joints, and the solver layer's step of them, without a world around.

#include <jobs/arena.h>
#include <jobs/worker_team.h>
#include <solver/select/joint_selection.h>
#include <solver/sweep/group_solver.h>

#include <algorithm>
#include <optional>
#include <vector>

namespace atl::test {

using namespace solver;  // NOLINT: a header of tests

struct JointRig {
  BodyTable bodies;
  std::vector<Joint> joints;
  SolverSettings settings{.joint_method = JointMethod::Iterative};
  Vector3 gravity = Vector3::Zero();
  const Kernels* kernels = available_kernels().front();
  bool one_each = false;  ///< a group for every island
  int team = 0;           ///< workers that share a group; 0: the calling thread alone

  std::uint32_t add_fixed(const Vector3& position) {
    const auto body = static_cast<std::uint32_t>(bodies.size());
    bodies.resize(body + 1u);
    bodies.position(body) = position;
    bodies.set_orientation(body, Quaternion::Identity());
    return body;
  }

  std::uint32_t add_kinematic(const Vector3& position, const Vector3& velocity, const Vector3& spin) {
    const std::uint32_t body = add_fixed(position);
    bodies.mobility[body] = Mobility::Kinematic;
    bodies.velocity(body) = velocity;
    bodies.angular_velocity(body) = spin;
    return body;
  }

  /// A ball of this mass, or, with `moments`, another body. kg m^2, about its axes.
  std::uint32_t add_dynamic(const Vector3& position, double mass, const Vector3& moments,
                            const Quaternion& orientation = Quaternion::Identity()) {
    const std::uint32_t body = add_fixed(position);
    bodies.mobility[body] = Mobility::Dynamic;
    bodies.set_orientation(body, orientation);
    bodies.inverse_mass[body] = 1 / mass;
    bodies.inertia.set(body, moments.asDiagonal());
    bodies.inverse_inertia.set(body, moments.cwiseInverse().asDiagonal());
    bodies.gyroscopic[body] = moments.isConstant(moments.x()) ? 0 : 1;
    bodies.moments.set(body, moments);
    bodies.radius[body] = 0.5;
    return body;
  }
  std::uint32_t add_ball(const Vector3& position, double mass = 1) {
    return add_dynamic(position, mass, Vector3::Constant(0.1 * mass));
  }

  /// Joins two bodies where they are, at a place and with axes of the world frame.
  Joint& join(std::uint32_t first, std::uint32_t second, const Vector3& place,
              const Quaternion& axes = Quaternion::Identity()) {
    Joint joint;
    joint.first = first;
    joint.second = second;
    const Quaternion to_first = bodies.orientation(first).conjugate();
    const Quaternion to_second = bodies.orientation(second).conjugate();
    joint.anchor_first = to_first * (place - bodies.position(first));
    joint.anchor_second = to_second * (place - bodies.position(second));
    joint.axes_first = to_first * axes;
    joint.axes_second = to_second * axes;
    joints.push_back(joint);
    return joints.back();
  }
  Joint& join_point(std::uint32_t first, std::uint32_t second, const Vector3& place,
                    const Quaternion& axes = Quaternion::Identity()) {
    Joint& joint = join(first, second, place, axes);
    joint.point = true;
    return joint;
  }

  /// Several steps.
  GroupReport step(double dt, int count = 1);

  JointFrames frames(const Joint& joint) const {
    return joint_frames(joint, bodies.position(joint.first), bodies.orientation(joint.first),
                        bodies.position(joint.second), bodies.orientation(joint.second));
  }
  /// Velocity of the second frame's origin relative to the first's, m/s.
  Vector3 point_speed(const Joint& joint) const {
    const JointFrames f = frames(joint);
    const Vector3 first = bodies.velocity(joint.first) + bodies.angular_velocity(joint.first).cross(f.arm_first);
    const Vector3 second = bodies.velocity(joint.second) + bodies.angular_velocity(joint.second).cross(f.arm_second);
    return second - first;
  }
  double rate(const Joint& joint, std::size_t row) const {
    return joint_row(joint, row, frames(joint))
        .rate(bodies.velocity(joint.first), bodies.angular_velocity(joint.first), bodies.velocity(joint.second),
              bodies.angular_velocity(joint.second));
  }

 private:
  GroupSolver solver_;
};

inline void add_row(Joint& joint, Coordinate coordinate, const Law& law) {
  joint.coordinate[joint.rows] = coordinate;
  joint.law[joint.rows] = law;
  ++joint.rows;
}
inline constexpr Law locked_law{.lower = 0, .upper = 0};

/// About the x axis of the frames.
inline void add_hinge_rows(Joint& joint, const Law& about_axis) {
  add_row(joint, Coordinate::SwingAlongY, locked_law);
  add_row(joint, Coordinate::SwingAlongZ, locked_law);
  add_row(joint, Coordinate::AngleX, about_axis);
}

inline GroupReport JointRig::step(double dt, int count) {
  JointGraph graph;
  graph.build(joints, std::vector<std::uint8_t>(joints.size(), 1), bodies);
  JointSystems systems;
  systems.build(graph, joints, bodies, [&](std::uint32_t component) {
    const std::span<const JointLink> links = graph.links_of(component);
    const bool too_stiff = dt / settings.substeps > longest_substep(links, joints, bodies);
    return joins_directly(links, joints, bodies, settings.joint_method, too_stiff);
  });
  std::vector<std::uint32_t> candidates;
  std::vector<std::uint8_t> awake(bodies.size(), 0);
  for (std::uint32_t body = 0; body < bodies.size(); ++body) {
    if (bodies.mobility[body] == Mobility::Fixed) continue;
    candidates.push_back(body);
    awake[body] = bodies.mobility[body] == Mobility::Dynamic;
  }
  Islands islands;
  islands.build(candidates, awake, {}, graph.links());
  std::vector<std::uint32_t> company(islands.count(), 0);
  for (std::size_t island = 0; island < islands.count(); ++island) {
    const std::span<const JointLink> links = islands.joints(island, island + 1);
    const bool at_once = !links.empty() && systems.is_direct(graph.component_of(links.front().joint));
    if (at_once) company[island] = Islands::none;
  }
  std::vector<IslandGroup> groups;
  pack_groups(islands, one_each, company, groups);
  FastBodies fast(std::max(1, team));
  collision::MotionBounds bounds;
  bounds.resize(bodies.size());
  std::optional<jobs::Arena> arena;
  if (team > 0) arena.emplace(team);
  GroupReport report;
  for (int i = 0; i < count; ++i) {
    const SolveInput input{.islands = islands,
                           .bodies = bodies,
                           .manifolds = nullptr,
                           .gravity = gravity,
                           .dt = dt,
                           .settings = settings,
                           .kernels = *kernels,
                           .bounds = bounds,
                           .fast = fast,
                           .joints = joints.data(),
                           .joint_graph = &graph,
                           .joint_systems = &systems};
    for (const IslandGroup& group : groups) {
      if (company[group.begin] == Islands::none) {
        const JointLink& link = islands.joints(group.begin, group.end).front();
        if (systems.of(graph.component_of(link.joint)).solve(input.of_direct_islands())) continue;
      }
      if (team == 0) {
        report = solver_.solve(input, group);
        continue;
      }
      const bool kept = i > 0 && groups.size() == 1;
      jobs::WorkerTeam workers(*arena);
      report = solver_.solve(input, group, workers, kept ? GroupColours::Kept : GroupColours::New);
    }
    for (std::uint32_t body = 0; body < bodies.size(); ++body) {
      if (bodies.mobility[body] != Mobility::Kinematic) continue;
      bodies.position(body) += dt * bodies.velocity(body);
      const Vector3 turn = dt * bodies.angular_velocity(body);
      const Quaternion rotation(Eigen::AngleAxisd(turn.norm(), turn.norm() > 0 ? turn.normalized() : Vector3::UnitX()));
      bodies.set_orientation(body, (rotation * bodies.orientation(body)).normalized());
    }
  }
  return report;
}

}  // namespace atl::test
