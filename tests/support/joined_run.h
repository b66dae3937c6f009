#pragma once
/// A scene with joints, and how far it has come from what joints and energy ask for.

#include <atoll/atoll.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/bodies.h"

namespace atl::test {

/// Names the instances of a test over both solvers.
inline std::string solver_name(JointSolver solver) {
  return solver == JointSolver::Direct ? "Direct" : solver == JointSolver::Iterative ? "Iterative" : "Auto";
}

struct JoinedRun {
  Scene scene;
  World world;
  std::vector<BodyId> ids;
  std::vector<PlacedJoint> joints;
  std::vector<MassProperties> masses;  ///< of static bodies 0

  explicit JoinedRun(Scene from, JointSolver solver = JointSolver::Auto)
      : scene(std::move(from)), world({.gravity = scene.gravity, .settings = with(scene.settings, solver)}) {
    ids = build_scene(scene, world);
    joints = placed_joints(scene);
    for (const SceneBody& body : scene.bodies) {
      masses.push_back(body.def.type == BodyType::Dynamic ? body_mass(body.def) : MassProperties{});
    }
  }
  explicit JoinedRun(std::string_view text, JointSolver solver = JointSolver::Auto)
      : JoinedRun(load_scene(text), solver) {}

  JointDriftReport drift() const { return measure_joint_drift(joints, body_states(world, ids)); }
  MotionReport motion() const {
    std::vector<MovingBody> bodies;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (masses[i].mass > 0) bodies.push_back({.mass = masses[i], .state = world.state(ids[i])});
    }
    return measure_motion(bodies, world.gravity());
  }
  /// J, kinetic and potential.
  double energy() const {
    const MotionReport now = motion();
    return now.kinetic + now.potential;
  }
  double total_mass() const {
    double sum = 0;
    for (const MassProperties& mass : masses) sum += mass.mass;
    return sum;
  }

 private:
  static Settings with(Settings settings, JointSolver solver) {
    settings.joint_solver = solver;
    return settings;
  }
};

}  // namespace atl::test
