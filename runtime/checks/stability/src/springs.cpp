#include <cmath>

#include "cases.h"
#include "criteria.h"
#include "parts.h"
#include "scene/src/joined_scene.h"

namespace atl::stability {
namespace {

constexpr double stretch = 0.1;  // m, at the start

// Hz of a spring that turns by so many radians a substep.
double hertz_for(double radians, const Scene& scene) { return radians / (2 * std::numbers::pi * substep(scene)); }

// A weight on a slider, hung on a spring that is not damped.
Scene weight_on_spring(double radians) {
  Scene scene;
  scene.bodies.push_back(scene::untouched(scene::fixed_ball("hook", Vector3::Zero(), 0.05)));
  scene.bodies.push_back(
      scene::untouched(solid("weight", Box{Vector3::Constant(0.2)}, {0, 0, -1 - stretch}, scene::builtin_material)));
  const Quaternion down = scene::frame_along(-Vector3::UnitZ());
  const SliderJoint slider = {
      .offset = {.spring = JointSpring{.hertz = hertz_for(radians, scene), .damping_ratio = 0, .rest = 1}}};
  SceneJoint joint = scene::joined(scene, "spring", slider, 0, 1, {Vector3::Zero(), down});
  joint.def.frame_second = scene::seen_from(scene.bodies[1].def, {scene.bodies[1].def.position, down});
  scene.joints.push_back(joint);
  return scene;
}

double from_rest(const BodyState& state) { return (state.pose.position - Vector3(0, 0, -1)).norm(); }

// Two boxes far apart in mass on a stiff distance spring, turning about each other.
Scene unequal_pair(double radians) {
  constexpr double ratio = 1e4;
  Scene scene;
  scene.gravity.setZero();
  scene.bodies.push_back(scene::untouched(solid("heavy", Sphere{0.2}, {0, 0, 0}, scene::builtin_material)));
  scene.bodies.push_back(scene::untouched(solid("light", Sphere{0.2}, {1, 0, 0}, scene::builtin_material)));
  scene.bodies[0].def.mass = ratio;
  scene.bodies[1].def.mass = 1;
  scene.bodies[1].def.velocity = {0, 1, 0};
  const DistanceJoint rod = {.distance = {.range = {}, .spring = JointSpring{.hertz = hertz_for(radians, scene)}}};
  SceneJoint joint = scene::joined(scene, "spring", rod, 0, 1, {});
  joint.def.frame_first = joint.def.frame_second = {};
  std::get<DistanceJoint>(joint.def.kind).distance.spring->rest = 1;
  scene.joints.push_back(joint);
  return scene;
}

}  // namespace

void add_springs(CaseList& cases) {
  for (const double radians : {1.0, 10.0, 100.0, 1000.0}) {
    const std::string turns = in_name(radians);
    // Sags by g / w^2, which is at most 0.2 mm; friction has no part in it.
    cases.push_back({.name = "spring-" + turns,
                     .what = "weight on an undamped spring of " + turns + " rad a substep, let go 0.1 m from its rest",
                     .build = [radians] { return weight_on_spring(radians); },
                     .steps = 300,
                     .criteria = {peak_of("amplitude", "m", 1.001 * stretch + 2e-4, 1, from_rest),
                                  peak_of("speed", "m/s", 1.01 * stretch * radians * 240, 1,
                                          [](const BodyState& state) { return state.velocity.norm(); })}});
    cases.push_back({.name = "spring-pair-" + turns,
                     .what = "masses of 10000 to 1 that circle on a spring of " + turns + " rad a substep",
                     .build = [radians] { return unequal_pair(radians); },
                     .steps = 300,
                     .criteria = {energy_gain(1e-2), angular_momentum_change(1e-2),
                                  peak_of("stretch", "m", 1e-2, 1, [](const BodyState& state) {
                                    return std::abs(state.pose.position.norm() - 1);
                                  })}});
    cases.push_back({.name = "contact-hertz-" + turns,
                     .what = "stack of five with contact_hertz of " + turns + " rad a substep",
                     .build =
                         [radians] {
                           Scene scene = tower(5);
                           scene.settings.contact_hertz = hertz_for(radians, scene);
                           return scene;
                         },
                     .steps = 300,
                     .criteria = radians > 1 ? std::vector{penetration(1e-3), drift(1e-2)} : stands_softly()});
  }
}

}  // namespace atl::stability
